# Writes the bytes of IMAGE, MAP, BOOT and BOOT_MAP as C++ arrays into OUTPUT.
function(array name file)
  file(READ ${file} hex HEX)
  string(LENGTH "${hex}" digits)
  math(EXPR size "${digits} / 2")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(REGEX REPLACE "(0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,)" "\\1\n" bytes "${bytes}")
  file(APPEND ${OUTPUT} "constexpr unsigned char ${name}[${size}] = {\n${bytes}\n};\n")
endfunction()

file(WRITE ${OUTPUT} "#include \"c40_programs/image.hpp\"

namespace c40_programs {
namespace {
")
array(image ${IMAGE})
array(source_map ${MAP})
array(boot_rom ${BOOT})
array(boot_rom_source_map ${BOOT_MAP})
file(APPEND ${OUTPUT} "}  // namespace

std::span<const std::byte> built_in_image() { return std::as_bytes(std::span(image)); }
std::span<const std::byte> built_in_source_map() { return std::as_bytes(std::span(source_map)); }
std::span<const std::byte> built_in_boot_rom() { return std::as_bytes(std::span(boot_rom)); }
std::span<const std::byte> built_in_boot_rom_source_map() { return std::as_bytes(std::span(boot_rom_source_map)); }

}  // namespace c40_programs
")

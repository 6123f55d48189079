# Writes the images and source maps in FROM as C++ arrays into OUTPUT.
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
foreach(name dsp dsp_own_blocks boot_rom)
  array(${name}_out ${FROM}/${name}.out)
  array(${name}_map ${FROM}/${name}.map)
endforeach()
file(APPEND ${OUTPUT} "std::span<const std::byte> either(bool own_blocks, std::span<const unsigned char> with, std::span<const unsigned char> without) {
  return std::as_bytes(own_blocks ? with : without);
}

}  // namespace

std::span<const std::byte> built_in_image(bool own_blocks) { return either(own_blocks, dsp_own_blocks_out, dsp_out); }
std::span<const std::byte> built_in_source_map(bool own_blocks) { return either(own_blocks, dsp_own_blocks_map, dsp_map); }
std::span<const std::byte> built_in_boot_rom() { return std::as_bytes(std::span(boot_rom_out)); }
std::span<const std::byte> built_in_boot_rom_source_map() { return std::as_bytes(std::span(boot_rom_map)); }

}  // namespace c40_programs
")

# Writes the bytes of INPUT as a C++ array into OUTPUT.
file(READ ${INPUT} hex HEX)
string(LENGTH "${hex}" digits)
math(EXPR size "${digits} / 2")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
string(REGEX REPLACE "(0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,)" "\\1\n" bytes "${bytes}")
file(WRITE ${OUTPUT} "#include \"c40_programs/image.hpp\"

namespace c40_programs {
namespace {
constexpr unsigned char image[${size}] = {
${bytes}
};
}  // namespace

std::span<const std::byte> built_in_image() { return std::as_bytes(std::span(image)); }

}  // namespace c40_programs
")

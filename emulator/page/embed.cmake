# Writes PAGE as C++ string literals into OUTPUT, of a length that compilers take.
file(READ ${PAGE} hex HEX)
string(LENGTH "${hex}" digits)
math(EXPR size "${digits} / 2")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
string(REGEX REPLACE "(0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,0x..,)" "\\1\n" bytes "${bytes}")
file(WRITE ${OUTPUT} "#include \"page/embedded.hpp\"

namespace page {
namespace {
constexpr unsigned char bytes[${size}] = {
${bytes}
};
}  // namespace

std::string_view embedded_page() { return {reinterpret_cast<const char*>(bytes), sizeof bytes}; }

}  // namespace page
")

// COFF files: a file that is read can be shown, and writing it again keeps its meaning.

#include "toolchain/objects/coff.hpp"
#include "fuzz/target.hpp"
#include "toolchain/disassembler/disassembly.hpp"

namespace {

using toolchain::Object;

void expect_same(const Object& first, const Object& second) {
  fuzz::expect(first.executable == second.executable, "the rewrite is of another kind");
  fuzz::expect(!first.executable || first.entry == second.entry, "the rewrite has another entry");
  fuzz::expect(first.sections.size() == second.sections.size(), "the rewrite has other sections");
  for (std::size_t n = 0; n < first.sections.size(); ++n) {
    const auto &a = first.sections[n], &b = second.sections[n];
    fuzz::expect(a.address == b.address && a.size == b.size && a.words == b.words && a.loaded == b.loaded,
                 "section " + std::to_string(n) + " differs in the rewrite");
    fuzz::expect(a.relocations.size() == b.relocations.size(), "the rewrite has other relocations");
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes = std::as_bytes(std::span(data, size));
  Object object;
  if (!fuzz::done<toolchain::CoffError>([&] { object = toolchain::read_object(bytes, "input"); })) return 0;
  toolchain::disassembly(object);
  if (object.executable) {
    toolchain::Image image;
    if (fuzz::done<toolchain::CoffError>([&] { image = toolchain::read_coff(bytes, "input"); })) {
      toolchain::disassembly(image);
      toolchain::source_of(image);
    }
  }
  std::vector<std::byte> rewritten;
  // Documented: std::runtime_error for what the version cannot hold.
  if (!fuzz::done<std::runtime_error>([&] { rewritten = toolchain::coff_bytes(object); })) return 0;
  expect_same(object, toolchain::read_object(rewritten, "rewrite"));
  return 0;
}

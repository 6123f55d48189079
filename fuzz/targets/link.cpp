// The linker: a memory map, four dashes, and a library whose members are linked, the first as an object of its own.
#include "fuzz/target.hpp"
#include "toolchain/linker/linker.hpp"
#include "toolchain/objects/archive.hpp"
#include "toolchain/objects/coff.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  toolchain::MemoryMap map = toolchain::MemoryMap::standard();
  const std::string_view text = input.part();
  if (!text.empty() && !fuzz::done<toolchain::MemoryMapError>([&] { map = toolchain::parse_memory_map(text, "map"); }))
    return 0;
  std::vector<toolchain::Object> objects, library;
  const bool read = fuzz::done<toolchain::CoffError>([&] {
    if (!toolchain::is_archive(input.bytes()))
      return objects.push_back(toolchain::read_object(input.bytes(), "object"));
    for (const toolchain::ArchiveMember& member : toolchain::archive_members(input.bytes(), "library"))
      (objects.empty() ? objects : library).push_back(toolchain::read_object(member.bytes, member.name));
  });
  if (!read || objects.empty()) return 0;
  // A map may ask for gigabytes of reserved words; loaded ones come from the input.
  toolchain::Linked linked;
  if (!fuzz::done<toolchain::LinkError, toolchain::CoffError>([&] { linked = toolchain::link(objects, library, map); }))
    return 0;
  std::vector<std::byte> written;
  if (!fuzz::done<std::runtime_error>([&] { written = toolchain::coff_bytes(linked.image); })) return 0;
  const toolchain::Image again = toolchain::read_coff(written, "written");
  fuzz::expect(again.entry == linked.image.entry, "the entry changes when a program is written and read");
  fuzz::expect(again.sections.size() == linked.image.sections.size(),
               "sections change when a program is written and read");
  return 0;
}

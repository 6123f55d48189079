#include "c40/peripherals/register_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "c40/peripherals/comm_port.hpp"
#include "c40/peripherals/dma_registers.hpp"
#include "c40/peripherals/memory_interface.hpp"
#include "c40/peripherals/timer.hpp"
#include "io/nearest.hpp"
#include "isa/ascii.hpp"

namespace c40 {
namespace {

constexpr Address base = 0x00100000u;
constexpr Word interface_after_reset = 0x3E39FFF0u;

constexpr std::array interface_fields = [] {
  using namespace memory_interface;
  return std::array{
      CE0,         CE1,        DE, AE, STRB0_SWW, STRB1_SWW, STRB0_WTCNT, STRB1_WTCNT, STRB0_PAGESIZE, STRB1_PAGESIZE,
      STRB_ACTIVE, STRB_SWITCH};
}();
constexpr std::array timer_fields = [] {
  using namespace timer_control;
  return std::array{FUNC, IO, DATOUT, DATIN, GO, HLD, CP, CLKSRC, INV, TSTAT, DEBUG};
}();
constexpr std::array port_fields{cpcr::PORT_DIR, cpcr::ICH, cpcr::OCH, cpcr::OUTPUT_LEVEL, cpcr::INPUT_LEVEL};
constexpr std::array dma_fields = [] {
  using namespace dma_control;
  return std::array{PRI,        MODE,          AUX_MODE,          SYNC_READ,    SYNC_WRITE,    STATIC,
                    AUX_STATIC, AUTOINIT_SYNC, AUX_AUTOINIT_SYNC, READ_BIT_REV, WRITE_BIT_REV, SPLIT,
                    COM_PORT,   TCC,           AUX_TCC,           TCINT,        AUX_TCINT,     START,
                    AUX_START,  STATUS,        AUX_STATUS,        PRIORITY_MODE};
}();

/// One register of a group of equal groups: its place in the group, and everything else.
struct Member {
  Address offset;
  std::string_view name, meaning;
  std::span<const Field> fields;
  FieldAccess access = FieldAccess::read_write;
};
constexpr std::array timer_members{
    Member{0, "control", "global control", timer_fields},
    Member{4, "counter", "counts up to the period", {}},
    Member{8, "period", "ticks from one event to the next", {}},
};
constexpr std::array port_members{
    Member{0, "control", "port control, CPCR", port_fields},
    Member{1, "input", "a read takes the oldest word; waits while the FIFO is empty", {}, FieldAccess::read_only},
    Member{2, "output", "a write adds a word; waits while the FIFO is full", {}, FieldAccess::write_only},
};
constexpr std::array dma_members{
    Member{0, "control", "channel control", dma_fields},
    Member{1, "source", "source address", {}},
    Member{2, "source_index", "added to the source address", {}},
    Member{3, "counter", "words to go (split mode: of the primary channel)", {}},
    Member{4, "destination", "destination address", {}},
    Member{5, "destination_index", "added to the destination address", {}},
    Member{6, "link", "address of the next list of register values", {}},
    Member{7, "auxiliary_counter", "split mode: words to go of the auxiliary channel", {}},
    Member{8, "auxiliary_link", "split mode: the auxiliary channel's list", {}},
};

std::vector<RegisterInfo> make_map() {
  std::vector<RegisterInfo> all{{base + 0x00, "GMICR", "global memory interface control", interface_fields,
                                 FieldAccess::read_write, interface_after_reset, "1.4"},
                                {base + 0x04, "LMICR", "local memory interface control", interface_fields,
                                 FieldAccess::read_write, interface_after_reset, "1.4"}};
  const auto group = [&all](std::string_view name, int number, Address at, std::span<const Member> members,
                            std::string_view source) {
    for (const Member& m : members)
      all.push_back({base + at + m.offset, fmt::format("{}{}.{}", name, number, m.name), m.meaning, m.fields, m.access,
                     0, source});
  };
  for (int n = 0; n < timer_count; ++n) group("TIMER", n, 0x20 + 0x10 * static_cast<Address>(n), timer_members, "4");
  for (int n = 0; n < port_count; ++n) {
    group("PORT", n, 0x40 + 0x10 * static_cast<Address>(n), port_members, "2.1");
    if (!CommPort::token_after_reset(n)) all[all.size() - port_members.size()].reset = cpcr::PORT_DIR.mask();
  }
  for (int n = 0; n < dma_channel_count; ++n)
    group("DMA", n, 0xA0 + 0x10 * static_cast<Address>(n), dma_members, "3.1");
  return all;
}

std::string folded(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c == ' ' ? '_' : ascii::lower(c);
  return out;
}

std::string_view name(FieldAccess access) {
  constexpr std::array<std::string_view, 3> names{"read, write", "read", "write"};
  return names[static_cast<std::size_t>(access)];
}

std::string bits(const Field& field) {
  return field.width == 1 ? fmt::format("{}", field.low) : fmt::format("{}-{}", field.low + field.width - 1, field.low);
}

}  // namespace

std::span<const RegisterInfo> register_map() {
  static const std::vector<RegisterInfo> all = make_map();
  return all;
}

const RegisterInfo* register_at(Address address) {
  const auto all = register_map();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const RegisterInfo& info) { return info.address == address; });
  return found == all.end() ? nullptr : &*found;
}

const RegisterInfo& register_named(std::string_view name) {
  const auto all = register_map();
  const std::string wanted = folded(name);
  std::vector<std::string> known;
  for (const RegisterInfo& info : all) known.push_back(folded(info.name));
  const auto index_of = [&](std::string_view word) {
    return static_cast<std::size_t>(std::find(known.begin(), known.end(), word) - known.begin());
  };
  if (const std::size_t found = index_of(wanted); found < known.size()) return all[found];
  const std::size_t near = index_of(io::nearest(wanted, known, io::most_wrong(wanted)));
  throw std::out_of_range(
      fmt::format("no peripheral register is called {}; {}", name,
                  near < known.size() ? io::meant(all[near].name) : "docs/peripherals.md lists the registers"));
}

std::string describe_register(Address address) {
  const Address offset = address - base;
  const RegisterInfo* info = register_at(address);
  const std::string name = info != nullptr ? fmt::format("{}, a register", info->name) : "a reserved register";
  if (offset < 0x10) return info != nullptr ? info->name : "a reserved peripheral address";
  if (offset < 0x14) return "a register of the analysis block";
  if (offset >= 0x20 && offset < 0x40) return fmt::format("{} of timer {}", name, (offset - 0x20) >> 4);
  if (offset >= 0x40 && offset < 0xA0) return fmt::format("{} of communication port {}", name, (offset - 0x40) >> 4);
  if (offset >= 0xA0 && offset < 0x100) return fmt::format("{} of DMA channel {}", name, (offset - 0xA0) >> 4);
  return "a reserved peripheral address";
}

std::string register_page() {
  std::string page = "| address | register | access | after reset | |\n|---|---|---|---|---|\n";
  for (const RegisterInfo& info : register_map())
    page += fmt::format("| {:08X}h | {} | {} | {:08X}h | {} |\n", info.address, info.name, name(info.access),
                        info.reset, info.meaning);
  const auto fields = [&page](std::string_view title, const RegisterInfo& info) {
    page += fmt::format("\n### {}\n\nSource: c40-hardware.md {}.\n\n| bits | field | access | |\n|---|---|---|---|\n",
                        title, info.source);
    for (const Field& field : info.fields)
      page += fmt::format("| {} | {} | {} | {} |\n", bits(field), field.name, name(field.access), field.meaning);
  };
  fields("GMICR, LMICR", register_named("GMICR"));
  fields("TIMERn.control", register_named("TIMER0.control"));
  fields("PORTn.control", register_named("PORT0.control"));
  fields("DMAn.control", register_named("DMA0.control"));
  return page;
}

}  // namespace c40

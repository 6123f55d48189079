#include "machine/program_text/address_names.hpp"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <string_view>
#include <utility>

namespace machine {
namespace {

/// A table of equal records in window A; the names of their words begin with a prefix.
struct Records {
  std::string_view name;    ///< the text before the number of the record
  std::string_view base;    ///< symbol: offset of record 0 on bus A
  std::string_view words;   ///< symbol: words of a record
  unsigned count;           ///< records with names of their own
  std::string_view prefix;  ///< prefix of the symbols of offsets in the record; empty: there are none
};
constexpr std::array records{
    Records{"TB", "BLOCK_POOL", "BLOCK_WORDS", 64, "TB_"}, Records{"CR", "CR_BASE", "CR_WORDS", 1, "CR_"},
    Records{"AG", "AG_BASE", "AG_WORDS", 16, "AG_"},       Records{"US", "US_BASE", "US_WORDS", 8, ""},
    Records{"SV", "SV_BASE", "SV_WORDS", 17, ""},
};

/// RAM on chip after the constants, with the names of onchip.inc. Each kernel has its own names for its scratch words,
/// so these are SCRATCH and an offset.
constexpr std::array<std::string_view, 8> on_chip{"TASK",       "EXEC_BLOCK", "EXEC_SLOT", "EXEC_POLICY",
                                                  "EXEC_PAUSE", "MATH",       "STACK",     "SCRATCH"};

/// Single words of a window; the symbols are offsets on the window's bus.
constexpr std::array<std::string_view, 13> alone_on_a{
    "LIST_WORK_POINTER", "LIST_REFRESH",   "SLICE_CYCLES",  "ER_BASE",       "SEMAPHORE",
    "SEMAPHORE_OWNER",   "SEMAPHORE_HELD", "DOORBELL_RING", "DOORBELL_IDLE", "DOORBELL_BUSY",
    "FENCE_MASK",        "RESET_DSP",      "LINK_ADAPTER"};
constexpr std::array<std::string_view, 14> alone_on_b{
    "DRIVE_TORQUE",    "DRIVE_ENABLE", "ENCODER",     "SWAY_ALPHA", "SWAY_BETA",    "LOAD_CELL", "SPREADER_COMMAND",
    "SPREADER_STATUS", "DRIVE_STATUS", "DRIVE_SPEED", "SCAN_ROWS",  "SCAN_PROFILE", "AGV_UNIT",  "AGV_RANGE"};

/// Words of a window that have names. The number is small, so that a number that is not an address rarely looks like
/// one.
constexpr Address window_a_words = 0x20000, window_b_words = 0x2000;

}  // namespace

AddressNames::Region& AddressNames::add(std::string name, Address base, Address words) {
  return regions_.insert_or_assign(base, Region{std::move(name), words, {}}).first->second;
}

AddressNames::AddressNames(const toolchain::Image& image) {
  for (const toolchain::Image::Section& section : image.sections) {
    Region& region = add(section.name, section.address, section.size);
    for (const auto& [name, value] : image.names())
      if (value - section.address < section.size && !name.starts_with('.')) region.labels.emplace(value, name);
  }
}

AddressNames AddressNames::of_dock(const toolchain::Image& image) {
  AddressNames out(image);
  for (const auto& [region, words] : {std::pair{"CONSTANTS", "CONSTANTS_MAX"}, std::pair{"KEPT", "KEPT_WORDS"}}) {
    const Address base = image.symbol(region);
    Region& named = out.add(region, base, image.symbol(words));
    for (const auto& [name, value] : image.symbols)
      if (value - base < named.words) named.labels.emplace(value, name);
  }
  const Address task = image.symbol("TASK");
  Region& ram = out.add("TASK", task, image.symbol("SCRATCH") + image.symbol("SCRATCH_WORDS") - task);
  for (const std::string_view name : on_chip) ram.labels.emplace(image.symbol(name), name);
  const Address window = image.symbol("WINDOW_A");
  Region& a = out.add("A", window, window_a_words);
  for (const std::string_view name : alone_on_a) a.labels.emplace(window + image.symbol(name), name);
  for (const Records& table : records) {
    const Address words = image.symbol(table.words);
    for (unsigned i = 0; i < table.count; ++i) {
      const std::string number = table.count > 1 ? fmt::format("{}{}", table.name, i) : std::string(table.name);
      const Address at = window + image.symbol(table.base) + i * words;
      if (!table.prefix.empty())
        for (auto symbol = image.symbols.lower_bound(table.prefix);
             symbol != image.symbols.end() && symbol->first.starts_with(table.prefix); ++symbol)
          if (symbol->second < words && symbol->first != table.base && symbol->first != table.words)
            a.labels.emplace(at + symbol->second, table.count > 1 ? number + "." + symbol->first : symbol->first);
      a.labels.emplace(at, number);
    }
    a.labels.emplace(window + image.symbol(table.base) + table.count * words, "");
  }
  Region& b = out.add("B", image.symbol("WINDOW_B"), window_b_words);
  for (const std::string_view name : alone_on_b) b.labels.emplace(image.symbol("WINDOW_B") + image.symbol(name), name);
  return out;
}

std::optional<std::string> AddressNames::name(Address address) const {
  auto found = regions_.upper_bound(address);
  if (found == regions_.begin()) return std::nullopt;
  const auto& [base, region] = *--found;
  if (address - base > region.words) return std::nullopt;  // a pointer may point directly behind the region
  const auto label = region.labels.upper_bound(address);
  const bool labelled = label != region.labels.begin() && !std::prev(label)->second.empty();
  const Address from = labelled ? std::prev(label)->first : base;
  const std::string& start = labelled ? std::prev(label)->second : region.name;
  return address == from ? start : fmt::format("{}+0x{:X}", start, address - from);
}

std::optional<Address> AddressNames::address(std::string_view label) const {
  for (const auto& [base, region] : regions_)
    for (const auto& [at, name] : region.labels)
      if (!name.empty() && name == label) return at;
  return std::nullopt;
}

std::string AddressNames::text(Address address) const { return name(address).value_or(fmt::format("{:08X}", address)); }

}  // namespace machine

#include "toolchain/encoder/mnemonics.hpp"

#include <fmt/format.h>

#include <array>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "io/nearest.hpp"
#include "toolchain/syntax/parser.hpp"

namespace toolchain {
namespace {

using isa::Cpu;
using isa::Format;
using isa::Operation;
using isa::Row;
using Names = std::vector<std::string>;

/// The name, and the name without the 3 of three-operand instructions.
Names with_optional_three(const Row& row, std::string_view name) {
  Names out{std::string(name)};
  const bool three = row.format == Format::three_type1 || row.format == Format::three_type2 || row.parallel();
  if (three && name.ends_with('3')) out.emplace_back(name.substr(0, name.size() - 1));
  return out;
}

/// B = BU, RETS = RETSU and so on; CALL and LAJ without a condition are other instructions.
bool condition_may_be_omitted(const Row& row) {
  switch (row.operation) {
    case Operation::branch:
    case Operation::db:
    case Operation::rets:
    case Operation::reti:
    case Operation::trap:
    case Operation::lat: return true;
    default: return false;
  }
}

class Catalogue {
 public:
  explicit Catalogue(Cpu cpu) {
    for (const Row& row : isa::rows(cpu)) {
      if (row.parallel())
        add_parallel(row);
      else if (row.conditional())
        add_conditional(row);
      else
        for (const auto& name : with_optional_three(row, row.mnemonic)) add(name, {&row});
      if (row.format == Format::store_constant) add("sti", {&row});
    }
  }

  const std::vector<Candidate>& find(const std::string& key) const {
    static const std::vector<Candidate> none;
    const auto found = map_.find(key);
    return found == map_.end() ? none : found->second;
  }

  bool is_half(std::string_view name) const { return halves_.contains(name); }

  std::string nearest(std::string_view name) const {
    std::string best;
    for (const auto& [known, unused] : map_)
      if (best.empty() && known.find('|') == std::string::npos && io::edit_distance(name, known, 1) == 1) best = known;
    return best;
  }

 private:
  void add(const std::string& name, Candidate candidate) { map_[name].push_back(candidate); }

  void add_conditional(const Row& row) {
    const auto place = row.mnemonic.find('?');
    const auto with = [&](std::string_view condition) {
      return std::string(row.mnemonic.substr(0, place)) + std::string(condition) +
             std::string(row.mnemonic.substr(place + 1));
    };
    for (const auto condition : isa::condition_name_list())
      add(with(condition), {&row, *isa::condition_named(condition)});
    if (condition_may_be_omitted(row)) add(with(""), {&row});
  }

  void add_pair(const std::string& first, const std::string& second, Candidate candidate) {
    halves_.insert(first);
    halves_.insert(second);
    add(first + "||" + second, candidate);
  }

  void add_parallel(const Row& row) {
    const std::string first(row.mnemonic), second(row.mnemonic2);
    if (row.format == Format::load_load || row.format == Format::store_store) {
      // Number 2 is the half in bits 7..0 and 24..22, which comes first in unnumbered text.
      add_pair(first, second, {&row});
      add_pair(first + "2", second + "1", {&row});
      add_pair(first + "1", second + "2", {.row = &row, .exchanged = true});
      return;
    }
    for (const auto& a : with_optional_three(row, first))
      for (const auto& b : with_optional_three(row, second)) {
        add_pair(a, b, {&row});
        add_pair(b, a, {.row = &row, .exchanged = true});
      }
  }

  std::map<std::string, std::vector<Candidate>, std::less<>> map_;
  std::set<std::string, std::less<>> halves_;
};

const Catalogue& catalogue(Cpu cpu) {
  static const Catalogue c40(Cpu::c40), c3x(Cpu::c3x);
  return cpu == Cpu::c40 ? c40 : c3x;
}

using Counterpart = std::pair<std::string_view, std::string_view>;

std::string_view counterpart(std::span<const Counterpart> pairs, std::string_view name) {
  for (const auto& [one, other] : pairs)
    if (one == name) return other;
  return {};
}

// What a processor has instead of a register or an instruction of the other one.
constexpr std::array<Counterpart, 3> registers_of_c40{
    {{"ie", "IIE, and DIE for the DMA"}, {"if", "IIF"}, {"iof", "IIF"}}};
constexpr std::array<Counterpart, 5> registers_of_c3x{{{"die", "IE"},
                                                       {"iie", "IE"},
                                                       {"iif", "IF and IOF"},
                                                       {"ivtp", "interrupt vectors at a fixed place"},
                                                       {"tvtp", "trap vectors at a fixed place"}}};
constexpr std::array<Counterpart, 2> mnemonics_of_c40{{{"lopower", "IDLE2"}, {"maxspeed", "no slower clock to leave"}}};
constexpr std::array<Counterpart, 13> mnemonics_of_c3x{{{"lda", "LDI"},
                                                        {"ldpk", "LDP"},
                                                        {"ldhi", "LDI, LSH and OR"},
                                                        {"stik", "STI of a register"},
                                                        {"laj", "CALL"},
                                                        {"lat", "TRAP"},
                                                        {"rptbd", "RPTB"},
                                                        {"retid", "RETI"},
                                                        {"ldep", "no expansion registers"},
                                                        {"ldpe", "no expansion registers"},
                                                        {"sigi", "SIGI without operands"},
                                                        {"mpyshi", "MPYI of 24 bits"},
                                                        {"mpyuhi", "MPYI of 24 bits"}}};

std::string belongs_to_other(std::string_view name, std::string_view what, Cpu cpu, std::string_view instead) {
  const Cpu other = other_than(cpu);
  return fmt::format("{} is {} of the {}; the {} has {}{}", name, what, isa::title(other), isa::title(cpu),
                     instead.empty() ? "no counterpart" : instead,
                     cpu == Cpu::c40 ? " (--cpu c3x assembles for the C3x)" : "");
}

}  // namespace

Cpu other_than(Cpu cpu) { return cpu == Cpu::c40 ? Cpu::c3x : Cpu::c40; }

const std::vector<Candidate>& candidates(std::string_view name, Cpu cpu) {
  return catalogue(cpu).find(std::string(name));
}

const std::vector<Candidate>& pair_candidates(std::string_view first, std::string_view second, Cpu cpu) {
  return catalogue(cpu).find(fmt::format("{}||{}", first, second));
}

bool is_parallel_name(std::string_view name, Cpu cpu) { return catalogue(cpu).is_half(name); }

std::string register_of_other(std::string_view name, Cpu cpu) {
  const auto found = isa::register_named(name, other_than(cpu));
  const bool expansion = cpu == Cpu::c3x && isa::expansion_named(name);
  if ((!found && !expansion) || isa::register_named(name, cpu)) return {};
  const auto pairs =
      cpu == Cpu::c40 ? std::span<const Counterpart>(registers_of_c40) : std::span<const Counterpart>(registers_of_c3x);
  const std::string_view instead = counterpart(pairs, lower(name));
  return ": " + belongs_to_other(name, "a register", cpu, instead.empty() ? "R0 to R7" : instead);
}

std::string mnemonic_of_other(std::string_view name, Cpu cpu) {
  if (candidates(name, other_than(cpu)).empty() && !is_parallel_name(name, other_than(cpu))) return {};
  const auto pairs =
      cpu == Cpu::c40 ? std::span<const Counterpart>(mnemonics_of_c40) : std::span<const Counterpart>(mnemonics_of_c3x);
  return belongs_to_other(fmt::format("'{}'", name), "an instruction", cpu, counterpart(pairs, lower(name)));
}

std::string suggestion(std::string_view name, Cpu cpu) { return io::suggestion(catalogue(cpu).nearest(name), '\''); }

}  // namespace toolchain

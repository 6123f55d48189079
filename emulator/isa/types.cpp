#include "isa/types.hpp"
#include "isa/ascii.hpp"

#include <array>

namespace isa {
namespace {

constexpr std::array<std::string_view, 32> register_names{
    "r0", "r1",  "r2",  "r3", "r4", "r5", "r6",  "r7",  "ar0", "ar1", "ar2", "ar3", "ar4", "ar5", "ar6", "ar7",
    "dp", "ir0", "ir1", "bk", "sp", "st", "die", "iie", "iif", "rs",  "re",  "rc",  "r8",  "r9",  "r10", "r11"};

constexpr std::array<std::string_view, 3> c3x_names{"ie", "if", "iof"};  // The names that begin with DIE's code.

struct ConditionName {
  std::string_view name;
  Condition condition;
};

// The first name of a condition is the printed one.
constexpr std::array condition_names{
    ConditionName{"u", Condition::U},     ConditionName{"lo", Condition::LO},     ConditionName{"c", Condition::LO},
    ConditionName{"ls", Condition::LS},   ConditionName{"hi", Condition::HI},     ConditionName{"hs", Condition::HS},
    ConditionName{"nc", Condition::HS},   ConditionName{"eq", Condition::EQ},     ConditionName{"z", Condition::EQ},
    ConditionName{"ne", Condition::NE},   ConditionName{"nz", Condition::NE},     ConditionName{"lt", Condition::LT},
    ConditionName{"n", Condition::LT},    ConditionName{"l", Condition::LT},      ConditionName{"le", Condition::LE},
    ConditionName{"gt", Condition::GT},   ConditionName{"p", Condition::GT},      ConditionName{"ge", Condition::GE},
    ConditionName{"nn", Condition::GE},   ConditionName{"nv", Condition::NV},     ConditionName{"v", Condition::V},
    ConditionName{"nuf", Condition::NUF}, ConditionName{"uf", Condition::UF},     ConditionName{"nlv", Condition::NLV},
    ConditionName{"lv", Condition::LV},   ConditionName{"nluf", Condition::NLUF}, ConditionName{"luf", Condition::LUF},
    ConditionName{"zuf", Condition::ZUF},
};

constexpr auto condition_names_only = [] {
  std::array<std::string_view, condition_names.size()> out{};
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = condition_names[i].name;
  return out;
}();

}  // namespace

std::span<const std::string_view> condition_name_list() { return condition_names_only; }

std::string_view name(Cpu cpu) { return cpu == Cpu::c40 ? "c40" : "c3x"; }

std::string_view title(Cpu cpu) { return cpu == Cpu::c40 ? "C40" : "C3x"; }

std::optional<Cpu> cpu_named(std::string_view text) {
  for (const Cpu cpu : {Cpu::c40, Cpu::c3x})
    if (text == name(cpu)) return cpu;
  return std::nullopt;
}

std::string_view name(Register r, Cpu cpu) {
  const std::size_t place = code(r) - std::size_t{code(Register::DIE)};
  return cpu == Cpu::c3x && place < c3x_names.size() ? c3x_names[place] : register_names[code(r)];
}

std::string_view name(Expansion r) { return r == Expansion::IVTP ? "ivtp" : "tvtp"; }

std::string_view name(Condition c) {
  for (const auto& entry : condition_names)
    if (entry.condition == c) return entry.name;
  return "?";
}

std::optional<Register> register_named(std::string_view text, Cpu cpu) {
  for (std::size_t i = 0; i < register_names.size(); ++i) {
    if (!has(cpu, static_cast<Register>(i))) break;
    const auto register_name = name(static_cast<Register>(i), cpu);
    if (ascii::same(register_name, text)) return static_cast<Register>(i);
    const bool float_synonym = register_name[0] == 'r' && ascii::is_digit(register_name[1]);
    if (float_synonym && !text.empty() && (text[0] == 'f' || text[0] == 'F') &&
        ascii::same(register_name.substr(1), text.substr(1)))
      return static_cast<Register>(i);
  }
  return std::nullopt;
}

std::optional<Expansion> expansion_named(std::string_view text) {
  if (ascii::same("ivtp", text)) return Expansion::IVTP;
  if (ascii::same("tvtp", text)) return Expansion::TVTP;
  return std::nullopt;
}

std::optional<Condition> condition_named(std::string_view text) {
  for (const auto& entry : condition_names)
    if (ascii::same(entry.name, text)) return entry.condition;
  return std::nullopt;
}

}  // namespace isa

#pragma once
// Registers and conditions of the TMS320C4x, with the names and numbers of its user's guide, and the
// differences of the TMS320C3x (c40-isa.md 9).
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "isa/word.hpp"

namespace isa {

std::string_view name(Cpu cpu);                       ///< As in options: "c40", "c3x".
std::string_view title(Cpu cpu);                      ///< As in sentences: "C40", "C3x".
std::optional<Cpu> cpu_named(std::string_view text);  ///< By name().
/// The number of addresses of the processor. The C3x's addresses have 24 bits.
constexpr std::uint64_t address_space(Cpu cpu) { return std::uint64_t{1} << (cpu == Cpu::c40 ? 32 : 24); }

// clang-format off
/// The primary register file; the value is the 5-bit code of every register field (c40-isa.md 1.1). On the C3x DIE, IIE
/// and IIF are IE, IF and IOF, and there is no R8 to R11.
enum class Register : std::uint8_t {
  R0, R1, R2, R3, R4, R5, R6, R7,
  AR0, AR1, AR2, AR3, AR4, AR5, AR6, AR7,
  DP, IR0, IR1, BK, SP, ST, DIE, IIE, IIF, RS, RE, RC,
  R8, R9, R10, R11,
};
// clang-format on
inline constexpr int register_count = 32;

/// The expansion register file, reached by LDEP and LDPE only (c40-isa.md 1.2).
enum class Expansion : std::uint8_t { IVTP, TVTP };

// clang-format off
/// Condition codes (c40-isa.md 4); 11 and 21 to 31 are reserved.
enum class Condition : std::uint8_t {
  U, LO, LS, HI, HS, EQ, NE, LT, LE, GT, GE,
  NV = 12, V, NUF, UF, NLV, LV, NLUF, LUF, ZUF,
};
// clang-format on

constexpr std::uint8_t code(Register r) { return static_cast<std::uint8_t>(r); }
constexpr std::uint8_t code(Condition c) { return static_cast<std::uint8_t>(c); }
constexpr Register address_register(unsigned n) { return static_cast<Register>(8 + (n & 7)); }

/// R0 to R11: 40 bits wide; only these hold floats.
constexpr bool is_extended(Register r) { return code(r) < 8 || code(r) >= 28; }
/// AR0-AR7, DP, IR0, IR1, BK, SP: the registers that LDA can load.
constexpr bool is_lda_destination(Register r) { return code(r) >= 8 && code(r) <= 20; }
constexpr bool is_condition(unsigned c) { return c <= 20 && c != 11; }

/// Whether the processor has the register.
constexpr bool has(Cpu cpu, Register r) { return cpu == Cpu::c40 || code(r) < 28; }

std::string_view name(Register r, Cpu cpu = Cpu::c40);  ///< Lower case: "r0", "ar3", "iie".
std::string_view name(Expansion r);                     ///< "ivtp", "tvtp".
std::string_view name(Condition c);                     ///< The first name of c40-isa.md 4: "u", "lo", "eq".

/// By any of its names, in any case; F0-F11 are names of R0-R11.
std::optional<Register> register_named(std::string_view text, Cpu cpu = Cpu::c40);
std::optional<Expansion> expansion_named(std::string_view text);
/// By any of its names, in any case ("eq", "Z", "hs", "NC"...).
std::optional<Condition> condition_named(std::string_view text);
/// Every name of every condition.
std::span<const std::string_view> condition_name_list();

}  // namespace isa

// Changes by hand: words and registers. Each begins a new branch of time.
#include "machine/debug/debugger.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "c40/values/float40.hpp"
#include "isa/ascii.hpp"
#include "isa/types.hpp"
#include "machine/debug/debugger_shared.hpp"
#include "machine/debug/expression.hpp"

namespace machine::debug {
namespace {

/// The 40 bits of the nearest number that a register can hold. \throws DebugError for a number that is too large
std::uint64_t float_bits(double value) {
  if (value == 0) return c40::float40::bits(c40::float40::zero());
  int exponent = 0;
  auto mantissa = std::llround(std::ldexp(std::frexp(value, &exponent), 32));
  --exponent;
  if (mantissa == c40::float40::one * 2) mantissa /= 2, ++exponent;
  if (mantissa == -c40::float40::one) mantissa *= 2, --exponent;
  if (!std::isfinite(value) || exponent < -127 || exponent > 127)
    throw DebugError(fmt::format("{:g} is beyond what a register holds", value));
  return c40::float40::bits(c40::float40::pack(exponent, mantissa));
}

}  // namespace

/// \param moved the chip whose PC is set
void Debugger::change(std::function<void()> by_hand, std::string text, std::optional<std::size_t> moved) {
  const auto make = [this, moved, by_hand = std::move(by_hand)] {
    by_hand();
    debuggee_.changed_by_hand(moved);
  };
  make();
  const bool future = history_->info().last > now() || changed_ < changes_.size();
  changes_.resize(changed_);
  changes_.push_back({now(), make});
  changed_ = changes_.size();
  history_->forget_after(now());
  past_.reset();
  if (output)
    output(fmt::format(
        "changed by hand at {}: {}{}", seconds(now()), text,
        future ? "; everything later is discarded: a new branch begins here" : "; a new branch begins here"));
}

void Debugger::set_word(std::size_t chip, Address address, Word value) {
  require_chip(chip);
  const auto make = [this, chip, address, value] { debuggee_.poke(chip, address, value); };
  try {
    change(make, fmt::format("{:08X}h of {} = {:08X}h", address, debuggee_.chip_name(chip), value));
  } catch (const std::out_of_range& error) {
    throw DebugError(error.what());
  }
}

void Debugger::set_register(std::size_t chip, std::string_view name, std::string_view expression) {
  require_chip(chip);
  const auto expansion = isa::expansion_named(name);
  const auto reg = isa::register_named(name);
  const bool is_pc = ascii::lower(name) == "pc";
  if (!expansion && !reg && !is_pc)
    throw DebugError(
        fmt::format("{} is not a register; PC, R0 to R11, AR0 to AR7, DP, IR0, IR1, BK, SP, ST, DIE, IIE, IIF, RS, RE, "
                    "RC, IVTP, TVTP are",
                    name));
  const Value value = Expression(expression, debuggee_, programs_, chip).value();
  if (value.is_float && !(reg && isa::is_extended(*reg)))
    throw DebugError(fmt::format("{} holds integers, and {} is a float", name, expression));
  if (!value.is_float && !value.is_word())
    throw DebugError(fmt::format("{} does not fit into {}: 32 bits do, signed or unsigned", expression, name));
  if (is_pc)
    if (const auto why = debuggee_.holds_pc(chip))
      throw DebugError(fmt::format("the PC of {} cannot be set: {}", debuggee_.chip_name(chip), *why));
  const auto make = [this, chip, reg, expansion, value] {
    c40::Chip& changed = debuggee_.chip(chip);
    const auto word = static_cast<Word>(value.integer);
    if (expansion) return changed.set_expansion(*expansion, word);
    if (!reg) return changed.set_pc(word);
    if (!isa::is_extended(*reg)) return changed.set_register(*reg, word);
    if (value.is_float) return changed.set_register(*reg, float_bits(value.real));
    // The exponent stays, as in an integer load.
    changed.set_register(*reg, (changed.register_value(*reg) & 0xFF00000000u) | word);
  };
  change(make, fmt::format("{} of {} = {}", name, debuggee_.chip_name(chip), value.text()),
         is_pc ? std::optional(chip) : std::nullopt);
}

std::size_t Debugger::changes() const { return changed_; }

}  // namespace machine::debug

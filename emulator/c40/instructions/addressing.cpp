#include "c40/instructions/addressing.hpp"

namespace c40::execute {
namespace {

/// Only one correction, and the sum is not masked again (c40-isa.md 3.9).
Word circular(Word ar, Word bk, std::int64_t step) {
  const Word mask = bk == 0 ? 0u : ~Word{0} >> std::countl_zero(bk);
  const std::int64_t index = ar & mask;
  std::int64_t t = index + step;
  if (t >= bk)
    t -= bk;
  else if (t < 0)
    t += bk;
  return (ar & ~mask) + static_cast<Word>(t);
}

}  // namespace

EffectiveAddress form_by_index(const Core& core, Word base, std::uint8_t modn, std::uint16_t displacement) {
  using isa::modn::Action, isa::modn::Index;
  if (modn == isa::modn::bit_reversed) return {base, reverse_bits(reverse_bits(base) + reverse_bits(core.r[reg::IR0]))};
  const Index index = isa::modn::index(modn);
  const Word step = index == Index::displacement ? displacement : core.r[index == Index::IR0 ? reg::IR0 : reg::IR1];
  switch (isa::modn::action(modn)) {
    case Action::add: return {base + step, base};
    case Action::subtract: return {base - step, base};
    case Action::pre_add: return {base + step, base + step};
    case Action::pre_subtract: return {base - step, base - step};
    case Action::post_add: return {base, base + step};
    case Action::post_subtract: return {base, base - step};
    case Action::post_add_circular: return {base, circular(base, core.r[reg::BK], step)};
    case Action::post_subtract_circular: return {base, circular(base, core.r[reg::BK], -std::int64_t{step})};
  }
  return {base, base};
}

}  // namespace c40::execute

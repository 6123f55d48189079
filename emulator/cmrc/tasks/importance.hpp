#pragma once
// Equation (7): the importance J of a task block, a pure function of its kind x, its robot class y and its waiting
// count t.
#include <cstdint>

namespace cmrc {

/// The readings of equation (7).
enum class Equation7 { restored, as_printed };

/// The parameters of equation (7) besides x, y and t: numbers of refreshes, and importances.
struct ImportanceParameters {
  Equation7 equation = Equation7::restored;
  std::int64_t n_servo = 8;   ///< N_p
  std::int64_t n_crane = 64;  ///< N_t
  std::int64_t n_agv = 160;   ///< N^_a of the block's AGV
  std::int64_t gamma = 0;
  std::int64_t alpha = 24;
  std::int64_t beta = 12;
  std::int64_t p = 0x4000;
  std::int64_t q = 0x2000;
  std::int64_t b = 0x100;
  std::int64_t a = 0x40;
};

/// J, 0..FFFFh, larger is earlier; 0 means that the block must not run yet. t counts refreshes; t and J saturate at
/// FFFFh. \throws std::invalid_argument for a kind that equation (7) does not rank.
std::uint32_t importance(const ImportanceParameters& parameters, std::uint32_t x, std::uint32_t y, std::int64_t t);

}  // namespace cmrc

#pragma once
// May-load as tokens (plant-and-bus.md 4.4, items 13 to 16): a process starts when every process that has to consent has.
//
//     from    to        from    to
//     2, 4    3         1, 4    7
//     3, 6    4         1, 5    8
//
// A consent is a one-place token. Those that belong to one AGV (6 to 4, 5 to 8) are kept per AGV.
#include <array>
#include <cstdint>
#include <vector>

namespace cmrc {

class Consents {
 public:
  explicit Consents(unsigned agvs);

  void give(unsigned source, unsigned target, unsigned agv = 0);
  void clear(unsigned source, unsigned target, unsigned agv = 0);
  bool given(unsigned source, unsigned target, unsigned agv = 0) const;
  /// Every source of `target` has consented (to AGV `agv`, where it matters).
  bool all(unsigned target, unsigned agv = 0) const;
  /// Takes the consents of all sources away: the process starts.
  void consume(unsigned target, unsigned agv = 0);

 private:
  static bool of_agv(unsigned source, unsigned target) { return (source == 6 && target == 4) || (source == 5 && target == 8); }

  std::vector<std::array<std::array<bool, 9>, 9>> tokens_;  // [agv][source][target]; others than of_agv at [0]
};

}  // namespace cmrc

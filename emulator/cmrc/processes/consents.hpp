#pragma once
// May-load as tokens (plant-and-bus.md 4.4, items 13 to 16): a process starts when every process that has to consent
// has.
//
// A consent is a one-place token, taken away when its target starts. Those that an AGV's process gives are kept per
// AGV. One that the crane's or nobody's process gives to an AGV's process holds for every AGV ("the job is done", 1 to
// 8), and stays until it is cleared.
#include <cstdint>
#include <vector>

#include "cmrc/processes/process_table.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

class Consents {
 public:
  Consents(const ProcessTable& table, unsigned agvs);

  void give(unsigned source, unsigned target, unsigned agv = 0) { token(source, target, agv) = 1; }
  void clear(unsigned source, unsigned target, unsigned agv = 0) { token(source, target, agv) = 0; }
  bool given(unsigned source, unsigned target, unsigned agv = 0) const;
  /// There is a process that has to consent, and every one has (to AGV `agv`, where it matters).
  bool all(unsigned target, unsigned agv = 0) const;
  /// Takes the consents of all sources away: the process starts.
  void consume(unsigned target, unsigned agv = 0);
  void list_state(state::Visitor& list);

 private:
  static constexpr unsigned numbers = 16;
  bool of_agv(unsigned process) const { return of_agv_.at(process); }
  std::size_t place(unsigned source, unsigned target, unsigned agv) const {
    return ((of_agv(source) ? agv : 0) * numbers + source) * numbers + target;
  }
  std::uint8_t& token(unsigned source, unsigned target, unsigned agv) { return tokens_.at(place(source, target, agv)); }

  std::vector<bool> of_agv_;
  std::vector<std::vector<unsigned>> sources_;  // [target]
  std::vector<std::uint8_t> tokens_;            // [agv][source][target]; of those that are not an AGV's at agv 0
};

}  // namespace cmrc

#pragma once
// May-load as tokens (plant-and-bus.md 4.4, items 13 to 16): a process starts when every process that has to consent
// has consented.
//
// A consent is a token for one place, removed when its target starts. Consents of an AGV's process are kept per AGV. A
// consent of the crane's process, or of a process without a robot, to an AGV's process is valid for every AGV ("the job
// is done", 1 to 8), and stays until it is cleared.
#include <cstdint>
#include <vector>

#include "cmrc/configuration/rows/process_table.hpp"

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
  /// Some process has to consent to `target`, and every such process has consented (for AGV `agv`, if the target is an
  /// AGV's).
  bool all(unsigned target, unsigned agv = 0) const;
  /// Removes the consents of all sources: the process starts.
  void consume(unsigned target, unsigned agv = 0);
  void list_state(state::Visitor& list);

 private:
  static constexpr unsigned numbers = most_processes + 1;
  bool of_agv(unsigned process) const { return of_agv_.at(process); }
  std::size_t place(unsigned source, unsigned target, unsigned agv) const {
    return ((of_agv(source) ? agv : 0) * numbers + source) * numbers + target;
  }
  std::uint8_t& token(unsigned source, unsigned target, unsigned agv) { return tokens_.at(place(source, target, agv)); }

  std::vector<bool> of_agv_;
  std::vector<std::vector<unsigned>> sources_;  // [target]
  std::vector<std::uint8_t> tokens_;            // [agv][source][target]; sources without an AGV use agv 0
};

}  // namespace cmrc

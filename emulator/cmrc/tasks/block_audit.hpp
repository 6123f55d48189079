#pragma once
// The life of every task block, checked during the run: each block has exactly one state and one owner at a time, and
// each loaded block ends once.
//
//     absent -> waiting -> taken -> done -> absent
//                  ^---------|        (put back by the watchdog)
//                            |-> absent (given up)
#include <cstdint>
#include <string>
#include <vector>

#include "report/events/event.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

class BlockAudit {
 public:
  void loaded(std::size_t block, report::Time at);
  void claimed(std::size_t block, unsigned slot, report::Time at);
  void finished(std::size_t block, unsigned slot, report::Time at);
  void put_back(std::size_t block, report::Time at);
  void removed(std::size_t block, report::Time at);
  void dropped(std::size_t block, report::Time at);

  /// A further rule that holds in every run; `what` says how it was broken.
  template <class What>
  void require(bool holds, report::Time at, What what) {
    ++checks_;
    if (!holds) violated(at, what());
  }

  std::uint64_t checks() const { return checks_; }
  /// The broken rules, at most the first hundred.
  const std::vector<std::string>& violations() const { return violations_; }
  void list_state(state::Visitor& list);

 private:
  enum class State : std::uint8_t { absent, waiting, taken, done };
  struct Block {
    State state = State::absent;
    unsigned owner = 0;
  };
  void pass(std::size_t block, State from, State to, report::Time at, const char* what);
  void violated(report::Time at, const std::string& what);
  void violated(std::size_t block, report::Time at, const std::string& what);
  Block& at(std::size_t block);

  std::vector<Block> blocks_;
  std::uint64_t checks_ = 0;
  std::vector<std::string> violations_;
};

}  // namespace cmrc

#pragma once
// The servo's parameters in shared memory, where PID reads them.
#include <cstddef>
#include <functional>
#include <vector>

#include "cmrc/configuration/dock/servo_law.hpp"
#include "cmrc/processes/host_services.hpp"
#include "cmrc/tasks/words.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

inline constexpr std::size_t control_row = 11;  ///< words of one channel, in the order of PC_K to PC_SHARE_BEFORE

/// The words of CR_CONTROL_BLOCK in shared memory. A joint's row changes only while the joint rests, and PID's words
/// only between PID's runs.
class ControlBlock {
 public:
  ControlBlock(const Config& config, const Words& words);
  /// The whole block and its generation, before the run.
  void initial(const std::function<void(Word offset, Word value)>& put) const;
  /// The operator has changed a setting.
  void change(const Config& config);
  /// PID has finished a run: these joints rest.
  void pid_ended(Word rests) { rests_ = rests, seen_ = true; }
  /// Writes what may be written now.
  void refresh(HostServices& services);
  bool pending() const { return pending_; }
  void list_state(state::Visitor& list);

 private:
  std::vector<Word> row_words(std::size_t channel, double share_before) const;
  void compare();

  const Words& words_;
  plant::CraneParameters crane_;
  ControlLaw now_, wanted_;
  Word generation_ = 1;
  Word rests_ = 0;
  bool seen_ = false;     // PID has run since the last change
  bool pending_ = false;  // now_ and wanted_ differ
};

}  // namespace cmrc

#pragma once
// What the dock does, as data: processes and sub-processes, the steps of each, what each demands of and consents to the
// others when it ends (paper section 3, plant-and-bus.md 4.4 items 13 to 18). The rows built in are
// emulator/cmrc/processes/processes.toml; docs/processes.md explains them.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cmrc/configuration/value.hpp"
#include "cmrc/tasks/user_tasks.hpp"

namespace cmrc {

inline bool has(const std::vector<unsigned>& list, unsigned number) {
  return std::find(list.begin(), list.end(), number) != list.end();
}

enum class Robots : std::uint8_t { none, crane, agv };
/// What a process's time counts as in the account of cycles.
enum class Account : std::uint8_t { none, t_3, t_4, t_5, t_6 };

struct Step {
  enum class Kind : std::uint8_t { task, leg, settle, lower, lock, open, raise, align, queue, hand_over, hold };
  Kind kind{};
  std::string task;    ///< of "task": its key in the report
  unsigned leg = 0;    ///< of "leg"
  double seconds = 0;  ///< of "hold"
};
/// "leg 1", as the row has it.
std::string to_text(const Step& step);

/// The consent of one process to another.
struct Consent {
  unsigned source, target;
};

struct Process {
  unsigned number = 0;
  std::string name;
  Robots robot = Robots::none;
  Account account = Account::none;
  std::vector<unsigned> subprocesses;
  std::vector<Step> steps;
  bool notified_by_task = false;   ///< TB_NOTIFY of its last task picks from `must` and `may`; else all are given
  std::vector<unsigned> must;      ///< loaded when it ends
  std::vector<unsigned> may;       ///< consented to when it ends
  std::vector<unsigned> initial;   ///< whose consents to this process are there at the start
  std::vector<Consent> clears;     ///< consents taken back when it starts
  std::vector<unsigned> replaces;  ///< starts in place of these when both may
  bool loaded = false;             ///< at the start
  bool final = false;              ///< its robot's work is over when it has ended
  Origin origin;
};

struct Subprocess {
  enum class Release : std::uint8_t { point, tick, interval, event, interval_and_event };
  unsigned number = 0;
  std::string name;
  std::string crane, agv;  ///< what is loaded for each: a task's key in the report, or nothing
  Release release{};
  std::vector<unsigned> must;
  bool between_processes = false;  ///< released while its robot is in no process, too
  bool on_legs = false;            ///< released only while a leg of its robot is under way
  Origin origin;

  bool by_interval() const { return release == Release::interval || release == Release::interval_and_event; }
  /// When an object enters the field of an AGV's range sensor.
  bool by_event() const { return release == Release::event || release == Release::interval_and_event; }
};

struct ProcessTable {
  std::vector<Process> processes;        ///< by number
  std::vector<Subprocess> subprocesses;  ///< by number

  const Process* find(unsigned number) const;
  const Subprocess* find_subprocess(unsigned number) const;
  /// The one whose task this is, of the crane or of an AGV.
  const Subprocess& subprocess_of(std::string_view task) const;
  /// All that have to consent to `target`.
  std::vector<unsigned> sources(unsigned target) const;
};

/// The rows built in, and the text they were read from.
const ProcessTable& built_in_processes();
std::string_view built_in_processes_text();

/// Every number that is named is there, every step fits its robot, every token has a source, every process can start.
/// \throws ConfigError with the row's place
void check(const ProcessTable& table, std::span<const UserTask> tasks);
/// The rows as TOML.
std::string to_toml(const ProcessTable& table);

}  // namespace cmrc

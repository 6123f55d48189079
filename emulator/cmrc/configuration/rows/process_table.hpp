#pragma once
// The work of the dock as data: processes and sub-processes, the steps of each, and what each demands and consents to
// when it ends (paper section 3, plant-and-bus.md 4.4 items 13 to 18). The built-in rows are
// emulator/cmrc/configuration/rows/processes.toml; docs/processes.md explains them.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cmrc/configuration/rows/user_task.hpp"
#include "cmrc/configuration/rows/value.hpp"

namespace cmrc {

inline bool has(const std::vector<unsigned>& list, unsigned number) {
  return std::find(list.begin(), list.end(), number) != list.end();
}

/// Processes have the numbers 1 to this one, and so have sub-processes.
inline constexpr unsigned most_processes = 15;

enum class Robots : std::uint8_t { none, crane, agv };
/// The time in the account of cycles to which a process belongs.
enum class Account : std::uint8_t { none, t_3, t_4, t_5, t_6 };

struct Step {
  enum class Kind : std::uint8_t { task, leg, settle, lower, lock, open, raise, align, queue, hand_over, hold };
  Kind kind{};
  std::string task;    ///< for "task": its key in the report
  unsigned leg = 0;    ///< for "leg"
  double seconds = 0;  ///< for "hold"
};
/// "leg 1", as in the row.
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
  bool notified_by_task =
      false;                   ///< TB_NOTIFY of its last task selects from `must` and `may`; else all of them are given
  std::vector<unsigned> must;  ///< loaded when it ends
  std::vector<unsigned> may;   ///< consented to when it ends
  std::vector<unsigned> initial;   ///< sources whose consents to this process are given at the start
  std::vector<Consent> clears;     ///< consents removed when it starts
  std::vector<unsigned> replaces;  ///< starts instead of these if both may start
  bool loaded = false;             ///< at the start
  bool final = false;              ///< its robot's work is finished when it has ended
  Origin origin;
};

struct Subprocess {
  enum class Release : std::uint8_t { point, tick, interval, event, interval_and_event };
  unsigned number = 0;
  std::string name;
  std::string crane, agv;  ///< the task loaded for each: its key in the report, or nothing
  Release release{};
  std::vector<unsigned> must;
  bool between_processes = false;  ///< also released while its robot is in no process
  bool on_legs = false;            ///< released only while a leg of its robot is under way
  Origin origin;

  bool by_interval() const { return release == Release::interval || release == Release::interval_and_event; }
  /// Released when an object enters the field of an AGV's range sensor.
  bool by_event() const { return release == Release::event || release == Release::interval_and_event; }
};

struct ProcessTable {
  std::vector<Process> processes;        ///< by number
  std::vector<Subprocess> subprocesses;  ///< by number

  const Process* find(unsigned number) const;
  const Subprocess* find_subprocess(unsigned number) const;
  /// The sub-process with this task, of the crane or of an AGV.
  const Subprocess& subprocess_of(std::string_view task) const;
  /// All processes that have to consent to `target`.
  std::vector<unsigned> sources(unsigned target) const;
};

/// The built-in rows, and the text from which they were read.
const ProcessTable& built_in_processes();
std::string_view built_in_processes_text();

/// Checks that every named number exists, every step fits its robot, every token has a source, and every process can
/// start. \throws ConfigError with the row's place
void check(const ProcessTable& table, std::span<const UserTask> tasks);
/// The rows as TOML.
std::string to_toml(const ProcessTable& table);

}  // namespace cmrc

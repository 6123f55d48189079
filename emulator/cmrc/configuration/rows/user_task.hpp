#pragma once
// A user's task (docs/add-a-task.md): a row of [[tasks]] in the configuration, with a program, its row of equation (7)
// and its period.
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cmrc/configuration/rows/timed_event.hpp"
#include "cmrc/configuration/rows/value.hpp"

namespace cmrc {

struct UserTask {
  std::string name;                      ///< the report's key
  std::string program;                   ///< label of its entry in the DSP programs
  std::uint32_t x = 0;                   ///< its kind, in one of the gaps of the paper's table
  std::uint32_t importance = 0;          ///< J from t = due_refreshes on
  std::uint32_t importance_waiting = 0;  ///< J before that; 0: the task must not run early
  std::int64_t due_refreshes = 0;
  double period_ms = 0;  ///< a whole number of refreshes, which is checked; 0: none
  Origin period_origin;
  double deadline_ms = 0;       ///< after its release; 0: none
  double heartbeat_ms = 0;      ///< limit between two beats of its program (lib/alive.asm); 0: no heartbeat
  std::int64_t argument = 0;    ///< TB_ARGUMENT
  std::optional<unsigned> dsp;  ///< the slot whose DSP alone may claim its blocks; none: every DSP
  Origin dsp_origin;
  std::vector<Value> parameters;  ///< initial words of its area: floats as TI singles
  Origin origin;
};

inline constexpr std::size_t most_user_tasks = 8;

/// \param fields of one [[tasks]] \param where it begins \throws ConfigError
UserTask user_task(const std::map<std::string, Field>& fields, const Origin& where);
/// Checks that no two tasks have the same name or kind, and that there are not too many. \throws ConfigError
void check_user_tasks(std::span<const UserTask> tasks);
/// Some task is for one DSP alone: the executive has to support such blocks (c40_programs/claim_own.asm).
bool own_blocks(std::span<const UserTask> tasks);
/// The task's fields as TOML, one line each.
std::string to_toml(const UserTask& task);
/// The task's period in refreshes; 0: none.
std::int64_t period_refreshes(const UserTask& task, double refresh_frequency);
/// Checks that the task's period is a whole number of refreshes. \throws ConfigError
void check_period(const UserTask& task, double refresh_frequency);
/// The keys of all kinds of jobs: those of the rows (tasks/job_kinds.hpp), and of each task "user." and its name.
std::vector<std::string> job_kinds(std::span<const UserTask> tasks);
/// J of task `task` after t refreshes of waiting.
std::uint32_t importance(const UserTask& task, std::int64_t t);

}  // namespace cmrc

#include "cmrc/tasks/job_kinds.hpp"

#include <algorithm>
#include <stdexcept>

#include "cmrc/tasks/task_list.hpp"
#include "cmrc/tasks/words.hpp"

namespace cmrc {
namespace {

constexpr bool rows_are_in_order() {
  for (std::size_t n = 0; n < kind_rows.size(); ++n)
    if (static_cast<std::size_t>(kind_rows[n].kind) != n) return false;
  return kind_rows.size() == static_cast<std::size_t>(JobKind::user);
}

}  // namespace

static_assert(rows_are_in_order(), "each built-in kind has one row, in the order of JobKind");
static_assert(std::ranges::none_of(kind_rows,
                                   [](const KindRow& row) {
                                     return row.name.empty() || row.x == 0 ||
                                            (row.step != StepOf::none &&
                                             (row.symbol.empty() || row.importance.restored == 0));
                                   }),
              "each kind has a name and a kind of table 1; a step has a program and an importance");

std::vector<std::string> job_kinds() {
  std::vector<std::string> all;
  for (const KindRow& row : kind_rows) all.emplace_back(row.name);
  return all;
}

JobKind job_kind(Word kind, const Words& words) {
  for (const KindRow& row : kind_rows)
    if (!row.symbol.empty() && words.program(row.kind) == kind) return row.kind;
  if (kind >= words.kind_user && kind < words.kind_count)
    return static_cast<JobKind>(static_cast<Word>(JobKind::user) + kind - words.kind_user);
  throw std::invalid_argument("a task block of a kind that has no account");
}

Task task_of(JobKind kind, const Words& words, std::uint32_t robot) {
  const KindRow& row = row_of(kind);
  return {.x = row.x,
          .y = row.y,
          .kind = words.program(kind),
          .robot = robot,
          .area = row.y == robot_class::agv ? words.agv_area(robot - 1) : words.cr_base};
}

}  // namespace cmrc

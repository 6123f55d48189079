#pragma once
// The cycles of a program, or of the tasks of a run, by place: as tables, as annotated source, as JSON (docs/cli.md,
// Profiles).
#include <cstdint>
#include <string>
#include <vector>

namespace report {

/// Cycles by cause, in the order of Profile::causes.
using CyclesByCause = std::vector<std::int64_t>;

/// Number of instructions, and their cycles.
struct ProfileCost {
  std::uint64_t instructions = 0;
  std::int64_t cycles = 0;
  CyclesByCause causes;  ///< sums to cycles
};

struct ProfileRoutine {
  std::string name;
  std::uint32_t address = 0;
  std::uint64_t calls = 0;
  ProfileCost own;  ///< without the routines that it calls
};

struct ProfileLine {
  std::uint32_t address = 0;
  std::string file;  ///< empty: no source is known, and text is the disassembly
  int line = 0;
  std::string text;  ///< a parallel instruction has two lines
  ProfileCost cost;  ///< no instructions: never executed
};

/// A program, or a task kind.
struct ProfileGroup {
  std::string name;
  std::uint64_t jobs = 0;
  ProfileCost total;                     ///< everything: the routines and the cycles outside them
  CyclesByCause outside;                 ///< cycles of no instruction: interrupt entries, idling, halted
  std::vector<ProfileRoutine> routines;  ///< most cycles first; with `outside` they sum to total
  std::vector<ProfileLine> lines;        ///< by address; with `outside` they sum to total
};

struct Profile {
  std::vector<std::string> causes;  ///< the causes' names
  std::vector<ProfileGroup> groups;
  ProfileCost total;  ///< of all groups
};

/// One group: its routines and its source.
std::string to_text(const Profile& profile, const ProfileGroup& group);
std::string to_json(const Profile& profile, const ProfileGroup& group);
/// All groups side by side, then each group.
std::string to_text(const Profile& profile);
std::string to_json(const Profile& profile);

}  // namespace report

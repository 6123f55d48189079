#pragma once
// Where cycles went, in a program or in the tasks of a run: as tables, as annotated source, as JSON (docs/cli.md,
// Profiles).
#include <cstdint>
#include <string>
#include <vector>

namespace report {

/// Cycles by cause, in the order of Profile::causes.
using CyclesByCause = std::vector<std::int64_t>;

/// Instructions and what they took.
struct ProfileCost {
  std::uint64_t instructions = 0;
  std::int64_t cycles = 0;
  CyclesByCause causes;  ///< sums to cycles
};

struct ProfileRoutine {
  std::string name;
  std::uint32_t address = 0;
  std::uint64_t calls = 0;
  ProfileCost own;  ///< without what it calls
};

struct ProfileLine {
  std::uint32_t address = 0;
  std::string file;  ///< empty: no source is known, and text is the disassembly
  int line = 0;
  std::string text;  ///< of a parallel instruction two lines
  ProfileCost cost;  ///< no instructions: not executed
};

/// What belongs together: a program, or a task kind.
struct ProfileGroup {
  std::string name;
  std::uint64_t jobs = 0;
  ProfileCost total;                     ///< all of it: the routines and what lies outside
  CyclesByCause outside;                 ///< of no instruction: interrupt entries, idling, standing still
  std::vector<ProfileRoutine> routines;  ///< most cycles first; with `outside` they sum to total
  std::vector<ProfileLine> lines;        ///< by address; with `outside` they sum to total
};

struct Profile {
  std::vector<std::string> causes;  ///< their names
  std::vector<ProfileGroup> groups;
  ProfileCost total;  ///< of all groups
};

/// One group: its routines and its source.
std::string to_text(const Profile& profile, const ProfileGroup& group);
std::string to_json(const Profile& profile, const ProfileGroup& group);
/// The groups beside each other, then each of them.
std::string to_text(const Profile& profile);
std::string to_json(const Profile& profile);

}  // namespace report

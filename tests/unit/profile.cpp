// Calls as a profile sees them: by the instruction that calls, and where the program continues.
#include "c40/observers/profile.hpp"

#include <doctest/doctest.h>

#include <initializer_list>
#include <map>
#include <string>

#include "toolchain/assembler/assembler.hpp"

namespace {

c40::Word assembled(const std::string& instruction) {
  return toolchain::assemble_text(" .text\n " + instruction + "\n", "profile").sections.at(0).words.at(0);
}

/// The routines that were called when `instruction` at 10h is followed by nop at these places.
std::map<c40::Address, std::uint64_t> calls_of(const std::string& instruction,
                                               std::initializer_list<c40::Address> places) {
  c40::ProfileCounts counts;
  c40::Profile profile(counts);
  c40::TraceRecord record;
  record.cycles = 1;
  record.pc = 0x10;
  record.word = assembled(instruction);
  profile.instruction(record);
  record.word = assembled("nop");
  for (const c40::Address place : places) {
    record.pc = place;
    profile.instruction(record);
  }
  return {counts.calls().begin(), counts.calls().end()};
}

}  // namespace

TEST_CASE("a call is counted at the first instruction of its routine, and not where it was not taken") {
  using Calls = std::map<c40::Address, std::uint64_t>;
  struct Row {
    const char* instruction;
    int slots;
  };
  for (const Row& row : {Row{"call 40h", 0}, Row{"callz r1", 0}, Row{"trapu 3", 0}, Row{"laj 40h", 3},
                         Row{"lajz r1", 3}, Row{"latz 3", 3}}) {
    CAPTURE(row.instruction);
    if (row.slots == 0) {
      CHECK(calls_of(row.instruction, {0x40, 0x41}) == Calls{{0x40, 1}});
      CHECK(calls_of(row.instruction, {0x11, 0x12}).empty());
    } else {
      CHECK(calls_of(row.instruction, {0x11, 0x12, 0x13, 0x40, 0x41}) == Calls{{0x40, 1}});
      CHECK(calls_of(row.instruction, {0x11, 0x12, 0x13, 0x14, 0x15}).empty());
      CHECK(calls_of(row.instruction, {0x11, 0x12, 0x13, 0x13}) == Calls{{0x13, 1}});
    }
  }
  CHECK(calls_of("br 40h", {0x40}).empty());
  CHECK(calls_of("addi 1,r0", {0x40}).empty());
}

TEST_CASE("an interrupt calls its routine wherever it begins, and counts of several chips are added") {
  c40::ProfileCounts counts, others;
  c40::Profile profile(counts);
  c40::TraceRecord record;
  record.word = assembled("call 40h");
  record.pc = 0x10;
  record.cycles = 4;
  record.causes[0] = 4;
  profile.instruction(record);
  profile.interrupt({.vector = 3});
  record.word = assembled("nop");
  record.pc = 0x11;
  record.cycles = 1;
  record.causes[0] = 1;
  profile.instruction(record);
  profile.count_into(others);
  profile.interrupt({.vector = 3});
  profile.instruction(record);
  record.pc = 0x30;
  profile.instruction(record);
  counts.add(others);
  CHECK(counts.calls().size() == 1);
  CHECK(counts.calls().at(0x11) == 2);
  const auto total = counts.total();
  CHECK(total.instructions == 4);
  CHECK(total.cycles == 7);
  CHECK(total.causes[0] == 7);
  CHECK(counts.instructions().at(0x11).instructions == 2);
  const auto all = c40::routines(counts, {0x20, 0x60});
  REQUIRE(all.size() == 3);  // nothing ran behind 60h
  CHECK(all.at(0x10).own.instructions == 1);
  CHECK(all.at(0x10).calls == 0);
  CHECK(all.at(0x11).own.instructions == 2);
  CHECK(all.at(0x11).calls == 2);
  CHECK(all.at(0x20).own.instructions == 1);
  counts.clear();
  CHECK(counts.total().instructions == 0);
  CHECK(counts.instructions().empty());
  CHECK(counts.calls().empty());
}

// Where the engine records blocks: not where recordings come to nothing again and again.
#include "c40/engine/block_store.hpp"

#include <doctest/doctest.h>

TEST_CASE("where eight recordings have come to nothing, one arrival in 64 is recorded") {
  c40::BlockStore blocks;
  constexpr c40::Address pc = 0x61;
  for (int n = 0; n < 7; ++n) {
    CHECK(blocks.may_record(pc));
    blocks.gave_up(pc);
  }
  CHECK(blocks.may_record(pc));
  blocks.gave_up(pc);
  int recorded = 0;
  for (int arrival = 0; arrival < 640; ++arrival) recorded += blocks.may_record(pc) ? 1 : 0;
  CHECK(recorded == 10);
  CHECK(blocks.may_record(pc + 1));
}

TEST_CASE("recordings from another address begin a new count") {
  c40::BlockStore blocks;
  constexpr c40::Address pc = 0x61, at_the_same_place = pc + 1024;
  for (int n = 0; n < 8; ++n) blocks.gave_up(pc);
  CHECK_FALSE(blocks.may_record(pc));
  CHECK(blocks.may_record(at_the_same_place));
  blocks.gave_up(at_the_same_place);
  CHECK(blocks.may_record(at_the_same_place));
  CHECK(blocks.may_record(pc));
}

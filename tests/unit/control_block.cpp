// PID's words in shared memory (docs/control.md): what is written when the operator changes a setting.
#include <doctest/doctest.h>

#include "cmrc/processes/control_block.hpp"
#include "state/archive.hpp"
#include "tests/unit/made_host.hpp"

namespace {

struct Block {
  cmrc::Config config;
  cmrc::Words w = made::words();
  made::Host host;
  cmrc::ControlBlock block{config, w};

  void change() { block.change(config); }
  /// PID has run, and these joints rest. \returns what was told, with the numbers of the words that were written
  std::string refresh(made::Word rests) {
    block.pid_ended(rests);
    return again();
  }
  std::string again() {
    host.words.clear();
    block.refresh(host);
    return host.news();
  }
  std::string word(std::size_t channel, std::size_t number) {
    return made::number(
        host.words.at(w.cr_base + w.cr_control_block + static_cast<made::Word>(channel * cmrc::control_row + number)));
  }
  /// Words of the block as they are written: 5 rows, and those against sway, and the generation.
  bool whole() const {
    return host.words.size() == cmrc::control_channels * cmrc::control_row + cmrc::control_sway + 1;
  }
};

constexpr std::size_t slew_row = 1, luff_row = 2, filter_word = 5, derivative_word = 6, share_word = 9,
                      before_word = 10;

}  // namespace

TEST_CASE("the whole block is there before the run") {
  Block b;
  std::map<made::Word, made::Word> put;
  b.block.initial([&](made::Word offset, made::Word value) { put[offset] = value; });
  CHECK(put.size() == 5 * 11 + 4 + 1);
  CHECK(put.at(b.w.cr_control) == 1);
  const made::Word first = b.w.cr_control_block;
  for (made::Word channel = 0; channel < 5; ++channel) {
    CHECK(made::number(put.at(first + channel * 11 + filter_word)) == "20");
    CHECK(made::number(put.at(first + channel * 11 + before_word)) == "1");
  }
  CHECK(made::number(put.at(first + slew_row * 11 + derivative_word)) == "0.05");         // 2 / 40
  CHECK(made::number(put.at(first + slew_row * 11 + derivative_word + 1)) == "6.66667");  // 1 / (6 / 40)
  CHECK(made::number(put.at(first + slew_row * 11 + derivative_word + 2)) == "11.547");   // 1 / sqrt(0.05 * 0.15)
  CHECK(made::number(put.at(b.w.cr_control_block + b.w.pc_sway)) == "9");
  CHECK(made::number(put.at(b.w.cr_control_block + b.w.pc_sway + 1)) == "0.5");
  CHECK(made::number(put.at(b.w.cr_control_block + b.w.pc_sway + 2)) == "0.15");
  CHECK(made::number(put.at(b.w.cr_control_block + b.w.pc_sway + 3)) == "0.03");
}

TEST_CASE("a joint's row changes while it rests, between PID's runs") {
  Block b;
  CHECK_FALSE(b.block.pending());
  CHECK(b.refresh(0x1F).empty());  // nothing to change
  b.config.control.slew.derivative_filter = 30;
  b.config.control.luff.feed_forward = 0.5;
  b.change();
  CHECK(b.block.pending());
  b.host.resting = false;
  CHECK(b.refresh(0x1F).empty());
  b.host.resting = true;
  CHECK(b.refresh(0x19).empty());  // the others rest
  CHECK(b.refresh(1U << slew_row) == "control 2");
  CHECK(b.whole());
  CHECK(b.host.words.at(b.w.cr_base + b.w.cr_control) == 2);
  CHECK(b.word(slew_row, filter_word) == "30");
  CHECK(b.word(slew_row, share_word) == "1");
  CHECK(b.word(luff_row, filter_word) == "20");
  CHECK(b.word(luff_row, share_word) == "1");
  CHECK(b.block.pending());
  CHECK(b.again().empty());  // PID has not run since
  CHECK(b.refresh(1U << luff_row) == "control 3");
  CHECK(b.word(luff_row, share_word) == "0.5");
  CHECK(b.word(luff_row, before_word) == "1");
  CHECK_FALSE(b.block.pending());
  b.config.control.slew.derivative_filter = 20;
  b.change();
  CHECK(b.refresh(0x1F) == "control 4");
  CHECK(b.word(luff_row, before_word) == "0.5");
}

TEST_CASE("the words against sway change while both joints that they move rest") {
  Block b;
  b.config.control.sway_gain_m_s_rad = 4;
  b.change();
  CHECK(b.block.pending());
  for (const made::Word rests : {0x0U, 0x2U, 0x4U, 0x19U}) CHECK(b.refresh(rests).empty());
  CHECK(b.refresh(0x6) == "control 2");
  CHECK(b.whole());
  CHECK(b.word(5, 0) == "4");
  CHECK_FALSE(b.block.pending());
}

TEST_CASE("a block that is loaded has the words of the one that was saved") {
  Block saved, loaded;
  saved.config.control.slew.derivative_filter = 30;
  saved.change();
  CHECK(saved.refresh(0x1F) == "control 2");
  state::load(loaded.block, state::save(saved.block));
  CHECK_FALSE(loaded.block.pending());
  CHECK(loaded.refresh(0x1F).empty());
  loaded.config = saved.config;
  loaded.config.control.luff.feed_forward = 0.5;
  loaded.change();
  CHECK(loaded.refresh(0x1F) == "control 3");
  CHECK(loaded.word(slew_row, filter_word) == "30");
}

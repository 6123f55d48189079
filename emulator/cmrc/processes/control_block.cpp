#include "cmrc/processes/control_block.hpp"

#include <cmath>

#include "cmrc/tasks/ti_float.hpp"
#include "state/visitor.hpp"

namespace cmrc {

ControlBlock::ControlBlock(const Config& config, const Words& words)
    : words_(words), crane_(crane_parameters(config)), now_(control_law(config.control, crane_)), wanted_(now_) {}

std::vector<Word> ControlBlock::row_words(std::size_t channel, double share_before) const {
  const ControlLaw::Row& row = now_.rows.at(channel);
  std::vector<Word> all;
  for (const double term : row.k) all.push_back(ti_float(term));
  for (const double value : {row.n, row.derivative_s, 1 / row.integral_s,
                             1 / std::sqrt(row.derivative_s * row.integral_s), row.share, share_before})
    all.push_back(ti_float(value));
  return all;
}

void ControlBlock::initial(const std::function<void(Word offset, Word value)>& put) const {
  for (std::size_t channel = 0; channel < control_channels; ++channel) {
    Word offset = words_.cr_control_block + static_cast<Word>(channel * control_row);
    for (const Word word : row_words(channel, now_.rows.at(channel).share)) put(offset++, word);
  }
  Word offset = words_.cr_control_block + words_.pc_sway;
  for (const double value : now_.sway) put(offset++, ti_float(value));
  put(words_.cr_control, generation_);
}

void ControlBlock::change(const Config& config) {
  wanted_ = control_law(config.control, crane_);
  compare();
}

void ControlBlock::compare() { pending_ = now_.rows != wanted_.rows || now_.sway != wanted_.sway; }

void ControlBlock::refresh(HostServices& services) {
  if (!pending_ || !seen_ || !services.servo_resting()) return;
  std::vector<Word> block;
  Word changed = 0;
  for (std::size_t channel = 0; channel < control_channels; ++channel) {
    const double before = now_.rows.at(channel).share;
    if ((rests_ >> channel & 1U) != 0 && now_.rows.at(channel) != wanted_.rows.at(channel)) {
      now_.rows.at(channel) = wanted_.rows.at(channel);
      changed |= Word{1} << channel;
    }
    for (const Word word : row_words(channel, before)) block.push_back(word);
  }
  // The joints that the sway terms move: slew and luff, or travel and trolley.
  if ((rests_ & 6U) == 6U && now_.sway != wanted_.sway) now_.sway = wanted_.sway, changed |= 0x20;
  if (changed == 0) return;
  compare();
  for (const double value : now_.sway) block.push_back(ti_float(value));
  services.write(words_.cr_base + words_.cr_control_block, block);
  services.write(words_.cr_base + words_.cr_control, ++generation_);
  services.control(generation_, changed);
  seen_ = false;
}

void ControlBlock::list_state(state::Visitor& list) {
  list("now", now_);
  list("wanted", wanted_);
  list("generation", generation_);
  list("rests", rests_);
  list("seen", seen_);
  if (list.loads()) compare();
}

}  // namespace cmrc

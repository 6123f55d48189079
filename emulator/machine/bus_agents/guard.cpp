#include "machine/bus_agents/guard.hpp"

#include <algorithm>

#include "toolchain/objects/image.hpp"

namespace machine {

Guard::Guard(const toolchain::Image& program, const std::vector<Word>& shared) : shared_{shared} {
  const auto symbol = [&](const char* name) { return program.symbol(name); };
  pool_ = {symbol("BLOCK_POOL"), symbol("BLOCK_COUNT") * symbol("BLOCK_WORDS")};
  log_ = {symbol("ER_BASE"), symbol("ER_LOG") + 4 * symbol("ER_ENTRIES")};
  kept_words_ = symbol("SV_WORDS");
  kept_ = {symbol("SV_BASE"), 9 * kept_words_};
  areas_ = {{{symbol("CR_BASE"), symbol("CR_WORDS")},
             {symbol("AG_BASE"), symbol("AG_WORDS")},
             {symbol("US_BASE"), symbol("US_WORDS")}}};
  work_pointer_ = symbol("LIST_WORK_POINTER");
  tb_flag_ = symbol("TB_FLAG");
  tb_kind_ = symbol("TB_KIND");
  tb_area_ = symbol("TB_AREA");
  tb_result_ = symbol("TB_RESULT");
  tb_notify_ = symbol("TB_NOTIFY");
  tb_alive_ = symbol("TB_ALIVE");
  block_words_ = symbol("BLOCK_WORDS");
  flag_taken_ = symbol("FLAG_TAKEN");
  flag_done_ = symbol("FLAG_DONE");
  kind_error_ = symbol("KIND_ERROR");
  list_semaphore_ = symbol("SEMAPHORE_LIST") - symbol("SEMAPHORE");
}

bool Guard::refuse(unsigned slot, Offset offset, Word value) {
  refusals_.push_back({slot, offset, value, kind(slot)});
  return false;
}

bool Guard::in_area(Offset area, Offset offset) const {
  const auto& [crane, agv, user] = areas_;
  const Offset words = crane.holds(area) ? crane.words : area >= user.first ? user.words : agv.words;
  if (offset - area < words) return true;
  if (area >= user.first) return false;
  const Offset robot = crane.holds(area) ? 0 : 1 + (area - agv.first) / agv.words;
  return Region{kept_.first + robot * kept_words_, kept_words_}.holds(offset);
}

bool Guard::admits(unsigned slot, Offset offset, Word value, bool holds_list) {
  auto& bound = bound_.at(slot);
  const Offset word = (offset - pool_.first) % block_words_;
  if (holds_list && (pool_.holds(offset) || offset == work_pointer_)) {
    if (pool_.holds(offset) && word == tb_flag_ && value == flag_taken_) bound = offset - tb_flag_;
    return true;
  }
  if (!bound) return refuse(slot, offset, value);
  if (pool_.holds(offset)) {
    const bool own = offset - word == *bound;
    if (own && word == tb_flag_ && value == flag_done_) {
      bound.reset();
      return true;
    }
    return (own && (word == tb_result_ || word == tb_notify_ || word == tb_alive_)) || refuse(slot, offset, value);
  }
  if (kind(slot) == kind_error_ && log_.holds(offset)) return true;
  return in_area(shared_[*bound + tb_area_], offset) || refuse(slot, offset, value);
}

std::optional<Word> Guard::find_refusal(unsigned slot, Offset offset, Word value) {
  const auto found = std::find_if(refusals_.begin(), refusals_.end(), [&](const Refusal& refusal) {
    return refusal.slot == slot && refusal.offset == offset && refusal.value == value;
  });
  if (found == refusals_.end()) return std::nullopt;
  const Word kind = found->kind;
  refusals_.erase(found);
  return kind;
}

}  // namespace machine

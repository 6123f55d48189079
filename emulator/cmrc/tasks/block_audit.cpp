#include "cmrc/tasks/block_audit.hpp"

#include <fmt/format.h>

#include "state/visitor.hpp"

namespace cmrc {
namespace {

constexpr std::size_t most_kept = 100;
constexpr const char* state_names[] = {"absent", "waiting", "taken", "done"};

}  // namespace

BlockAudit::Block& BlockAudit::at(std::size_t block) {
  if (block >= blocks_.size()) blocks_.resize(block + 1);
  return blocks_[block];
}

void BlockAudit::violated(report::Time time, const std::string& what) {
  if (violations_.size() >= most_kept) return;
  violations_.push_back(fmt::format("{:.9f} s, {}", report::seconds(time), what));
}

void BlockAudit::violated(std::size_t block, report::Time time, const std::string& what) {
  violated(time, fmt::format("block {}: {}", block, what));
}

void BlockAudit::pass(std::size_t block, State from, State to, report::Time time, const char* what) {
  ++checks_;
  Block& known = at(block);
  if (known.state != from)
    violated(block, time, fmt::format("{} while {}", what, state_names[static_cast<int>(known.state)]));
  known.state = to;
}

void BlockAudit::loaded(std::size_t block, report::Time time) {
  pass(block, State::absent, State::waiting, time, "loaded");
}

void BlockAudit::claimed(std::size_t block, unsigned slot, report::Time time) {
  pass(block, State::waiting, State::taken, time, "claimed");
  at(block).owner = slot;
}

void BlockAudit::finished(std::size_t block, unsigned slot, report::Time time) {
  const unsigned owner = at(block).owner;
  pass(block, State::taken, State::done, time, "finished");
  if (owner != slot) violated(block, time, fmt::format("claimed by DSP {}, finished by DSP {}", owner, slot));
}

void BlockAudit::put_back(std::size_t block, report::Time time) {
  pass(block, State::taken, State::waiting, time, "put back");
}
void BlockAudit::removed(std::size_t block, report::Time time) {
  pass(block, State::done, State::absent, time, "removed");
}
void BlockAudit::dropped(std::size_t block, report::Time time) {
  pass(block, State::taken, State::absent, time, "given up");
}

void BlockAudit::list_state(state::Visitor& list) {
  list("blocks", blocks_);
  list("checks", checks_);
  list("violations", violations_);
}

}  // namespace cmrc

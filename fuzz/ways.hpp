#pragma once
// One start, several ways to run: by blocks, by single instructions, in pieces. All must have the same result.
#include <algorithm>
#include <functional>
#include <memory>
#include <vector>

#include "c40/chip/chip.hpp"
#include "c40/chip/snapshot.hpp"
#include "fuzz/target.hpp"

namespace fuzz {

/// The result of one way to run.
struct End {
  c40::StopInfo stop;
  std::vector<std::uint64_t> seen;
  std::uint64_t memory = 0;
  std::uint64_t answers = 0;
};

/// Answers the access that the chip stopped at: true, run on.
using Answer = std::function<bool(c40::Chip& chip, const c40::StopInfo& stop)>;
/// A chip at its start, and the functions that answer its accesses.
struct Start {
  std::unique_ptr<c40::Chip> chip;
  Answer answer;
  c40::WindowListener* listener = nullptr;  ///< gives some of these answers without a stop of the chip
  std::uint64_t* answers = nullptr;         ///< how many were given so far
};

/// \param advance runs the chip at most to the limit; only the last instruction may cross it
template <class Advance>
End run(Start start, c40::Cycles limit, Advance&& advance) {
  c40::Chip& chip = *start.chip;
  c40::StopInfo stop;
  const std::uint64_t before = start.answers == nullptr ? 0 : *start.answers;
  while (chip.cycle() < limit) {
    stop = advance(chip);
    if (stop.reason == c40::StopInfo::Reason::limit) continue;
    if (!start.answer(chip, stop)) break;
  }
  const std::uint64_t answers = start.answers == nullptr ? 0 : *start.answers - before;
  return {stop, c40::snapshot(chip), c40::digest(chip.memory()), answers};
}

inline void expect_alike(const char* way, const End& first, const End& second) {
  const auto differ = [&](const std::string& what) {
    broken(std::string(way) + " ends otherwise than by blocks: " + what);
  };
  if (first.stop.reason != second.stop.reason)
    differ(std::string(name(first.stop.reason)) + " and " + std::string(name(second.stop.reason)));
  if (first.stop.fault.has_value() != second.stop.fault.has_value()) differ("one has a fault");
  if (first.stop.fault &&
      (first.stop.fault->kind != second.stop.fault->kind || first.stop.fault->message != second.stop.fault->message))
    differ(first.stop.fault->message + " and " + second.stop.fault->message);
  if (first.seen.size() != second.seen.size()) differ("what is in cache or FIFOs");
  for (std::size_t n = 0; n < first.seen.size(); ++n)
    if (first.seen[n] != second.seen[n])
      differ("number " + std::to_string(n) + " of its snapshot: " + std::to_string(first.seen[n]) + " and " +
             std::to_string(second.seen[n]));
  if (first.memory != second.memory) differ("memory");
  if (first.answers != second.answers)
    differ(std::to_string(first.answers) + " and " + std::to_string(second.answers) + " accesses through windows");
}

/// \param make always gives the same start \param cuts lengths of the pieces in cycles, used cyclically
inline void expect_same_ends(const std::function<Start()>& make, c40::Cycles limit,
                             const std::vector<c40::Cycles>& cuts) {
  Start first = make();
  const c40::WindowListener* const listener = first.listener;
  const End blocks = run(std::move(first), limit, [&](c40::Chip& chip) { return chip.run_until(limit); });
  const auto in_pieces = [&](c40::Chip& chip) {
    const auto piece =
        cuts.empty() ? c40::Cycles{1} : cuts[static_cast<std::size_t>(chip.instructions()) % cuts.size()];
    return chip.run_until(std::min(limit, chip.cycle() + piece));
  };
  const auto exact = [&] {
    Start start = make();
    start.chip->set_exact(true);
    return start;
  };
  expect_alike("the exact engine", blocks, run(exact(), limit, [&](c40::Chip& chip) { return chip.run_until(limit); }));
  expect_alike("by single steps", blocks, run(make(), limit, [](c40::Chip& chip) { return chip.step(); }));
  expect_alike("cut into pieces", blocks, run(make(), limit, in_pieces));
  expect_alike("the exact engine cut into pieces", blocks, run(exact(), limit, in_pieces));
  if (listener == nullptr) return;
  const auto at_once = [&](Start start) {
    start.chip->set_window_listener(start.listener);
    return start;
  };
  expect_alike("answered at once", blocks,
               run(at_once(make()), limit, [&](c40::Chip& chip) { return chip.run_until(limit); }));
  expect_alike("answered at once and cut into pieces", blocks, run(at_once(make()), limit, in_pieces));
  expect_alike("answered at once by single steps", blocks,
               run(at_once(make()), limit, [](c40::Chip& chip) { return chip.step(); }));
  expect_alike("the exact engine answered at once", blocks,
               run(at_once(exact()), limit, [&](c40::Chip& chip) { return chip.run_until(limit); }));
}

}  // namespace fuzz

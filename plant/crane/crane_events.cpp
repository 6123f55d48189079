#include "plant/crane/crane_events.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace plant {
namespace {

constexpr int most_events = 64;  // in one interval; more are chatter, which the next grid point ends
constexpr int most_passes = 64;  // of settle(); two or three are usual

struct Candidate {
  CraneRoot root;
  CraneEvent::Kind kind;
  std::size_t joint;
};

class Interval {
 public:
  Interval(CraneMotion& motion, CraneState& state, CraneInputs& inputs, CraneModes& modes,
           std::vector<CraneEvent>& events, Work* work)
      : motion_(motion),
        c_(state),
        in_(inputs),
        modes_(modes),
        events_(events),
        work_(work),
        p_(motion.crane().parameters()) {}

  void advance(double seconds) {
    double at = 0.0;
    for (int i = 0; i < most_events; ++i) {
      if (p_.stiction) settle(at);
      CraneState trial = c_;
      Work done{};
      if (work_ != nullptr)
        done = motion_.advance_booked(trial, in_, seconds - at);
      else
        motion_.advance(trial, in_, seconds - at);
      gather(trial);
      if (found_.empty() || i + 1 == most_events) {
        c_ = trial;
        if (work_ != nullptr) *work_ += done;
        return;
      }
      std::array<CraneRoot, CraneMotion::most_roots> roots{};
      for (std::size_t k = 0; k < found_.size(); ++k) roots[k] = found_[k].root;
      CraneState before = c_;
      int which = -1;
      const double gone = motion_.advance_to(c_, in_, seconds - at, {roots.data(), found_.size()}, which);
      if (work_ != nullptr && gone > 0.0) *work_ += motion_.advance_booked(before, in_, gone);
      at += gone;
      if (which < 0) return;  // exactly at the end of the interval
      happen(found_[static_cast<std::size_t>(which)], at);
      if (at >= seconds) return;
    }
  }

 private:
  bool locked(std::size_t k) const { return (in_.locked >> k & 1U) != 0; }

  void consider(const CraneState& trial, const Candidate& candidate) {
    const double then = motion_.value(candidate.root, trial, in_);
    if (candidate.kind == CraneEvent::Kind::slipped && then < 0.0) return;  // now it is not positive, says settle()
    const double now = motion_.value(candidate.root, c_, in_);
    if (now != 0.0 && now * then <= 0.0 && found_.size() < CraneMotion::most_roots) found_.push_back(candidate);
  }

  // All events between the present state and the trial's.
  void gather(const CraneState& trial) {
    using Kind = CraneRoot::Kind;
    found_.clear();
    for (std::size_t j = 0; j < joint_count; ++j) {
      const std::size_t k = coordinate_of(j);
      if (!locked(k)) {
        if (c_.q[k] > p_.lower[j] && trial.q[k] <= p_.lower[j])
          consider(trial, {{Kind::position, k, p_.lower[j]}, CraneEvent::Kind::limit, j});
        if (c_.q[k] < p_.upper[j] && trial.q[k] >= p_.upper[j])
          consider(trial, {{Kind::position, k, p_.upper[j]}, CraneEvent::Kind::limit, j});
        if (in_.sliding[j] != 0) consider(trial, {{Kind::speed, k, 0.0}, CraneEvent::Kind::stuck, j});
      } else if ((modes_.stuck >> j & 1U) != 0) {
        consider(trial, {{Kind::sticking, j, static_friction(j)}, CraneEvent::Kind::slipped, j});
      }
    }
    if (locked(Q_ALPHA)) return;
    for (const std::size_t k : {std::size_t{Q_ALPHA}, std::size_t{Q_BETA}}) {
      if (std::fabs(trial.q[k]) < widest_sway || std::fabs(c_.q[k]) >= widest_sway) continue;
      consider(trial, {{Kind::position, k, std::copysign(widest_sway, trial.q[k])}, CraneEvent::Kind::swung_out, k});
    }
    const CraneRoot tension{Kind::tension, Q_L, 0.0};
    if (modes_.watch_rope && motion_.value(tension, trial, in_) <= 0.0 && motion_.value(tension, c_, in_) > 0.0)
      consider(trial, {tension, CraneEvent::Kind::slack, joint_count});
  }

  void happen(const Candidate& what, double at) {
    int joint = static_cast<int>(what.joint);
    const std::uint32_t bit = 1U << what.joint;
    switch (what.kind) {
      case CraneEvent::Kind::limit:
        c_.q[what.root.index] = what.root.level;
        stop(what.root.index);
        if ((modes_.at_limit & bit) != 0) return;
        modes_.at_limit |= bit;
        break;
      case CraneEvent::Kind::stuck:
        c_.qd[what.root.index] = 0.0;
        if (!stick(what.joint)) return;
        break;
      case CraneEvent::Kind::slipped: break_away(what.joint, motion_.sticking_force(c_, in_, what.joint)); break;
      case CraneEvent::Kind::slack: joint = -1; break;
      case CraneEvent::Kind::swung_out: break;
    }
    events_.push_back({what.kind, joint, at});
  }

  void stop(std::size_t k) {
    const double before = work_ == nullptr ? 0.0 : motion_.crane().kinetic_energy(c_.q, c_.qd, in_.payload);
    motion_.stop(c_, in_, k);
    if (work_ != nullptr) work_->impacts += before - motion_.crane().kinetic_energy(c_.q, c_.qd, in_.payload);
  }

  // ---- dry friction: a joint at rest sticks if friction can hold it there, else it slides in the direction of the
  // force. The force may have jumped since the last instant: wind, load, falls, brakes, another joint's friction.
  void settle(double at) {
    const std::uint32_t stuck_before = modes_.stuck;
    std::uint32_t resting = 0;  // sliding, but not yet moving
    for (std::size_t j = 0; j < joint_count; ++j) {
      const std::size_t k = coordinate_of(j);
      if (in_.braked[j]) in_.sliding[j] = 0;
      if (in_.braked[j] || locked(k)) continue;
      if (c_.qd[k] != 0.0)
        in_.sliding[j] = c_.qd[k] > 0.0 ? 1 : -1;
      else if (in_.sliding[j] != 0)
        resting |= 1U << j;
      else
        hold(j);
    }
    const std::uint32_t held_first = modes_.stuck & ~stuck_before;  // at rest from the beginning: no event
    // A joint that sticks or breaks away changes what the others must hold. The lowest joint that disagrees with its
    // force goes first: then the joints agree after a few passes (Murty's pivoting, for a positive definite matrix).
    for (int pass = 0; pass < most_passes && correct_first(resting); ++pass) {
    }
    for (std::size_t j = 0; j < joint_count; ++j) {
      const std::uint32_t bit = 1U << j;
      if (((stuck_before ^ modes_.stuck) & ~held_first & bit) == 0) continue;
      const bool slipped = (stuck_before & bit) != 0;
      events_.push_back({slipped ? CraneEvent::Kind::slipped : CraneEvent::Kind::stuck, static_cast<int>(j), at});
    }
  }

  // Changes the first joint at rest that sticks or slides against its force; false if there is none.
  bool correct_first(std::uint32_t& resting) {
    if ((modes_.stuck | resting) == 0) return false;
    CraneVector holding{};
    if (modes_.stuck != 0) holding = motion_.holding_force(c_, in_);
    for (std::size_t j = 0; j < joint_count; ++j) {
      const std::uint32_t bit = 1U << j;
      if ((modes_.stuck & bit) != 0) {
        const double force = motion_.sticking_force(holding, c_, j);
        if (std::fabs(force) <= static_friction(j)) continue;
        break_away(j, force);
        resting |= bit;
        return true;
      }
      if ((resting & bit) == 0) continue;
      // A joint that has just broken away is exactly at its limit: rounding must not hold it again at once.
      constexpr double at_limit = 1.0 - 1e-9;
      const std::int8_t direction = in_.sliding[j];
      hold(j);
      const double force = motion_.sticking_force(c_, in_, j);
      if (-direction * force < at_limit * static_friction(j)) {
        resting &= ~bit;
        return true;
      }
      break_away(j, force);
    }
    return false;
  }

  double static_friction(std::size_t j) const { return motion_.crane().static_friction(static_cast<int>(j)); }

  void hold(std::size_t j) {
    in_.locked |= 1U << coordinate_of(j);
    in_.sliding[j] = 0;
    modes_.stuck |= 1U << j;
  }

  bool stick(std::size_t j) {
    hold(j);
    const double force = motion_.sticking_force(c_, in_, j);
    if (std::fabs(force) <= static_friction(j)) return true;
    break_away(j, force);
    return false;
  }

  void break_away(std::size_t j, double force) {
    in_.locked &= ~(1U << coordinate_of(j));
    in_.sliding[j] = force > 0.0 ? -1 : 1;
    modes_.stuck &= ~(1U << j);
  }

  CraneMotion& motion_;
  CraneState& c_;
  CraneInputs& in_;
  CraneModes& modes_;
  std::vector<CraneEvent>& events_;
  Work* work_;
  const CraneParameters& p_;
  std::vector<Candidate> found_;  // mostly empty: then nothing is allocated or cleared
};

}  // namespace

void advance_with_events(CraneMotion& motion, CraneState& state, CraneInputs& inputs, CraneModes& modes, double seconds,
                         std::vector<CraneEvent>& events, Work* work) {
  Interval(motion, state, inputs, modes, events, work).advance(seconds);
}

std::uint32_t rest_in_stops(const CraneMotion& motion, CraneState& state, const CraneInputs& inputs,
                            CraneModes& modes) {
  const CraneParameters& p = motion.crane().parameters();
  std::uint32_t arrived = 0;
  for (std::size_t j = 0; j < joint_count; ++j) {
    const std::size_t k = coordinate_of(j);
    const std::uint32_t bit = 1U << j;
    const double low = p.lower[j];
    const double high = p.upper[j];
    double& q = state.q[k];
    if (q > low && q < high) {
      modes.at_limit &= ~bit;
      continue;
    }
    arrived |= bit & ~modes.at_limit;
    modes.at_limit |= bit;
    q = std::clamp(q, low, high);
    const double speed = state.qd[k];
    if ((q <= low && speed < 0.0) || (q >= high && speed > 0.0)) motion.stop(state, inputs, k);
  }
  return arrived;
}

}  // namespace plant

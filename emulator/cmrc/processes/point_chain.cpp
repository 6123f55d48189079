#include "cmrc/processes/point_chain.hpp"

#include <algorithm>
#include <utility>

#include "state/visitor.hpp"

namespace cmrc {

void PointChain::begin(std::int64_t first, std::int64_t interval, std::int64_t tick) {
  interval_ = interval;
  cartesian_ = joint_ = consumed_ = base_count_ = first;
  base_ = tick + interval;
  begun_at_ = tick;
  reported_ = first;
  used_from_.clear();
  begin_reported_ = end_reported_ = false;
  anchored_ = trajectory_out_ = inverse_out_ = ended_ = false;
  active_ = again_ = true;
}

void PointChain::trajectory_done(bool end_of_leg, bool inverse, bool again) {
  trajectory_out_ = false;
  planned_at_ = loaded_at_;
  if (inverse) ++cartesian_;
  again_ = again;
  if (end_of_leg) ended_ = true;
}

void PointChain::consumed(std::int64_t count, std::int64_t start) {
  if (!active_ || count <= consumed_) return;
  // Of several that the host learns of at once, PID has taken each when the one before it was used up.
  for (std::int64_t earlier = count - consumed_ - 1; earlier >= 0; --earlier)
    used_from_.push_back(start - earlier * interval_);
  consumed_ = count;
  base_ = start + interval_;
  base_count_ = count;
  anchored_ = true;
}

void PointChain::pushed(std::int64_t tick) {
  drive_buffer_ = true;
  base_ = anchored_ ? std::max(base_, tick) + interval_ : tick + interval_;
  base_count_ = joint_;
  anchored_ = true;
  used_from_.push_back(base_ - interval_);
}

std::int64_t PointChain::consumed_by(std::int64_t tick) const {
  if (!drive_buffer_ || !anchored_) return consumed_;
  // The drive holds the point that ends at base_, and further ones wait behind it.
  const std::int64_t unfinished = tick >= base_ ? 0 : (base_ - tick + interval_ - 1) / interval_;
  return joint_ - std::max<std::int64_t>(0, unfinished - 1);
}

bool PointChain::through(std::int64_t tick) const {
  return active_ && ended_ && joint_ == cartesian_ && consumed_by(tick) == joint_;
}

void PointChain::tell(HostServices& services) {
  const Robot robot = trajectory_.robot;
  if (!std::exchange(begin_reported_, true)) services.leg_begun(robot, reported_, interval_, begun_at_);
  const std::int64_t consumed = consumed_by(services.tick());
  for (; reported_ < consumed; ++reported_) {
    services.milestone(robot, Milestone::Kind::point, reported_, used_from_.front());
    used_from_.pop_front();
  }
  if (!end_reported_ && through(services.tick())) {
    end_reported_ = true;
    services.milestone(robot, Milestone::Kind::leg_ended, 0, services.tick());
  }
}

bool PointChain::ended(HostServices& services) {
  tell(services);
  return through(services.tick());
}

void PointChain::refresh(HostServices& services) {
  if (!active_) return;
  tell(services);
  if (!trajectory_out_ && again_ && cartesian_ - consumed_by(services.tick()) < depth_ && joint_ >= cartesian_ - 1) {
    Task task = trajectory_;
    task.tick = static_cast<std::uint32_t>(services.tick());
    task.argument = static_cast<std::uint32_t>(cartesian_);
    services.load(task, need(cartesian_));
    loaded_at_ = services.tick();
    trajectory_out_ = true;
  }
  if (!inverse_out_ && joint_ < cartesian_) {
    Task task = inverse_;
    task.tick = static_cast<std::uint32_t>(services.tick());
    task.argument = static_cast<std::uint32_t>(joint_);
    task.t = services.tick() - planned_at_;
    services.load(task, need(joint_));
    inverse_out_ = true;
  }
}

void PointChain::list_state(state::Visitor& list) {
  list("interval", interval_);
  list("cartesian", cartesian_);
  list("joint", joint_);
  list("consumed", consumed_);
  list("base", base_);
  list("base_count", base_count_);
  list("loaded_at", loaded_at_);
  list("planned_at", planned_at_);
  list("anchored", anchored_);
  list("drive_buffer", drive_buffer_);
  list("trajectory_out", trajectory_out_);
  list("inverse_out", inverse_out_);
  list("again", again_);
  list("ended", ended_);
  list("active", active_);
  list("begun_at", begun_at_);
  list("reported", reported_);
  list("used_from", used_from_);
  list("begin_reported", begin_reported_);
  list("end_reported", end_reported_);
  list("abandoned", abandoned_);
}

}  // namespace cmrc

#include "cmrc/measures/course.hpp"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <stdexcept>

#include "cmrc/configuration/rows/process_table.hpp"
#include "plant/dock/dock.hpp"
#include "state/visitor.hpp"

namespace cmrc {

SharedRows::SharedRows(std::size_t rows, std::size_t width) : room_(rows), width_(width) {
  if (rows == 0) return;
  void* memory = ::mmap(nullptr, rows * width * sizeof(double), PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) {
    throw std::runtime_error(fmt::format(
        "report.reference: no memory for the course of {} latches; a shorter run.duration_s or \"none\" is expected",
        rows));
  }
  data_ = static_cast<double*>(memory);
}

SharedRows::~SharedRows() {
  if (data_ != nullptr) ::munmap(data_, room_ * width_ * sizeof(double));
}

Course::Course(std::size_t rows, int agvs)
    : rows_(rows, agv_column + 2 * static_cast<std::size_t>(agvs)), agvs_(agvs) {}

void Course::latch(const plant::Dock& dock, Time time) {
  if (rows_.room() == 0 || time <= Time{}) return;
  if (size_ == rows_.room()) thin_rows();
  if (time % step() != Time{}) return;
  const plant::Place place = dock.place();
  double* out = rows_.row(size_).data();
  out = std::copy(place.q.begin(), place.q.end(), out);
  out = std::copy(place.payload.begin(), place.payload.end(), out);
  *out++ = place.alpha;
  *out++ = place.beta;
  for (int agv = 0; agv < agvs_; ++agv) {
    const plant::AgvSignal at = dock.agv(agv);
    *out++ = at.x;
    *out++ = at.y;
  }
  for (double& value : rows_.row(size_)) value = to_grid(value);
  ++size_;
}

// Removes every second one of rows 1, 2, 3, ...
void Course::thin_rows() {
  every_ *= 2;
  size_ /= 2;
  for (std::size_t i = 0; i < size_; ++i) std::ranges::copy(rows_.row(2 * i + 1), rows_.row(i).begin());
}

std::span<const double> Course::at(Time time) const {
  const std::int64_t row = time / step() - 1;
  return rows_.row(static_cast<std::size_t>(std::clamp<std::int64_t>(row, 0, static_cast<std::int64_t>(size_) - 1)));
}

double Course::at(Time time, std::size_t column) const {
  const double before = at(time)[column], after = at(time + step())[column];
  const double share = static_cast<double>((time % step()).count()) / static_cast<double>(step().count());
  return before + share * (after - before);
}

void Course::process_begun(Robot robot, unsigned number) {
  Place& place = places_[robot];
  place = {.process = number, .begun = place.begun + 1};
}

void Course::leg_begun(Robot robot, std::int64_t first, Time interval, Time at) {
  Place& place = places_[robot];
  ++place.legs;
  place.first_point = first;
  legs_[robot].interval = interval;
  milestone(robot, Milestone::Kind::leg_begun, 0, at);
}

// A key: process, how many processes the robot has begun, kind, leg within the process, and number within the leg or of
// its kind within the process.
void Course::milestone(Robot robot, Milestone::Kind kind, std::int64_t number, Time at) {
  Place& place = places_[robot];
  std::uint64_t within = place.counts[static_cast<std::size_t>(kind)]++;
  if (kind == Milestone::Kind::point) within = static_cast<std::uint64_t>(number - place.first_point);
  static_assert(most_processes < 1 << 4);
  const std::uint64_t key = place.process << 60 | (place.begun & 0xFFFF) << 44 | (place.legs & 0xFF) << 36 |
                            static_cast<std::uint64_t>(kind) << 32 | (within & 0xFFFFFFFF);
  Leg& leg = legs_[robot];
  switch (kind) {
    case Milestone::Kind::leg_begun: leg = {at, leg.interval, true, leg.starved}; break;
    case Milestone::Kind::point: leg.starved = leg.starved_at(at), leg.last = std::max(leg.last, at); break;
    case Milestone::Kind::leg_ended: leg.open = false; break;
    default: break;
  }
  milestones_.push_back({robot, key, at});
  if (!is_kept(milestones_.back()))
    milestones_.pop_back();
  else if (milestones_.size() > milestones_room_)
    thin_milestones();
}

// Demand is measured by the begins and ends of legs, so that all of them stay.
bool Course::is_kept(const Milestone& one) const {
  switch (one.kind()) {
    case Milestone::Kind::leg_begun:
    case Milestone::Kind::leg_ended: return true;
    case Milestone::Kind::point: return (one.key & 0xFFFFFFFF) % points_every_ == 0;
    default: return (one.key >> 44 & 0xFFFF) % processes_every_ == 0;
  }
}

// First points; then, of a table of processes that end very often, the other milestones of every second process.
void Course::thin_milestones() {
  const auto thin = [this](std::uint64_t& every, std::uint64_t most) {
    const auto removed = [&] { return std::erase_if(milestones_, [this](const auto& one) { return !is_kept(one); }); };
    while (every < most) {
      every *= 2;
      if (removed() > 0) return true;
    }
    return false;
  };
  if (thin(points_every_, points_every_most) || thin(processes_every_, processes_every_most)) return;
  milestones_room_ *= 2;
}

std::uint64_t Course::Leg::starved_at(Time time) const {
  if (!open || time <= last) return starved;
  return starved + static_cast<std::uint64_t>(std::max<std::int64_t>(0, (time - last) / interval - 1));
}

std::map<Robot, std::uint64_t> Course::starved_intervals(Time end) const {
  std::map<Robot, std::uint64_t> starved;
  for (const auto& [robot, leg] : legs_) starved[robot] = leg.starved_at(end);
  return starved;
}

void Course::servo(bool on, Time at) {
  if (on == (servo_.size() % 2 == 1)) return;
  servo_.push_back(at);
}

void Course::list_state(state::Visitor& list) {
  list_all_but_rows(list);
  list.table("rows", rows_.first(size_), rows_.width());
}

void Course::list_all_but_rows(state::Visitor& list) {
  list("size", size_);
  if (size_ > rows_.room())
    throw state::StateError("a course of " + std::to_string(size_) + " rows, with room for " +
                            std::to_string(rows_.room()));
  list("every", every_);
  list("points_every", points_every_);
  list("processes_every", processes_every_);
  list("milestones_room", milestones_room_);
  list("legs", legs_);
  list("places", places_);
  list("milestones", milestones_);
  list("servo", servo_);
}

}  // namespace cmrc

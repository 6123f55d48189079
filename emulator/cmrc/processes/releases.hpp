#pragma once
// When a sub-process of one robot is released: at refreshes of its interval, and when an object enters the field of its
// AGV's range sensor (docs/processes.md, Releases).
#include <cstdint>
#include <optional>
#include <vector>

#include "cmrc/configuration/rows/process_table.hpp"
#include "cmrc/tasks/words.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

/// The last refresh up to `tick` that is congruent to `phase` modulo `period`.
std::int64_t congruent_before(std::int64_t tick, std::int64_t phase, std::int64_t period);

/// How the host watches the fields of the AGVs' range sensors.
struct RangeWatch {
  std::int64_t every = 8;          ///< refreshes between two readings of one sensor
  std::int64_t field_mm = 15'000;  ///< length of the field ahead of the sensor
};

/// The readings of one AGV's range sensor.
class RangeField {
 public:
  /// A reading: mm to the nearest echo in the vehicle's way. True if an object has entered: something is in the field,
  /// and the reading before showed nothing there, or its nearest echo was more than `jump_mm` farther away.
  bool entered(Word millimetres, const RangeWatch& watch);
  /// The sensor is not read any more: the next reading has none before it.
  void forget() { last_.reset(); }
  void list_state(state::Visitor& list);

  /// More than the change of distance between vehicle and object in 50 ms, the longest time between two readings.
  static constexpr std::int64_t jump_mm = 600;

 private:
  std::optional<std::int64_t> last_;
};

/// The releases of one sub-process of one robot.
class Release {
 public:
  /// \param number of the robot among those of its kind; \param count of these robots: both stagger their refreshes
  Release(const Subprocess& row, unsigned robot, unsigned number, unsigned count)
      : row_(&row), robot_(robot), number_(number), count_(count) {}

  const Subprocess& row() const { return *row_; }
  unsigned robot() const { return robot_; }

  /// floor(i N / n), or 0 if all are released together.
  std::int64_t phase(std::int64_t period, bool staggered) const { return staggered ? number_ * period / count_ : 0; }

  struct Due {
    std::vector<std::int64_t> dropped;  ///< nominal refreshes that have passed without a block
    bool load = false;                  ///< a block has to be loaded now
  };
  /// To be called at a refresh in which the sub-process runs. Dropped are the nominal refreshes since the refresh
  /// before for which the host was too late (passed), or at which the block before was not finished after its deadline.
  Due due(std::int64_t tick, std::int64_t period, bool staggered);
  /// The nominal refreshes since the refresh before that are over at `tick`: another has come since.
  std::vector<std::int64_t> passed(std::int64_t tick, std::int64_t period, bool staggered) const;
  /// The last nominal refresh up to `tick`, to which the host has not come.
  struct Last {
    std::int64_t nominal;
    bool dropped;  ///< the block before it is in its way; else there is only no block yet
  };
  /// None if the host has come to it, or would neither drop it nor load a block.
  /// \param out the block before it is not finished, which the host may not know yet
  std::optional<Last> last_passed(std::int64_t tick, std::int64_t period, bool staggered, bool out) const;
  /// To be called at a refresh in which it does not run.
  void rests(std::int64_t tick) { seen_ = tick, object_ = false; }
  void object_entered() { object_ = row_->by_event(); }

  void loaded(std::int64_t deadline) { out_ = true, deadline_ = deadline; }
  void ended() { out_ = false; }
  void stop() { stopped_ = true; }
  void resume() { stopped_ = false; }
  bool stopped() const { return stopped_; }
  void list_state(state::Visitor& list);

 private:
  const Subprocess* row_;
  unsigned robot_, number_, count_;
  std::int64_t seen_ = 0;      // refresh up to which nominal refreshes are counted
  std::int64_t deadline_ = 0;  // of the unfinished block
  bool out_ = false;
  bool object_ = false;   // an object has entered the field, and no block was loaded since
  bool stopped_ = false;  // given up
};

}  // namespace cmrc

#pragma once
// Errors (x = 1) as the host deals with them (docs/controller.md, Errors): PID, the crane or the watchdog notices one;
// an error block on a DSP decides what is to be done (c40_programs/kernels/error.asm); the host carries it out; the
// operator clears what it has stopped.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/processes/host_services.hpp"
#include "cmrc/processes/path_clock.hpp"
#include "report/event.hpp"

namespace cmrc {

using report::Time;

/// ERROR_* and RESPOND_* of task_block.inc, which are checked against these.
enum class ErrorOrigin : std::uint8_t {
  following = 1,
  fault,
  late,
  encoder,
  sway,
  landing,
  block,
  overspeed,
  saturation,
  heat
};
/// A drive is out of order: it has failed, or tripped.
constexpr bool is_fault(ErrorOrigin origin) { return origin == ErrorOrigin::fault || origin >= ErrorOrigin::overspeed; }
enum class Response : std::uint8_t { none, stop, hold, set_down, retry, second_sensor };

/// One error, from the instant at which it was noticed on.
struct ErrorEntry {
  ErrorOrigin origin{};
  Word of = 0;  ///< bit j: channel j of the drives, or axis j of the sway sensor; of a block given up its kind
  Robot robot = 0;
  Task lost = {};      ///< the block that was given up
  Word sensor = 0;     ///< of the sway: which sensor was in use
  bool tries = false;  ///< tries were left
  Time noticed{};
  std::optional<Time> decided = std::nullopt, done = std::nullopt, cleared = std::nullopt;
  Response response = Response::none;
  bool stands = false;  ///< its robot waits for the operator because of it
};

/// What the host does at the word of Errors.
class ErrorActions {
 public:
  virtual ~ErrorActions() = default;
  /// The crane's steps stand still, or go on.
  virtual void hold_crane(bool held) = 0;
  /// It lowers on until the load stands, and waits then; or that is called off.
  virtual void set_crane_down(bool asked) = 0;
  virtual bool crane_is_down() const = 0;
  virtual bool crane_lowers() const = 0;
  virtual void landing_decided(bool again) = 0;
  virtual void landing_again() = 0;
  /// What a block that was given up was for is asked for again, or stops, or goes on after it had stopped.
  virtual void ask_again(const Task& lost) = 0;
  virtual void stop_work(const Task& lost) = 0;
  virtual void resume_work(const Task& lost) = 0;
  /// Torque compensation and PID are released no more, so that the drives brake by their time-out; or again.
  virtual void stop_servo(bool stopped) = 0;
};

class Errors {
 public:
  Errors(const Config& config, const Words& words, ErrorActions& hands);

  /// What PID said in its TB_NOTIFY. \param tick of that block
  void pid_says(Word errors, std::uint32_t tick, Time now, HostServices& services);
  /// PID has not run for longer than the drives wait for a code: they have timed out.
  void pid_silent(Time now, HostServices& services);
  void landing_missed(bool tries, Time now, HostServices& services);
  void given_up(const Task& lost, bool tries, Time now, HostServices& services);
  /// An error block has ended, or has been given up itself.
  void decided(const Task& block, Word result, Time now, HostServices& services);
  void undecided(const Task& block, Time now);
  /// The operator's order.
  void clear(Time now, HostServices& services);
  /// Goes on with what has to wait for the servo or the crane.
  void refresh(Time now, HostServices& services);

  const PathClock& path() const { return path_; }
  const std::vector<ErrorEntry>& entries() const { return entries_; }
  /// Some robot stands because of an error that nobody has cleared.
  bool standing() const;
  void list_state(state::Visitor& list);

 private:
  void notice(ErrorEntry entry, Time now, HostServices& services);
  void carry_out(ErrorEntry& entry, Time now, HostServices& services);
  void finish(ErrorEntry& entry, Time now, HostServices& services);
  /// The path's clock is to go to this rate; it is written when the servo rests.
  void go_to_rate(double rate, double seconds);
  bool wanted_is_written() const { return !wanted_; }
  void tell(const ErrorEntry& entry, Word phase, HostServices& services) const;
  std::int64_t ticks(double seconds) const;
  std::size_t number_of(const ErrorEntry& entry) const { return static_cast<std::size_t>(&entry - entries_.data()); }

  const Config::Errors config_;
  const Words& words_;
  ErrorActions& hands_;
  double refresh_frequency_;
  std::int64_t servo_interval_;
  bool second_sensor_;

  std::vector<ErrorEntry> entries_;
  PathClock path_;
  struct Wanted {
    double rate;
    double seconds;
  };
  std::optional<Wanted> wanted_;
  Word drives_ = 0x1F;  // that are to be on
  bool drives_changed_ = false;
  std::array<Word, 11> known_{};  // by origin: joints or axes of errors that are not over; of trips as of faults
  Word& known(ErrorOrigin origin) {
    return known_.at(static_cast<std::size_t>(is_fault(origin) ? ErrorOrigin::fault : origin));
  }
  /// The origin of faults of which PID says why they tripped.
  ErrorOrigin trip_of(Word errors) const;
  Word sensor_ = 0;                       // the sway sensor in use
  std::int64_t sway_after_ = 0;           // PID's word on the sway counts from this tick on: it used the present sensor
  std::int64_t late_after_ = 0;           // the same for time-outs
  bool servo_stopped_ = false;            // by an error
  std::int64_t timeouts_ = 0;             // after which the crane has gone on by itself
  std::optional<std::int64_t> go_on_at_;  // after a time-out
};

}  // namespace cmrc

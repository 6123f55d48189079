#pragma once
// Errors (x = 1) in the host (docs/controller.md, Errors): PID, the crane or the watchdog notices an error; an error
// block on a DSP decides the response (c40_programs/kernels/error.asm); the host carries it out; the operator clears
// the error.
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/processes/host_services.hpp"
#include "cmrc/processes/path_clock.hpp"
#include "report/events/event.hpp"

namespace cmrc {

using report::Time;

/// Must equal ERROR_* and RESPOND_* of task_block.inc; this is checked.
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
/// The origin is a faulty drive: failed or tripped.
constexpr bool is_fault(ErrorOrigin origin) { return origin == ErrorOrigin::fault || origin >= ErrorOrigin::overspeed; }
enum class Response : std::uint8_t { none, stop, hold, set_down, retry, second_sensor };

/// One error from the instant at which it was noticed.
struct ErrorEntry {
  ErrorOrigin origin{};
  Word of = 0;  ///< bit j: channel j of the drives, or axis j of the sway sensor; for a block given up, its kind
  Robot robot = 0;
  Task lost = {};      ///< the block that was given up
  Word sensor = 0;     ///< for sway: the sensor in use
  bool tries = false;  ///< there are tries left
  Time noticed{};
  std::optional<Time> decided = std::nullopt, done = std::nullopt, cleared = std::nullopt;
  Response response = Response::none;
  bool stands = false;  ///< its robot waits for the operator because of it
  bool waits = true;    ///< for its error block, which has neither decided nor been given up
};

/// The host's actions for Errors.
class ErrorActions {
 public:
  virtual ~ErrorActions() = default;
  /// The crane's steps stop, or continue.
  virtual void hold_crane(bool held) = 0;
  /// Lowering continues until the load stands, and then waits; or this is cancelled.
  virtual void set_crane_down(bool asked) = 0;
  virtual bool crane_is_down() const = 0;
  virtual bool crane_lowers() const = 0;
  virtual void landing_decided(bool again) = 0;
  virtual void landing_again() = 0;
  /// The work of a block that was given up is requested again, or stops, or continues after a stop.
  virtual void ask_again(const Task& lost) = 0;
  /// \returns whether it is the servo's
  virtual bool stop_work(const Task& lost) = 0;
  virtual void resume_work(const Task& lost) = 0;
  /// Torque compensation and PID are no longer released, so that the drives' time-out brakes; or they are released
  /// again.
  virtual void stop_servo(bool stopped) = 0;
};

class Errors {
 public:
  Errors(const Config& config, const Words& words, ErrorActions& hands);

  /// PID's TB_NOTIFY. \param tick of that block
  void pid_says(Word errors, std::uint32_t tick, Time now, HostServices& services);
  /// PID has not run for longer than the drives wait for a code: the drives have timed out.
  void pid_silent(Time now, HostServices& services);
  void landing_missed(bool tries, Time now, HostServices& services);
  void given_up(const Task& lost, bool tries, Time now, HostServices& services);
  /// An error block has finished, or was itself given up.
  void decided(const Task& block, Word result, Time now, HostServices& services);
  void undecided(const Task& block, Time now, HostServices& services);
  /// The operator clears all errors. For those that wait for their error blocks, this is done when the last of these
  /// has ended.
  void clear(Time now, HostServices& services);
  /// Continues actions that have to wait for the servo or the crane.
  void refresh(Time now, HostServices& services);

  const PathClock& path() const { return path_; }
  const std::vector<ErrorEntry>& entries() const { return entries_; }
  /// Some robot waits because of an error that has not been cleared.
  bool standing() const;
  void list_state(state::Visitor& list);

 private:
  void notice(ErrorEntry entry, Time now, HostServices& services);
  void carry_out(ErrorEntry& entry, Time now, HostServices& services);
  void without_decision(const ErrorEntry& entry);
  void stop_work(const ErrorEntry& entry);
  void finish(ErrorEntry& entry, Time now, HostServices& services);
  /// Clears all errors that do not wait for their error blocks.
  void clear_decided(Time now, HostServices& services);
  void clear_when_asked(Time now, HostServices& services);
  /// The path's clock has to change to this rate; the change is written when the servo rests.
  void go_to_rate(double rate, double seconds);
  bool wanted_is_written() const { return !wanted_; }
  /// An error that has not been cleared has stopped the crane's set-points.
  bool must_stand() const;
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
  std::size_t clears_ = 0;  // the operator has cleared so many entries, the first ones, of which one still waits
  PathClock path_;
  struct Wanted {
    double rate;
    double seconds;
  };
  std::optional<Wanted> wanted_;
  Word drives_ = 0x1F;  // drives that have to be on
  bool drives_changed_ = false;
  std::array<Word, 11> known_{};  // by origin: joints or axes of open errors; trips are counted as faults
  Word& known(ErrorOrigin origin) {
    return known_.at(static_cast<std::size_t>(is_fault(origin) ? ErrorOrigin::fault : origin));
  }
  /// The origin of faults whose reason PID reports.
  ErrorOrigin trip_of(Word errors) const;
  Word sensor_ = 0;              // the sway sensor in use
  std::int64_t sway_after_ = 0;  // PID's report on sway counts from this tick on: from here PID used the present sensor
  std::int64_t late_after_ = 0;  // the same for time-outs
  bool servo_stopped_ = false;   // by an error
  std::int64_t timeouts_ = 0;    // time-outs after which the crane has continued by itself
  // After a time-out: all drives are off until then, and the crane continues then, unless it must stand.
  std::optional<std::int64_t> go_on_at_;
};

}  // namespace cmrc

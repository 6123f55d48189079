#include "cmrc/run/run_end.hpp"

#include <algorithm>

#include "cmrc/configuration/config.hpp"
#include "cmrc/host/host.hpp"
#include "machine/system/machine.hpp"
#include "plant/dock/dock.hpp"
#include "report/event.hpp"
#include "state/archive.hpp"

namespace cmrc {
namespace {

// The watchdog resets DSPs that are halted; if none works or is booted after this time, none is left.
constexpr Time patience = std::chrono::milliseconds{500};

}  // namespace

RunEnd::RunEnd(const Config& config, const machine::Machine& machine, plant::Dock& dock, const Host& host)
    : config_(config), machine_(machine), dock_(dock), host_(host), end_(report::from_seconds(config.run.duration_s)) {}

void RunEnd::look() {
  for (unsigned slot = 0; slot < machine_.slots(); ++slot)
    if (alive(slot)) last_alive_ = now();
  enabled_ = enabled_ || !dock_.braked();
  if (!enabled_ || !dock_.braked() || !host_.servoing()) last_driven_ = now();
  const Time after = report::from_seconds(config_.run.after_stop_s);
  if (config_.run.until == RunUntil::job_done && host_.job_done())
    return stop_account(report::StopReason::job_done, Time{});
  if (dock_.faulted()) return stop_account(report::StopReason::plant_fault, after);
  if (now() - last_alive_ >= patience) return stop_account(report::StopReason::no_dsp_left, after);
  if (now() - last_driven_ >= std::max(after, patience)) stop_account(report::StopReason::drives_stopped, Time{});
}

bool RunEnd::alive(unsigned slot) const {
  if (!machine_.plugged(slot) || machine_.standing(slot)) return false;
  return machine_.booted(slot) || machine_.in_reset(slot) || host_.boots(slot);
}

void RunEnd::stop_account(report::StopReason reason, Time after) {
  stop_ = stopped_by_ = reason;
  account_end_ = now();
  after_end_ = std::min(end_, now() + after);
  // Not before the plant's last call: an access that was broken off takes the plant a bus clock further.
  if (reason != report::StopReason::job_done) dock_.enable_drives(0, std::max(now(), dock_.time()));
}

bool RunEnd::resume() {
  if (!interrupted()) return false;
  stop_ = stopped_by_;
  return true;
}

Time RunEnd::now() const { return account_end_ ? std::max(*account_end_, dock_.time()) : machine_.time(); }

void RunEnd::list_state(state::Visitor& list) {
  list("last alive", last_alive_);
  list("last driven", last_driven_);
  list("enabled", enabled_);
  list("account end", account_end_);
  list("after end", after_end_);
  list("stop", stop_);
  list("stopped by", stopped_by_);
}

}  // namespace cmrc

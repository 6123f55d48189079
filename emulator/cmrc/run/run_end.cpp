#include "cmrc/run/run_end.hpp"

#include <algorithm>

#include "cmrc/configuration/config.hpp"
#include "cmrc/host/host.hpp"
#include "cmrc/measures/standstill.hpp"
#include "machine/system/machine.hpp"
#include "plant/dock/dock.hpp"
#include "report/events/event.hpp"
#include "state/archive.hpp"

namespace cmrc {
namespace {

// The watchdog resets DSPs that are halted; if none works or is booted after this time, none is left.
constexpr Time patience = std::chrono::milliseconds{500};

}  // namespace

RunEnd::RunEnd(const Config& config, const machine::Machine& machine, plant::Dock& dock, const Host& host,
               const Standstill& standstill)
    : config_(config),
      machine_(machine),
      dock_(dock),
      host_(host),
      standstill_(standstill),
      end_(report::from_seconds(config.run.duration_s)) {}

Time RunEnd::after_stop() const { return report::from_seconds(config_.run.after_stop_s); }

Time RunEnd::dsps_limit() const {
  const auto since = standstill_.of_dsps();
  return since ? *since + patience : machine::never;
}

Time RunEnd::drives_limit() const {
  const auto braked = standstill_.of_drives(), servoing = host_.servoing_from();
  return braked && servoing ? std::max(*braked, *servoing) + std::max(after_stop(), patience) : machine::never;
}

Time RunEnd::limit() const { return std::min(dsps_limit(), drives_limit()); }

void RunEnd::look() {
  if (now() % look_period == Time{}) {
    if (config_.run.until == RunUntil::job_done && host_.job_done())
      return stop_account(report::StopReason::job_done, Time{});
    if (dock_.faulted()) return stop_account(report::StopReason::plant_fault, after_stop());
  }
  if (now() >= dsps_limit()) return stop_account(report::StopReason::no_dsp_left, after_stop());
  if (now() >= drives_limit()) stop_account(report::StopReason::drives_stopped, Time{});
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
  list("account end", account_end_);
  list("after end", after_end_);
  list("stop", stop_);
  list("stopped by", stopped_by_);
}

}  // namespace cmrc

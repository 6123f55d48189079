#include "cmrc/run/job_causes.hpp"

#include "c40/chip/chip.hpp"
#include "cmrc/configuration/config.hpp"
#include "machine/system/machine.hpp"
#include "machine/system/machine_config.hpp"
#include "report/events/event.hpp"

namespace cmrc {
namespace {

constexpr auto arbitration = static_cast<std::size_t>(c40::Cause::bus_arbitration);
constexpr auto transfer = static_cast<std::size_t>(c40::Cause::bus_transfer);

Time servo_period(const Config& config) {
  return report::from_seconds(static_cast<double>(intervals(config).servo) / config.rates.refresh_frequency_hz);
}

}  // namespace

std::vector<std::string> cause_names() {
  std::vector<std::string> names;
  for (const c40::CauseRow& row : c40::cause_rows) names.emplace_back(row.name);
  return names;
}

std::vector<std::string> job_causes() {
  std::vector<std::string> names = cause_names();
  names[arbitration] = "bus_a_arbitration";
  names[transfer] = "bus_a_transfer";
  names.insert(names.end(), {"bus_b_arbitration", "bus_b_transfer"});
  return names;
}

CauseTimes job_causes(const machine::Machine& machine, unsigned slot) {
  const machine::Spent spent = machine.spent(slot);
  CauseTimes all;
  all.reserve(spent.causes.size() + 2);
  all.assign(spent.causes.begin(), spent.causes.end());
  all[arbitration] -= spent.window_b_arbitration;
  all[transfer] -= spent.window_b_transfer;
  all.insert(all.end(), {spent.window_b_arbitration, spent.window_b_transfer});
  return all;
}

LedgerConfig ledger_of(const Config& config, const machine::Config& machine) {
  LedgerConfig ledger;
  ledger.causes = job_causes();
  ledger.booked = cause_names();
  for (std::size_t i = 0; i < ledger.booked.size(); ++i) ledger.booked_as.push_back(i);
  ledger.booked_as.insert(ledger.booked_as.end(), {arbitration, transfer});
  ledger.servo_period = servo_period(config);
  for (const UserTask& task : config.tasks) {
    ledger.user_tasks.push_back(task.name);
    ledger.user_slots.push_back(task.dsp);
  }
  ledger.chip_clock = machine::Clock(machine.chip_hz, machine.chip_hz_denominator);
  ledger.misses_kept = static_cast<std::size_t>(config.report.misses_max);
  ledger.samples_max = static_cast<std::size_t>(config.report.samples_max);
  return ledger;
}

}  // namespace cmrc

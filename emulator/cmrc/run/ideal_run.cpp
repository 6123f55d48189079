#include "cmrc/run/ideal_run.hpp"

namespace cmrc {
namespace {

/// Failures of the machine, changes of its host's speed, and losses of the servo.
bool is_the_machines(const TimedEvent& event) {
  const bool sets = event.action == "set";
  const bool speed = sets && event.key.starts_with("host.");
  const bool lost = sets && event.key.starts_with("scheduling.servo_") && event.key != "scheduling.servo_reload";
  return speed || lost || concerns_machine(event);
}

}  // namespace

Config as_run(const Config& given) {
  if (!given.run.ideal) return given;
  Config config = given;
  // With more DSPs PID would not get the torque compensation of its own tick: the two are claimed at the same time.
  config.machine.dsps = 1;
  config.machine.slots = 0;
  config.machine.links.clear();
  config.machine.nets.clear();
  for (UserTask& task : config.tasks) task.dsp.reset();  // the one DSP does all tasks
  config.machine.boot = BootPolicy::preloaded;
  config.machine.idle_policy = IdlePolicy::doorbell;
  config.machine.cycle_time_factor = 1;
  config.host.refresh_overhead_ns = config.host.per_block_ns = config.host.semaphore_retry_ns = 0;
  config.dock.drive_delay_us = 0;
  config.scheduling.servo_loss_share = 0;
  config.scheduling.servo_loss_run = 1;
  config.scheduling.servo_served_every = 1;
  std::erase_if(config.events, is_the_machines);
  return config;
}

bool happens(const TimedEvent& event, const Config& config) { return !config.run.ideal || !is_the_machines(event); }

Config ideal(Config config) {
  config.run.ideal = true;
  return config;
}

}  // namespace cmrc

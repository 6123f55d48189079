#include "cmrc/programs/kernels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "cmrc/configuration/dock/nominal_dock.hpp"
#include "cmrc/configuration/dock/servo_law.hpp"
#include "cmrc/programs/plant_constants.hpp"
#include "cmrc/tasks/ti_float.hpp"
#include "plant/parameters/device_codes.hpp"

namespace cmrc {
namespace {

toolchain::Word& word_at(toolchain::Image& image, toolchain::Address address) {
  if (toolchain::Word* word = image.word_at(address)) return *word;
  throw ConfigError(fmt::format(
      "machine.programs: {:08X}h lies in no loaded section; the tables of dsp.asm are expected there", address));
}

/// Writes the words of the list at `label` into the image's constants. Each entry is: place on chip, number of words,
/// words; a place of 0 ends the list.
void place_constants(toolchain::Image& image, std::string_view label) {
  const toolchain::Word lift = image.symbol("LIFT");
  for (toolchain::Address at = image.symbol(label); word_at(image, at) != 0;) {
    const toolchain::Address place = word_at(image, at) + lift;
    const toolchain::Word count = word_at(image, at + 1);
    at += 2;
    for (toolchain::Word i = 0; i < count; ++i) word_at(image, place + i) = word_at(image, at++);
  }
}

/// Writes the limits of PID (errors.*) and of torque compensation (wind) into their constants; docs/controller.md,
/// Errors and Wind.
void place_limits(toolchain::Image& image, const Config& config) {
  const Config::Errors& e = config.errors;
  const bool gantry = config.dock.crane == CraneMachine::gantry;
  constexpr double milli = 1e-3, none = 1e6;
  using Milliseconds = std::chrono::duration<double, std::milli>;
  constexpr double sway_sample_ms = Milliseconds(plant::tick_latches * plant::latch_period).count();
  const std::array<double, 5> follow = {gantry ? none : e.following_travel_m,
                                        gantry ? e.following_travel_m : e.following_slew_mrad * milli,
                                        gantry ? e.following_trolley_m : e.following_luff_mrad * milli,
                                        e.following_hoist_m, e.following_rotator_mrad * milli};
  // With the law as printed, a joint lags by T_d times its speed until the integral has caught up. This lag at the
  // trajectory's top speed is not an error.
  const ControlLaw law = control_law(config.control, crane_parameters(config));
  const Config::Control& c = config.control;
  const std::array<double, 5> speed = {0, gantry ? c.travel.speed_limit : c.slew.speed_limit,
                                       gantry ? c.trolley.speed_limit : c.luff.speed_limit, c.hoist.speed_limit,
                                       c.rotator.speed_limit};
  const bool printed = config.kernels.pid == PidBuild::measurement_derivative;
  const auto limit = [&](std::size_t channel) {
    return follow[channel] + (printed ? law.rows.at(channel).derivative_s * speed.at(channel) : 0);
  };
  const auto refreshes = [&](double ms) {
    return static_cast<toolchain::Word>(std::llround(ms * milli * config.rates.refresh_frequency_hz));
  };
  const auto constant = [&](const char* name) -> toolchain::Address {
    return image.symbol(name) + image.symbol("LIFT");
  };
  const toolchain::Word sample = std::max<toolchain::Word>(1, refreshes(sway_sample_ms));
  for (std::size_t channel = 0; channel < follow.size(); ++channel)
    word_at(image, constant("K_PD_FOLLOW") + static_cast<toolchain::Word>(channel)) = ti_float(limit(channel));
  word_at(image, constant("K_PD_FOLLOW_TICKS")) = refreshes(e.following_ms);
  word_at(image, constant("K_PD_ENCODER_TICKS")) = refreshes(e.encoder_ms);
  const double turns = e.encoder_speed_percent * plant::rated_units / 100;
  word_at(image, constant("K_PD_TURNS")) = static_cast<toolchain::Word>(std::llround(turns));
  word_at(image, constant("K_PD_SAMPLE")) = sample;
  word_at(image, constant("K_TQ_WIND_LIMIT")) = static_cast<toolchain::Word>(wind_limit_mm_s(config));
  word_at(image, constant("K_PD_SAME")) = static_cast<toolchain::Word>(e.sway_samples);
}

}  // namespace

std::int32_t wind_limit_mm_s(const Config& config) {
  return static_cast<std::int32_t>(std::llround(config.dock.wind_limit_m_s * 1e3));
}

void place_kernel(toolchain::Image& image, toolchain::Word kind, std::string_view label, std::string_view key) {
  const auto program = image.symbols.find(label);
  if (program == image.symbols.end()) {
    throw ConfigError(
        fmt::format("{}: the DSP programs have no label {}; the entry of a kernel is expected", key, label));
  }
  if (kind >= image.symbol("KIND_COUNT")) {
    throw ConfigError(
        fmt::format("{}: the executive's table has no row {}; one below KIND_COUNT is expected", key, kind));
  }
  word_at(image, image.symbol("exec_kernels") + kind) = program->second;
}

void place_kernels(toolchain::Image& image, const Config& config) {
  const auto choose = [&](std::string_view kind, std::string_view label, std::string_view key) {
    place_kernel(image, image.symbol(kind), label, key);
  };
  const bool newton_euler = config.kernels.torque == TorqueBuild::newton_euler;
  const bool document = config.kernels.pid == PidBuild::measurement_derivative;
  const bool shaper = config.kernels.trajectory == TrajectoryBuild::quintic_shaper;
  if (newton_euler) choose("KIND_TORQUE", "kernel_torque_newton_euler", "kernels.torque");
  if (document) choose("KIND_PID", "kernel_pid_document", "kernels.pid");
  if (shaper) choose("KIND_TRAJECTORY_CRANE", "kernel_trajectory_crane_shaper", "kernels.trajectory");
  if (config.dock.crane == CraneMachine::gantry) {
    constexpr std::string_view key = "dock.crane";
    choose("KIND_TRAJECTORY_CRANE", shaper ? "kernel_trajectory_gantry_shaper" : "kernel_trajectory_gantry", key);
    choose("KIND_INVERSE_CRANE", "kernel_inverse_gantry", key);
    if (!newton_euler) choose("KIND_TORQUE", "kernel_torque_gantry", key);  // that build uses its table
    choose("KIND_PID", document ? "kernel_pid_gantry_document" : "kernel_pid_gantry", key);
    place_constants(image, "gantry_constants");
  }
  place_plant_constants(image, nominal_dock_of(config), config.dock.container_mass_kg);
  place_limits(image, config);
  switch (config.kernels.avoidance) {
    case AvoidanceBuild::none:
    case AvoidanceBuild::synthetic: break;
    case AvoidanceBuild::potential_field:
      choose("KIND_AVOIDANCE", "kernel_avoidance_potential", "kernels.avoidance");
      break;
    case AvoidanceBuild::vfh: choose("KIND_AVOIDANCE", "kernel_avoidance_vfh", "kernels.avoidance"); break;
    case AvoidanceBuild::dynamic_window: choose("KIND_AVOIDANCE", "kernel_avoidance_dwa", "kernels.avoidance"); break;
  }
  if (config.scheduling.slice_cycles > 0) {
    constexpr std::string_view key = "scheduling.slice_cycles";
    choose("KIND_IDENTIFY", "kernel_identify_sliced", key);
    choose("KIND_GRAB_PATH", "kernel_grab_path_sliced", key);
    if (config.kernels.avoidance == AvoidanceBuild::synthetic) choose("KIND_AVOIDANCE", "kernel_avoidance_sliced", key);
    if (config.kernels.avoidance == AvoidanceBuild::dynamic_window)
      choose("KIND_AVOIDANCE", "kernel_avoidance_dwa_sliced", key);
  }
  for (std::size_t i = 0; i < config.tasks.size(); ++i) {
    const UserTask& task = config.tasks[i];
    place_kernel(image, image.symbol("KIND_USER") + static_cast<toolchain::Word>(i), task.program,
                 task.origin.text() + ": tasks.program");
  }
}

}  // namespace cmrc

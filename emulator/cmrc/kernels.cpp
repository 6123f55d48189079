#include "cmrc/kernels.hpp"

#include <fmt/format.h>

namespace cmrc {
namespace {

toolchain::Word& word_at(toolchain::Image& image, toolchain::Address address) {
  for (auto& section : image.sections) {
    if (address >= section.address && address - section.address < section.words.size()) return section.words[address - section.address];
  }
  throw ConfigError("machine.programs: exec_kernels lies in no loaded section; the table of dsp.asm's executive is expected");
}

}  // namespace

void place_kernel(toolchain::Image& image, toolchain::Word kind, std::string_view label, std::string_view key) {
  const auto program = image.symbols.find(label);
  if (program == image.symbols.end()) {
    throw ConfigError(fmt::format("{}: the DSP programs have no label {}; the entry of a kernel is expected", key, label));
  }
  if (kind >= image.symbol("KIND_COUNT")) {
    throw ConfigError(fmt::format("{}: the executive's table has no row {}; one below KIND_COUNT is expected", key, kind));
  }
  word_at(image, image.symbol("exec_kernels") + kind) = program->second;
}

void place_kernels(toolchain::Image& image, const Config& config) {
  const auto choose = [&](std::string_view kind, std::string_view label, std::string_view key) {
    place_kernel(image, image.symbol(kind), label, key);
  };
  if (config.kernels.torque == TorqueBuild::newton_euler) choose("KIND_TORQUE", "kernel_torque_newton_euler", "kernels.torque");
  if (config.kernels.pid == PidBuild::measurement_derivative) choose("KIND_PID", "kernel_pid_document", "kernels.pid");
  if (config.kernels.trajectory == TrajectoryBuild::quintic_shaper) {
    choose("KIND_TRAJECTORY_CRANE", "kernel_trajectory_crane_shaper", "kernels.trajectory");
  }
  switch (config.kernels.avoidance) {
    case AvoidanceBuild::none:
    case AvoidanceBuild::synthetic: break;
    case AvoidanceBuild::potential_field: choose("KIND_AVOIDANCE", "kernel_avoidance_potential", "kernels.avoidance"); break;
    case AvoidanceBuild::vfh: choose("KIND_AVOIDANCE", "kernel_avoidance_vfh", "kernels.avoidance"); break;
    case AvoidanceBuild::dynamic_window: choose("KIND_AVOIDANCE", "kernel_avoidance_dwa", "kernels.avoidance"); break;
  }
  if (config.scheduling.slice_cycles > 0) {
    constexpr std::string_view key = "scheduling.slice_cycles";
    choose("KIND_IDENTIFY", "kernel_identify_sliced", key);
    choose("KIND_GRAB_PATH", "kernel_grab_path_sliced", key);
    if (config.kernels.avoidance == AvoidanceBuild::synthetic) choose("KIND_AVOIDANCE", "kernel_avoidance_sliced", key);
    if (config.kernels.avoidance == AvoidanceBuild::dynamic_window) choose("KIND_AVOIDANCE", "kernel_avoidance_dwa_sliced", key);
  }
  for (std::size_t i = 0; i < config.tasks.size(); ++i) {
    const UserTask& task = config.tasks[i];
    place_kernel(image, image.symbol("KIND_USER") + static_cast<toolchain::Word>(i), task.program, task.origin.text() + ": tasks.program");
  }
}

}  // namespace cmrc

// Layouts of the dock in TOML. The plant can be built with each layout that is accepted. Behind a line of four dashes
// stand accesses to its devices, at any instants.
#include "plant/parameters/layout_file.hpp"

#include <chrono>
#include <cmath>

#include "fuzz/target.hpp"
#include "plant/dock/dock.hpp"
#include "plant/parameters/check.hpp"

namespace {

plant::DockConfig config_of(unsigned choice) {
  const int agvs = 1 + static_cast<int>(choice >> 1 & 7);
  return (choice & 1) != 0 ? plant::gantry_dock(agvs) : plant::default_dock(agvs);
}

void write(plant::Dock& dock, fuzz::Input& input, plant::Time now) {
  const unsigned what = input.byte(), which = input.byte();
  const int joint = static_cast<int>(which % plant::joint_count);
  const int agv = static_cast<int>(which) % dock.agv_count();
  const auto value = static_cast<std::int32_t>(input.word());
  switch (what % 10) {
    case 0: return dock.enable_drives(which, now);
    case 1:
    case 2: return dock.set_torque_code(joint, value % 40'000, now);
    case 3: return dock.fail_drive(joint, (value & 1) != 0, now);
    case 4: return dock.spreader_command(which & 1, now);
    case 5: return dock.agv_push(agv, value % 4000, value >> 8, value >> 16, now);
    case 6: return dock.agv_period(agv, static_cast<std::uint32_t>(value), now);
    case 7: return dock.agv_reset_bumper(agv, now);
    case 8: return dock.select_row(value % 8, now);
    default: dock.fail_encoder(joint, (value & 1) != 0, now);
  }
}

void expect_finite(const plant::Dock& dock) {
  const plant::Signal at = dock.signal();
  double sum = at.alpha + at.beta + at.yaw + at.tension;
  for (std::size_t n = 0; n < at.q.size(); ++n) sum += at.q[n] + at.qd[n] + at.torque[n];
  for (std::size_t n = 0; n < 3; ++n) sum += at.tip[n] + at.payload[n];
  for (int n = 0; n < dock.agv_count(); ++n) sum += dock.agv(n).x + dock.agv(n).y + dock.agv(n).heading;
  for (const plant::ContainerStatus& one : dock.containers()) sum += one.x + one.y + one.z;
  fuzz::expect(std::isfinite(sum), "a number of the dock is not finite");
}

/// Up to 40 ms, with the last accesses or after them.
void touch(plant::Dock& dock, fuzz::Input& input) {
  constexpr int most_accesses = 20;
  plant::Time now{0};
  for (int n = 0; n < most_accesses && !input.empty(); ++n) {
    now += std::chrono::microseconds(input.byte() * 8);
    write(dock, input, now);
    dock.encoder(n % plant::joint_count, now);
    dock.sway(n % 2, now);
    dock.scan_y(now);
    dock.range_scan(n % dock.agv_count(), now);
  }
  dock.advance_to(now + std::chrono::milliseconds(2));
  expect_finite(dock);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 16384;
  if (size > most) return 0;
  fuzz::Input input(data, size);
  const std::string_view text = input.part();
  plant::DockConfig config = config_of(input.byte());
  if (!fuzz::done<plant::LayoutError>([&] { plant::apply_layout(config, text, "input"); })) return 0;
  fuzz::done<std::invalid_argument, std::runtime_error>([&] {
    plant::Dock dock(config);
    touch(dock, input);
  });
  return 0;
}

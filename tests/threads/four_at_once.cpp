// Four simulations in four threads of one process end as they do alone: four_at_once [SECONDS]. `make trust` runs it
// under the thread sanitizer.
#include <array>
#include <cstdio>
#include <exception>
#include <string>
#include <thread>

#include "cmrc/configuration/config.hpp"
#include "cmrc/run/simulation.hpp"

namespace {

/// Scenes that are no two alike. Without the ideal run, which is a process of its own.
cmrc::Config scene(unsigned number, double seconds) {
  cmrc::ConfigBuilder builder;
  const cmrc::Origin here{.name = "four_at_once"};
  builder.set("run.duration_s", seconds, here).set("report.reference", std::string("none"), here);
  builder.set("machine.dsps", std::int64_t{1 + number}, here).set("run.seed", std::int64_t{7 + number}, here);
  if (number % 2 == 1) builder.preset("heavy", here);
  if (number == 2) builder.set("run.phase_jitter", true, here);
  return builder.build();
}

std::string hash_of(unsigned number, double seconds) {
  cmrc::Simulation simulation(scene(number, seconds));
  simulation.run();
  return simulation.report().hash;
}

int run(double seconds) {
  std::array<std::string, 4> alone, together;
  std::array<std::thread, 4> threads;
  for (unsigned n = 0; n < 4; ++n)
    threads[n] = std::thread([n, seconds, &together] {
      try {
        together[n] = hash_of(n, seconds);
      } catch (const std::exception& error) {
        together[n] = error.what();
      }
    });
  for (std::thread& thread : threads) thread.join();
  int different = 0;
  for (unsigned n = 0; n < 4; ++n) {
    alone[n] = hash_of(n, seconds);
    std::printf("%u alone %s, at once %s\n", n, alone[n].c_str(), together[n].c_str());
    different += alone[n] != together[n] ? 1 : 0;
  }
  return different == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? std::atof(argv[1]) : 0.1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "four_at_once: %s\n", error.what());
    return 2;
  }
}

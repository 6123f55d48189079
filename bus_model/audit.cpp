#include "bus_model/audit.hpp"

#include <algorithm>

#include "bus_model/bus.hpp"

namespace pci {

std::vector<std::string> audit(const Bus& bus, Clocks clock) {
  std::vector<std::string> faults;
  const auto report = [&](const std::string& what) { faults.push_back("bus " + bus.config().name + ": " + what); };
  const auto text = [](auto number) { return std::to_string(number); };

  const Clocks counted = bus.statistics(clock).total();
  if (counted != clock) report(text(clock) + " clocks have passed, " + text(counted) + " are accounted for");

  std::uint64_t by_masters = 0, by_targets = 0;
  Clocks timer = 0, longest = 0;
  for (unsigned i = 0; i < bus.masters(); ++i) {
    const MasterStatistics& master = bus.master_statistics(i);
    by_masters += master.words_read + master.words_written;
    timer = std::max(timer, bus.master_config(i).latency_timer);
    longest = std::max(longest, master.wait.max());
  }
  for (unsigned i = 0; i < bus.targets(); ++i)
    by_targets += bus.target_statistics(i).words_read + bus.target_statistics(i).words_written;
  if (by_masters != by_targets || by_masters != bus.words_moved())
    report("masters moved " + text(by_masters) + " words, targets " + text(by_targets) + ", data phases " +
           text(bus.words_moved()));

  const BusConfig& config = bus.config();
  if (config.arbitration == Arbitration::round_robin && config.multi_transaction_timer == 0 && !bus.was_stalled() &&
      bus.masters() != 0) {
    const Clocks bound = (bus.masters() - 1) * (timer + 16 + 8) + config.grant_clocks + 1;
    if (longest > bound) report("a master waited " + text(longest) + " clocks; the bound is " + text(bound));
  }
  return faults;
}

}  // namespace pci

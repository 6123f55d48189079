#pragma once
// The records that a bus keeps for its masters and targets; only files of this room include them.
#include <vector>

#include "bus_model/bus.hpp"

namespace pci {

struct Bus::Port {
  MasterConfig config;
  Initiator* initiator;
  std::vector<Word> data;
  Transaction transaction;
  unsigned wanted = 0;
  unsigned done = 0;
  unsigned agent = 0;
  bool active = false;
  bool speculative = false;
  bool attempted = false;
  std::int16_t last_target = -1;  // of the attempt before: where to look first
  MasterStatistics statistics;

  void list_state(state::Visitor& list) {
    list("data", data);
    list("transaction", transaction);
    list("wanted", wanted);
    list("done", done);
    list("agent", agent);
    list("active", active);
    list("speculative", speculative);
    list("attempted", attempted);
    list("statistics", statistics);
  }
};

struct Bus::Window {
  TargetConfig config;
  Target* target;
  Address base;
  std::uint64_t words;
  bool takes_all = false;  // each access whole, at once
  // delayed read
  bool fetching = false;
  std::uint16_t fetch_master = 0;
  Address fetch_address = 0;
  unsigned fetch_words = 0;
  Clocks fetch_ready = 0;
  Clocks drained = 0;  // the posted-write queue is empty from this clock on
  TargetStatistics statistics;

  void list_state(state::Visitor& list) {
    list("fetching", fetching);
    list("fetch master", fetch_master);
    list("fetch address", fetch_address);
    list("fetch words", fetch_words);
    list("fetch ready", fetch_ready);
    list("drained", drained);
    list("statistics", statistics);
  }
};

}  // namespace pci

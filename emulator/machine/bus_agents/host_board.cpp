#include "machine/bus_agents/host_board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace machine {

namespace {

// The shortest way of a word from the host's processor to its target.
pci::Clocks time_of_write(const Config& config) {
  if (config.instant_access) return 0;
  return config.host_bridge.request_sync + config.shared_memory.devsel + config.shared_memory.write_initial + 1;
}

}  // namespace

HostBoard::HostBoard(HostProgram& program, const Config& config, std::deque<pci::Bus>& buses,
                     const std::vector<BusRoute>& routes, std::vector<Clock> bus_clocks,
                     const SharedRegisters& registers, const LinkAdapter& adapter)
    : program_{program},
      config_{config},
      buses_{buses},
      clocks_{std::move(bus_clocks)},
      clock_{clocks_[config.topology.host.front()]},
      registers_{registers},
      adapter_{adapter},
      action_time_{clock_.at(time_of_write(config) + config.interrupt_clocks) - clock_.at(0)} {
  pci::MasterConfig master = config.host_master;
  master.first_level = true;
  for (const unsigned bus : config.topology.host) bridges_.emplace_back(buses[bus], master, config.host_bridge, *this);
  for (const BusRoute& route : routes)
    paths_.push_back({route, bridges_[route.port], clocks_[config.topology.host[route.port]], {}});
  waiting_.reserve(1024);
  words_read_.reserve(1024);
  set_next(Time{0});
}

void HostBoard::set_next(Time now) {
  next_ = std::max(paused_until_, std::min(read_done_, std::max(now, program_.next_wake())));
  changed();
}

void HostBoard::pause(Time until) {
  paused_until_ = std::max(paused_until_, until);
  next_ = std::max(next_, paused_until_);
  changed();
}

void HostBoard::act(Time now) {
  cpu_ = std::max(cpu_, clock_.tick_at_or_after(now));
  if (read_done_ <= now) {
    read_done_ = never;
    words_wanted_ = 0;
    program_.read_done(tag_, words_read_, now, *this);
  }
  if (program_.next_wake() <= now) program_.wake(now, *this);
  set_next(now);
}

void HostBoard::list_state(state::Visitor& list) {
  list("bridges", bridges_);
  list("next", next_);
  list("read done", read_done_);
  list("paused until", paused_until_);
  list("written", written_);
  list("cpu", cpu_);
  list("waiting", waiting_);
  list("first waiting", first_waiting_);
  list("acting", acting_);
  list("tag", tag_);
  list("read offset", read_offset_);
  list("words wanted", words_wanted_);
  list("words read", words_read_);
}

Time HostBoard::earliest_action(Time woken) const {
  // A program that waits for words wakes no earlier than its bus's next event; then its write has to cross the bridge
  // and the bus.
  const Time wakes = std::min(next_, woken);
  const Time acts = words_wanted_ != 0 && read_done_ == never ? std::min(wakes, next_bus_event()) : wakes;
  Time earliest = acts == never ? never : acts + action_time_ - Time{1};
  if (acting_ != registers_.acted()) earliest = std::min(earliest, next_bus_event());
  return earliest;
}

// The earliest event of a bus that carries, or may get, a word of the host.
Time HostBoard::next_bus_event() const {
  Time next = never;
  const auto offer = [&](std::size_t bus) {
    const pci::Clocks event = buses_[bus].next_event();
    if (event != pci::never) next = std::min(next, clocks_[bus].at(event));
  };
  if (config_.topology.bridges.empty()) {
    for (const unsigned bus : config_.topology.host) offer(bus);
  } else {
    for (std::size_t bus = 0; bus < buses_.size(); ++bus) offer(bus);
  }
  return next;
}

bool HostBoard::blocked() const {
  return std::ranges::any_of(bridges_, [](const pci::Bridge& bridge) { return bridge.blocked(); });
}

void HostBoard::require_answers(Offset offset, std::size_t words, bool write) const {
  for (std::size_t i = 0; i < words; ++i) {
    const auto one = static_cast<Offset>(offset + i);
    const bool shared = one < SharedSram::size || registers_.answers(one, write, true) || adapter_.answers(one, write);
    const bool routed = std::ranges::any_of(paths_, [&](const Path& path) { return path.route.holds(one); });
    if (!routed || !(shared || one >= host_devices))
      throw std::out_of_range{
          fmt::format("the host {} offset {:X}h, where no device answers", write ? "writes to" : "reads from", one)};
  }
}

void HostBoard::read(Offset offset, unsigned n_words, std::uint32_t tag) {
  if (words_wanted_ != 0) throw std::logic_error{"HostPort::read: another read is outstanding; wait for read_done"};
  if (n_words == 0) throw std::invalid_argument{"HostPort::read of no words"};
  require_answer(offset, n_words, false);
  tag_ = tag;
  read_offset_ = offset;
  words_wanted_ = n_words;
  words_read_.clear();
  feed();
}

void HostBoard::write(Offset offset, std::span<const Word> words) {
  if (words_wanted_ != 0)
    throw std::logic_error{"HostPort::write while a read is outstanding: the host's processor waits for it"};
  require_answer(offset, words.size(), true);
  const auto at = [&](std::size_t i) { return static_cast<Offset>(offset + i); };
  if (offset + words.size() > SharedSram::size)
    for (std::size_t i = 0; i < words.size(); ++i) acting_ += registers_.acts_on_dsps(at(i));
  std::size_t posted = 0;
  if (waiting_.empty()) {
    Path* path = nullptr;
    for (bool free = !blocked(); free && posted < words.size(); ++posted) {
      if (path == nullptr || !path->route.holds(at(posted))) path = &path_to_write(at(posted));
      free = post(*path, at(posted), words[posted]);
    }
  }
  for (; posted < words.size(); ++posted) waiting_.push_back({.address = at(posted), .value = words[posted]});
}

HostBoard::Path& HostBoard::path_to_write(Offset offset) {
  Path& path = *path_of(offset);
  written_ = static_cast<unsigned>(&path - paths_.data());
  return path;
}

// Passes to the bridges what they accept: writes in order, then the read. A write that finds no room blocks the board.
void HostBoard::feed() {
  bool free = !blocked();
  while (free && first_waiting_ < waiting_.size()) {
    const pci::Posted& next = waiting_[first_waiting_++];
    free = post(path_to_write(next.address), next.address, next.value);
  }
  if (first_waiting_ == waiting_.size()) {
    waiting_.clear();
    first_waiting_ = 0;
    if (words_wanted_ != 0 && free) ask();
  }
}

void HostBoard::taken(pci::Clocks ready, pci::Clocks) {
  cpu_ = std::max(cpu_, own_clock(paths_[written_], ready));
  feed();
}

// What the target does not take now goes through the bridge, and what comes after it must not overtake it.
bool HostBoard::access_instantly(Path& path, Offset offset, bool write, Word& value) {
  const pci::Access seen{.master = path.bridge.master(), .clock = bus_clock(path, cpu_)};
  const pci::Address address = offset + path.route.shift;
  if (!path.bridge.idle()) return false;
  if (!path.target.holds(address)) path.target = buses_[path.route.bus].window_at(address);
  return path.target.holds(address) && path.target.access(address, write, value, seen);
}

// Requests the words that are still missing, one after another.
void HostBoard::ask() {
  while (words_read_.size() < words_wanted_) {
    Path& path = *path_of(read_offset_);
    const pci::Clocks clock = bus_clock(path, cpu_);
    Word value = 0;
    if (!config_.instant_access || !access_instantly(path, read_offset_, false, value))
      return path.bridge.read(read_offset_ + path.route.shift, clock);
    take(path, value, clock);
  }
}

void HostBoard::answered(Word value, pci::Clocks ready, pci::Clocks, pci::Result) {
  take(*path_of(read_offset_), value, ready);
  ask();
}

void HostBoard::take(const Path& path, Word value, pci::Clocks ready) {
  cpu_ = std::max(cpu_, own_clock(path, ready));
  words_read_.push_back(value);
  read_offset_ += 1;
  if (words_read_.size() < words_wanted_) return;
  read_done_ = path.clock.at(ready);
  next_ = std::max(paused_until_, std::min(next_, read_done_));
  changed();
}

}  // namespace machine

// Host scripts and words for devices of a board, and devices that are sent them: a console, a FIFO, a mailbox and a
// timer, which a program touches in any order and at any time.
#include "machine/boards/host_script.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "fuzz/target.hpp"
#include "machine/boards/board_devices.hpp"
#include "state/archive.hpp"

namespace {

using machine::BoardDevices;
using machine::HostStep;

constexpr std::size_t most = 8192;
constexpr c40::Address words_each = 0x10;

std::vector<machine::DeviceDescription> described(const std::vector<HostStep>& steps, fuzz::Input& input) {
  std::vector<machine::DeviceDescription> all;
  for (const machine::DeviceKind kind : {machine::DeviceKind::console, machine::DeviceKind::fifo,
                                         machine::DeviceKind::mailbox, machine::DeviceKind::timer}) {
    machine::DeviceDescription device;
    device.kind = kind;
    device.name = machine::name(kind);
    device.base = static_cast<c40::Address>(all.size()) * words_each;
    device.stride = 1 + input.byte() % 2;
    device.words = (machine::row_of(kind).words - 1) * device.stride + 1;
    device.pin = static_cast<c40::Pin>(all.size());
    device.depth = kind == machine::DeviceKind::mailbox ? 1 : 1 + input.byte() % 5;
    device.input_cycles = input.byte() % 9;
    device.output_cycles = input.byte() % 9;
    device.count_cycles = 1 + input.byte() % 3;
    if (kind != machine::DeviceKind::timer) device.input = machine::DeviceInput{"script", "", steps};
    all.push_back(std::move(device));
  }
  return all;
}

/// The part of the devices that a program and a board's pins can see.
class Seen {
 public:
  explicit Seen(const std::vector<machine::DeviceDescription>& devices) : devices_(devices) {
    devices_.on_pin = [this](c40::Pin pin, bool level, c40::Cycles cycle) {
      output_ += std::to_string(static_cast<int>(pin)) + (level ? " high " : " low ") + std::to_string(cycle) + '\n';
    };
  }
  void access(const c40::ExternalAccess& access) {
    devices_.advance_to(access.cycle);
    const auto answer = devices_.access(access);
    if (answer) output_ += std::to_string(answer->value) + '\n';
  }
  void advance_to(c40::Cycles now) { devices_.advance_to(now); }
  BoardDevices& devices() { return devices_; }
  const std::string& output() const { return output_; }

 private:
  BoardDevices devices_;
  std::string output_;
};

/// One run stops at every cycle, another is saved and loaded: the program sees no difference.
void touch(const std::vector<HostStep>& steps, fuzz::Input input) {
  constexpr int most_accesses = 200;
  const auto devices = described(steps, input);
  Seen whole(devices), cut(devices), loaded(devices);
  std::string before;
  c40::Cycles now = 0;
  for (int n = 0; n < most_accesses && !input.empty(); ++n) {
    const unsigned what = input.byte();
    c40::ExternalAccess access;
    access.address = (what & 3) * words_each + (what >> 2 & 7);
    access.write = (what & 0x20) != 0;
    access.value = access.write ? ((what & 0x40) != 0 ? input.word() : input.byte()) : 0;
    const c40::Cycles later = now + (input.byte() & 0x3F);
    for (c40::Cycles cycle = now; cycle <= later; ++cycle) cut.advance_to(cycle);
    access.cycle = now = later;
    whole.access(access);
    cut.access(access);
    if (n == 20) {
      state::load(loaded.devices(), state::save(whole.devices()));
      before = whole.output();
    } else if (n > 20) {
      loaded.access(access);
    }
    fuzz::expect(whole.output() == cut.output(), "devices that are cut do something else");
  }
  if (!before.empty())
    fuzz::expect(before + loaded.output() == whole.output(), "devices that are loaded do something else");
}

/// Words come in the order of the script, however long the program lets them wait.
void take(const std::vector<HostStep>& steps) {
  constexpr c40::Cycles far = c40::Cycles{1} << 40;
  std::vector<c40::Word> expected, taken;
  for (const HostStep& step : steps) expected.insert(expected.end(), step.words.begin(), step.words.end());
  machine::HostScript script(steps);
  c40::Cycles now = 0;
  std::size_t at = 0;
  while (!script.done()) {
    if (script.next() == machine::never_cycle) {  // it waits for the program
      for (; at < steps.size() && steps[at].when != HostStep::When::on; ++at) {
      }
      if (at == steps.size()) break;
      script.heard(static_cast<c40::Word>(steps[at++].number), now);
      continue;
    }
    if (script.next() > far) break;
    fuzz::expect(script.next() >= now, "a word comes before the one before it");
    taken.push_back(script.take(now = std::max(now, script.next())));
  }
  fuzz::expect(taken.size() <= expected.size() && std::equal(taken.begin(), taken.end(), expected.begin()),
               "words come in another order");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > most) return 0;
  fuzz::Input input(data, size);
  const std::string text(input.part());
  std::vector<HostStep> steps;
  fuzz::done<machine::HostScriptError>([&] {
    steps = machine::parse_host_script(text, "script");
    const std::string written = machine::to_text(steps);
    fuzz::expect(machine::parse_host_script(written, "script") == steps, "a script is written as another one");
    take(steps);
  });
  fuzz::done<machine::HostScriptError>([&] {
    for (const HostStep& step : machine::parse_host_words(text, "words"))
      fuzz::expect(!step.words.empty() && step.number == 0, "words that come at another time");
  });
  std::size_t count = 0;
  for (const HostStep& step : machine::characters(text)) count += step.words.size();
  fuzz::expect(count == text.size(), "characters are missing");
  touch(steps, input);
  return 0;
}

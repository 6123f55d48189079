// The kinds of devices that a board file can name: one row each, with the properties of the kind.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>

#include "machine/boards/board_device.hpp"
#include "machine/boards/board_fifo.hpp"
#include "machine/boards/board_timer.hpp"
#include "machine/boards/board_vme.hpp"

namespace machine {
namespace {

using c40::Address;
using c40::Cycles;
using c40::Word;

/// +0: a character read or written, +1: status. The line brings each character when the host sends it, whether or not
/// the program has read those before.
class Console final : public BoardDevice {
 public:
  explicit Console(const DeviceDescription& described) {
    if (described.input) host_ = HostScript(described.input->steps);
  }
  Word read(Address offset, Cycles /*now*/) override {
    if (offset == status) return can_be_sent | (in_.empty() ? 0 : has_come);
    if (in_.empty()) return 0;
    const Word character = in_.front();
    in_.pop_front();
    return character;
  }
  void write(Address offset, Word value, Cycles now) override {
    if (offset == status) return;
    sent_.push_back(value & 0xFF);
    host_.heard(value & 0xFF, now);
  }
  void advance_to(Cycles now) override {
    while (host_.next() <= now) in_.push_back(host_.take(host_.next()) & 0xFF);
  }
  Cycles next_event() const override { return in_.empty() ? host_.next() : never_cycle; }
  bool continues() const override { return !in_.empty() || host_.next() != never_cycle; }
  bool interrupts() const override { return !in_.empty(); }
  const std::vector<Word>* sent() const override { return &sent_; }
  HostScript* host() override { return &host_; }
  void list_state(state::Visitor& list) override {
    list("host", host_);
    list("in", in_);
    list("sent", sent_);
  }

 private:
  static constexpr Word has_come = 1, can_be_sent = 2;
  static constexpr Address status = 1;
  HostScript host_;
  std::deque<Word> in_;
  std::vector<Word> sent_;
};

class Registers final : public BoardDevice {
 public:
  explicit Registers(const DeviceDescription& described) : words_(described.words, described.value) {}
  Word read(Address offset, Cycles) override { return words_[offset]; }
  void write(Address offset, Word value, Cycles) override { words_[offset] = value; }
  void list_state(state::Visitor& list) override { list("words", words_); }

 private:
  std::vector<Word> words_;
};

template <class Device>
std::unique_ptr<BoardDevice> made(const DeviceDescription& described) {
  return std::make_unique<Device>(described);
}

constexpr auto rows = std::to_array<DeviceKindRow>({
    {DeviceKind::console, "console", 2, false, "pin input script stride", made<Console>},
    {DeviceKind::registers, "registers", 0, false, "words value", made<Registers>},
    {DeviceKind::led, "led", 0, false, "words value", made<Registers>},
    {DeviceKind::fifo, "fifo", Fifo::registers, false, "pin depth input script input_cycles output_cycles stride",
     made<Fifo>},
    {DeviceKind::mailbox, "mailbox", Fifo::registers, false, "pin input script input_cycles output_cycles stride",
     made<Fifo>},
    {DeviceKind::timer, "timer", Timer::registers, false, "pin count_cycles stride", made<Timer>},
    {DeviceKind::vic068a, "vic068a", Vic068a::registers, false, "pin stride shift value", made<Vic068a>},
    {DeviceKind::vme, "vme", 0, true, "words answer vic", made<VmeSpace>},
});

}  // namespace

std::span<const DeviceKindRow> device_kinds() { return rows; }

const DeviceKindRow& row_of(DeviceKind kind) { return *std::ranges::find(rows, kind, &DeviceKindRow::kind); }

std::string_view name(DeviceKind kind) { return kind == DeviceKind::own ? "class" : row_of(kind).name; }

std::string configuration_of(const DeviceDescription& d) {
  return fmt::format("device {} {:X} {} {} {} {} {} {} {} {} {} {} {} {}\n", name(d.kind), d.base, d.words, d.waits,
                     d.value, d.pin ? name(*d.pin) : "", d.depth, d.input_cycles, d.output_cycles, d.count_cycles,
                     d.stride, d.shift, d.bus_error, d.vic);
}

std::optional<c40::Pin> interrupt_pin_named(std::string_view text) {
  for (const c40::Pin pin : {c40::Pin::iiof0, c40::Pin::iiof1, c40::Pin::iiof2, c40::Pin::iiof3, c40::Pin::nmi})
    if (c40::name(pin) == text) return pin;
  return std::nullopt;
}

}  // namespace machine

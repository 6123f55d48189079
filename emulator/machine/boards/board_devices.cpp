#include "machine/boards/board_devices.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "c40/values/float40.hpp"
#include "isa/types.hpp"
#include "machine/boards/board_vme.hpp"

namespace machine {

using c40::Address;
using c40::Cycles;
using c40::Pin;
using c40::Word;

namespace {
constexpr unsigned bit(Pin pin) { return 1u << static_cast<unsigned>(pin); }
}  // namespace

bool behind_window(const c40::Board& board, Address base, std::uint64_t words) {
  return std::ranges::any_of(board.regions, [&](const c40::Region& region) {
    return region.kind == c40::Region::Kind::external_window && base >= region.base &&
           base + words <= region.base + region.words;
  });
}

BoardDevices::BoardDevices(const std::vector<DeviceDescription>& described) {
  for (const DeviceDescription& device : described) places_.push_back({device, row_of(device.kind).make(device)});
  join_vme();
}

void BoardDevices::join_vme() {
  for (const Place& place : places_)
    if (auto* space = dynamic_cast<VmeSpace*>(place.device.get()); space != nullptr && !place.described.vic.empty())
      space->tell(dynamic_cast<BusErrorStatus*>(named(place.described.vic).device.get()));
}

void BoardDevices::add(const c40::Board& board, DeviceDescription described, std::shared_ptr<BoardDevice> device) {
  const std::uint64_t end = std::uint64_t{described.base} + described.words;
  if (!behind_window(board, described.base, described.words))
    throw std::invalid_argument(
        fmt::format("device {} at {:08X}h: a device needs a region of kind \"window\", and no such region of the board "
                    "{} has {:08X}h to {:08X}h",
                    described.name, described.base, board.name, described.base, end - 1));
  for (const auto& [other, unused] : places_)
    if (described.base < std::uint64_t{other.base} + other.words && other.base < end)
      throw std::invalid_argument(fmt::format("device {} at {:08X}h: {} is there, at {:08X}h", described.name,
                                              described.base, other.name, other.base));
  places_.push_back({std::move(described), std::move(device)});
}

const BoardDevices::Place& BoardDevices::named(std::string_view name) const {
  std::vector<std::string> names;
  for (const Place& place : places_) {
    if (place.described.name == name) return place;
    names.push_back(place.described.name);
  }
  throw std::invalid_argument(
      names.empty() ? fmt::format("there is no device {}; the board has none", name)
                    : fmt::format("there is no device {}; the board has {}", name, fmt::join(names, ", ")));
}

BoardDevices::Place* BoardDevices::at(Address address) {
  const auto found = std::ranges::find_if(
      places_, [&](const Place& place) { return address - place.described.base < place.described.words; });
  return found == places_.end() ? nullptr : &*found;
}

const BoardDevices::Place& BoardDevices::at_address(Address address) const {
  const Place* place = at(address);
  if (place == nullptr) throw std::out_of_range(fmt::format("no device at {:08X}h", address));
  return *place;
}

bool BoardDevices::acts_on_others(Address address) const {
  const Place* place = at(address);
  return place != nullptr && place->device->acts_on_others();
}

bool BoardDevices::act_on_others() const {
  return std::ranges::any_of(places_, [](const Place& place) { return place.device->acts_on_others(); });
}

bool BoardDevices::will_act_on_others() const {
  return std::ranges::any_of(places_, [](const Place& place) {
    return place.device->acts_on_others() && place.device->next_event() != never_cycle;
  });
}

std::optional<BoardDevices::Answer> BoardDevices::access(const c40::ExternalAccess& access) {
  Place* place = at(access.address);
  if (place == nullptr) return std::nullopt;
  // Accesses come in the order of their cycles; what has happened is not undone.
  const Cycles now = std::max(now_, access.cycle);
  advance_to(now);
  now_ = now;
  BoardDevice& device = *place->device;
  device.advance_to(now);
  const Address stride = place->described.stride;
  const Address offset = (access.address - place->described.base) / stride;
  Word value = 0;
  if ((access.address - place->described.base) % stride != 0) {
    // between two registers there is nothing: a read gives 0
  } else if (access.write) {
    const Word before = place->described.kind == DeviceKind::led ? device.read(offset, now) : 0;
    device.write(offset, access.value, now);
    note(*place, access, before);
  } else {
    value = device.read(offset, now);
  }
  device.advance_to(now);
  tell_pins(now);
  return Answer{value, place->described.waits};
}

void BoardDevices::note(const Place& place, const c40::ExternalAccess& access, Word before) {
  constexpr std::uint64_t most_changes = 1000;  // a program that blinks has no end
  if (place.described.kind == DeviceKind::led && before != access.value && ++change_count_ <= most_changes)
    changes_.push_back({place.described.name, access.cycle, access.value});
  if (place.described.kind != DeviceKind::console || access.address != place.described.base) return;
  console_ += static_cast<char>(access.value & 0xFF);
  if (on_output) on_output(console_.back());
}

void BoardDevices::advance_to(Cycles now) {
  for (Cycles event = next_event(); event <= now; event = next_event()) {
    for (Place& place : places_) {
      if (place.device->next_event() > event) continue;
      place.device->advance_to(event);
      if (const Cycles again = place.device->next_event(); again <= event)
        throw std::invalid_argument(fmt::format(
            "device {} at {:08X}h: what next_event() gives: {}, and advance_to({}) has been called; a later "
            "cycle, or None, is expected",
            place.described.name, place.described.base, again, event));
    }
    now_ = std::max(now_, event);
    tell_pins(now_);
  }
}

void BoardDevices::look(Cycles now) {
  advance_to(now);
  now_ = std::max(now_, now);
  tell_pins(now_);
}

void BoardDevices::settle(Cycles now) {
  advance_to(now);
  now_ = std::max(now_, now);
  for (Place& place : places_)
    if (place.described.kind != DeviceKind::own) place.device->advance_to(now);
}

Cycles BoardDevices::next_event() const {
  Cycles next = never_cycle;
  for (const Place& place : places_)
    if (place.described.pin || place.device->acts_on_others()) next = std::min(next, place.device->next_event());
  return next;
}

bool BoardDevices::continues() const {
  return std::ranges::any_of(places_, [](const Place& place) { return place.device->continues(); });
}

std::vector<Pin> BoardDevices::pins() const {
  std::vector<Pin> all;
  for (const Place& place : places_)
    if (place.described.pin && std::ranges::find(all, *place.described.pin) == all.end())
      all.push_back(*place.described.pin);
  return all;
}

void BoardDevices::tell_pins(Cycles cycle) {
  unsigned low = 0;
  for (const Place& place : places_)
    if (place.described.pin && place.device->interrupts()) low |= bit(*place.described.pin);
  const unsigned changed = std::exchange(low_, low) ^ low;
  for (const Pin pin : pins())
    if ((changed & bit(pin)) != 0 && on_pin) on_pin(pin, (low & bit(pin)) == 0, cycle);
}

const BoardDevices::Place* BoardDevices::console_at() const {
  const auto found =
      std::ranges::find_if(places_, [](const Place& p) { return p.described.kind == DeviceKind::console; });
  return found == places_.end() ? nullptr : &*found;
}

void BoardDevices::type(const std::vector<HostStep>& steps, Cycles now) {
  if (const Place* place = console_at()) place->device->host()->add(steps, now);
}

HostStep BoardDevices::type(std::string_view text, Cycles now) {
  HostStep step = characters(text).at(0);
  step.number = static_cast<std::uint64_t>(std::max(now, now_ + 1));
  type({step}, now);
  return step;
}

std::optional<std::string> BoardDevices::stateless() const {
  for (const Place& place : places_)
    if (const auto why = place.device->stateless())
      return fmt::format("the device {} at {:X}h {}", place.described.name, place.described.base, *why);
  return std::nullopt;
}

void BoardDevices::list_state(state::Visitor& list) {
  if (const auto why = stateless()) throw state::StateError(*why);
  for (Place& place : places_) list(place.described.name, *place.device);
  list("now", now_);
  list("low", low_);
  list("console", console_);
  list("changes", changes_);
  list("change_count", change_count_);
}

bool serve(BoardDevices& devices, c40::Chip& chip, const c40::ExternalAccess& access) {
  const auto answer = devices.access(access);
  if (!answer) return false;
  if (access.write)
    chip.complete_write(0, answer->waits);
  else
    chip.complete_read(answer->value, 0, answer->waits);
  return true;
}

// ---- around one chip ----

LoneDevices::LoneDevices(BoardDevices& devices, c40::Chip& chip) : devices_(devices), chip_(chip) {
  unsigned pulled = 0;
  for (const Pin pin : devices_.pins()) {
    chip_.set_pin(pin, true, chip_.cycle());
    pulled |= bit(pin);
  }
  chip_.watch_pins(nullptr, 0, pulled);
  devices_.on_pin = [this](Pin pin, bool level, Cycles cycle) {
    const Cycles due = cycle + 1;
    // It has changed and changed back between two looks.
    if (std::erase_if(pins_, [&](const PinChange& other) { return other.pin == pin && other.due == due; }) != 0) return;
    pins_.insert(std::ranges::upper_bound(pins_, due, {}, &PinChange::due), PinChange{pin, level, due});
  };
}

LoneDevices::~LoneDevices() {
  devices_.on_pin = nullptr;
  chip_.watch_pins(nullptr, 0, 0);
}

/// A running processor has begun its last instruction by then, as in a network (Network::Node::run_to).
bool LoneDevices::reached(Cycles due) const { return chip_.cycle() > due || (chip_.cycle() == due && chip_.idle()); }

/// The last cycle in which all accesses have been made, as far as the DMA is concerned, which may be behind the
/// processor. What a device does by itself there comes before the processor's access.
Cycles LoneDevices::present() const { return chip_.settled() - (chip_.dma_active() ? 1 : 0); }

/// So an event comes after the accesses of the cycles before, wherever the run has been cut.
void LoneDevices::catch_up() {
  devices_.advance_to(present());
  while (!pins_.empty() && reached(pins_.front().due)) {
    const PinChange change = pins_.front();
    pins_.pop_front();
    chip_.set_pin(change.pin, change.level, change.due);
  }
}

Cycles LoneDevices::limit(Cycles wanted) {
  catch_up();
  Cycles next = wanted;
  // A processor that has passed the effect of an event waits for the DMA, which has not come to the event.
  if (const Cycles event = devices_.next_event(); event != never_cycle) {
    const Cycles now = chip_.cycle();
    // An idle processor looks at the event itself, too: it may be the last that is awaited.
    const Cycles effect = chip_.idle() && now < event ? event : event + 1;
    next = std::min(next, reached(effect) ? now : std::max(effect, now + 1));
  }
  if (!pins_.empty()) next = std::min(next, std::max(pins_.front().due, chip_.cycle() + 1));
  return next;
}

void LoneDevices::run_ended() {
  catch_up();
  devices_.settle(present());
}

bool LoneDevices::serve(const c40::ExternalAccess& access) { return machine::serve(devices_, chip_, access); }

bool LoneDevices::could_wake(Pin pin) const {
  const bool can = chip_.idle() || (chip_.register_value(isa::Register::ST) & c40::st::GIE) != 0;
  return chip_.reacts_to(pin) && (pin == Pin::nmi || can);
}

bool LoneDevices::could_wake() {
  catch_up();  // else the run would end later where it has been cut less
  if (chip_.interrupt_pending()) return true;
  if (pins_.empty() && devices_.next_event() == never_cycle) return false;
  return std::ranges::any_of(devices_.pins(), [&](Pin pin) { return could_wake(pin); });
}

bool LoneDevices::typing_could_wake() const {
  const BoardDevices::Place* console = devices_.console_at();
  // A pin that is low already does not fall.
  return console != nullptr && console->described.pin && !console->device->interrupts() &&
         could_wake(*console->described.pin);
}

}  // namespace machine

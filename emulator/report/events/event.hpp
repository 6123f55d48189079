#pragma once
// The events of a run as plain values: hashed and traced (docs/trace.md). This file knows no chip and no bus.
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ratio>
#include <string>
#include <string_view>

namespace report {

/// Virtual time since the start of the run, in whole picoseconds.
using Time = std::chrono::duration<std::int64_t, std::pico>;

constexpr double seconds(Time time) { return static_cast<double>(time.count()) / 1e12; }
/// To the nearest picosecond.
inline Time from_seconds(double seconds) { return Time{std::llround(seconds * 1e12)}; }

/// The component of an event. Its number is also the order of events at the same picosecond (rulings 2, 3).
using Component = std::uint16_t;
inline constexpr Component host = 0;
inline constexpr Component bus_a = 1;
inline constexpr Component bus_b = 2;
inline constexpr Component bus_c = 3;
inline constexpr Component bus_d = 4;
inline constexpr Component first_dsp = 16;
inline constexpr Component plant = 0xFFFF;
constexpr Component dsp(unsigned slot) { return static_cast<Component>(first_dsp + slot); }

/// "host", "bus A", "bus B", "dsp 3", "plant", else "component 7".
std::string name(Component component);

/// The kinds of events. The comment names the five arguments in order (0 if there are fewer); `argument_names` has the
/// same names for the text trace. Numbers are part of the hash: append new kinds, never renumber.
enum class EventKind : std::uint16_t {
  refresh = 1,  ///< host: number, blocks in the list, waiting blocks, first waiting block, refreshes skipped before it
  load = 2,     ///< host: block offset, kind (KIND_*), area offset, tick, generation
  claim = 3,    ///< dsp: block offset, kind, area offset, tick, generation (the block is marked 0Fh)
  start = 4,    ///< dsp: block offset, kind; only if a start is observed apart from the claim
  finish = 5,   ///< dsp: block offset, kind, result, notify, generation (the block is marked FFh)
  remove = 6,   ///< host: block offset, kind, generation
  requeue = 7,  ///< host: block offset, kind, generation, old owner's slot, recomputations so far (watchdog)
  bus_transaction =
      8,  ///< bus: master, word address, words, 1 write | 2 interlocked | 4 prefetch, clocks from REQ# to FRAME#
  semaphore = 9,       ///< bus: number, 1 acquired | 0 released | 2 taken by the host from this owner, owner (master)
  latch = 10,          ///< plant: torque codes of joints 0 to 4, two's complement
  interrupt = 11,      ///< dsp: IIOF pin
  doorbell = 12,       ///< host: slot whose doorbell was rung
  idle = 13,           ///< dsp: 1 now idle (doorbell bit set) | 0 busy
  fault = 14,          ///< dsp: kind of fault, PC, word or address
  reset = 15,          ///< dsp: 1 booted | 0 held
  fence = 16,          ///< host: mask of slots that may write
  dropped_write = 17,  ///< dsp: bus, address, value (a fenced slot's write)
  process = 18,    ///< host: process 1 to 8, 1 started | 0 ended, robot (0 crane, n AGV n - 1; of process 4 its AGV)
  miss = 19,       ///< host: kind, tick, class (report::Outcome), block offset
  landed = 20,     ///< plant: container, place
  locked = 21,     ///< plant: container (twist locks closed)
  opened = 22,     ///< plant: container (twist locks open)
  delivered = 23,  ///< plant: container
  starved = 24,    ///< host: 0 (the crane), point: a PID block found the interpolation buffer empty
  scripted = 25,   ///< host: action (machine::Action), number of what it acts on, amount low and high word
  set = 27,   ///< host: number of the key in the schema, its new value (integer or bits of a double) low and high word
  push = 26,  ///< plant: AGV, speed, front, rear (a set-point enters the AGV's FIFO)
  link_lost = 29,  ///< dsp: word lost on the link, 1 to the DSP | 0 from it, bytes of it that had crossed
  error = 30,      ///< host: number, origin and object (ERROR_*), robot, 0 noticed | 1 decided | 2 done | 3 cleared,
                   ///< response (RESPOND_*)
  control =
      31,  ///< host: generation of the servo's parameters, what changed in it (bit j: channel j, bit 5: against sway)
  issue = 28,  ///< dsp: block offset, flag written, ps from the program's write to its arrival (low and high word)
};

/// One event. 32 bytes, hashed in this layout, little-endian: time, component, kind, arguments.
struct Event {
  Time time{};
  Component component = host;
  EventKind kind{};
  std::array<std::uint32_t, 5> arguments{};
};
static_assert(sizeof(Event) == 32);

/// "bus_transaction"; "event 99" for a number that has no name.
std::string name(EventKind kind);
/// Names of the arguments in order, empty past the last.
std::array<std::string_view, 5> argument_names(EventKind kind);
/// Whether the argument is a container or a place, of which there may be none.
bool may_be_none(EventKind kind, std::size_t argument);
inline constexpr std::uint32_t no_place = 0xFFFFFFFF;  ///< the plant's -1: no container, no place
/// One line of the text trace without its end (docs/trace.md): `0.000125000000 [host] refresh number=1 blocks=2 …`.
std::string to_text(const Event& event);

}  // namespace report

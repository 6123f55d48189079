#pragma once
// The host's software, as the machine sees it.
#include <cstddef>
#include <cstdint>
#include <span>

#include "machine/system/bus_topology.hpp"
#include "machine/time/time.hpp"

namespace machine {

/// The host's access to shared memory. Writes are posted in order (rising addresses form bursts); a read goes to the
/// bus after all writes before it. May be used only inside HostProgram's calls.
class HostPort {
 public:
  virtual ~HostPort() = default;
  /// Requests n_words (at least 1) from offset on. HostProgram::read_done with the same tag brings the answer. The
  /// words are single transactions, one after the other: a Pentium's reads of PCI memory do not burst (plant-and-bus.md
  /// 3.1). Throws std::logic_error while a read is outstanding.
  virtual void read(Offset offset, unsigned n_words, std::uint32_t tag) = 0;
  /// Throws std::logic_error while a read is outstanding: the processor waits for it. read and write throw
  /// std::out_of_range for an offset at which no device answers on bus A.
  virtual void write(Offset offset, std::span<const Word> words) = 0;
  void write(Offset offset, Word word) { write(offset, std::span<const Word>{&word, 1}); }
  /// A read is outstanding.
  virtual bool reading() const = 0;
  /// Number of words written here that have not reached their target yet.
  virtual std::size_t pending_writes() const = 0;
};

/// The host's software.
class HostProgram {
 public:
  virtual ~HostProgram() = default;
  /// When it has to be woken next (never: only by read_done). Called after each of the calls below; a time in the past
  /// means now.
  virtual Time next_wake() const = 0;
  virtual void wake(Time now, HostPort& port) = 0;
  /// A DSP has left reset and waits for its boot stream (LINK_REQUEST says which): an interrupt. This function may only
  /// record it.
  virtual void boot_requested(Time /*now*/) {}
  /// The words are valid only during the call.
  virtual void read_done(std::uint32_t tag, std::span<const Word> words, Time now, HostPort& port) = 0;
};

}  // namespace machine

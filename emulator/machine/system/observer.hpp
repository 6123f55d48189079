#pragma once
// What can be seen of a machine while it runs.
#include <cstdint>
#include <string>

#include "machine/system/bus_topology.hpp"
#include "machine/time/time.hpp"

namespace pci {
struct Transaction;
}

namespace machine {

struct ScriptedEvent;

inline constexpr unsigned host_owner = 0xFF;  ///< of a semaphore

/// Why a DSP stopped until its next reset: the message of the chip or its bus.
struct ChipFault {
  unsigned slot = 0;
  Time time{};
  std::int64_t cycle = 0;
  std::uint32_t pc = 0;
  std::uint32_t address = 0;  ///< the accessed address, or 0
  std::string message;        ///< names the DSP, the PC, the cycle and the cause
};

enum class SemaphoreEvent : std::uint8_t { acquired, refused, released };
/// booted: the program runs, and has reported over the link.
enum class SlotChange : std::uint8_t { plugged, unplugged, reset, booted };

/// Sees all events in their order, and changes nothing. Every function does nothing unless overridden.
class Observer {
 public:
  virtual ~Observer() = default;
  /// A DSP issues a write at `issued`; its program may be ahead of others. Per slot in order, before dsp_write reports
  /// the same write. The chip's counters are those of this instant.
  virtual void dsp_issue(unsigned /*slot*/, Window, Offset, Word, Time /*issued*/) {}
  /// Whether dsp_issue is to be called for writes to there.
  virtual bool wants_issues_at(Window, Offset) const { return false; }
  /// A DSP's write has reached its target at `now`; the program issued it at `issued`. Not called for fenced writes
  /// (see dsp_write_dropped).
  virtual void dsp_write(unsigned /*slot*/, Window, Offset, Word, Time /*issued*/, Time /*now*/) {}
  virtual void dsp_write_dropped(unsigned /*slot*/, Window, Offset, Word, Time /*issued*/, Time /*now*/) {}
  /// In addition to dsp_write_dropped: the guard has refused the write. kind: of the DSP's present task, FFFFFFFFh if
  /// none.
  virtual void dsp_write_refused(unsigned /*slot*/, Offset, Word, Word /*kind*/, Time /*now*/) {}
  /// A DSP's access through a window made it wait from `from` to `to`.
  virtual void dsp_waited(unsigned /*slot*/, Window, Time /*from*/, Time /*to*/) {}
  /// A transaction has ended. On every bus of the host, the host is master 0; then come the DSPs in the order of their
  /// slots, then the bridges between buses.
  virtual void transaction(BusId, const pci::Transaction&, Time /*now*/) {}
  /// Asked once, when the observer is set. If not, transaction() is not called.
  virtual bool wants_transactions() const { return true; }
  virtual void interrupt(unsigned /*slot*/, int /*iiof pin*/, Time /*now*/) {}
  /// owner: DSP slot + 1, or host_owner.
  virtual void semaphore(unsigned /*number*/, SemaphoreEvent, unsigned /*owner*/, Time /*now*/) {}
  virtual void fault(const ChipFault&) {}
  virtual void slot(unsigned /*slot*/, SlotChange, Time /*now*/) {}
  /// A word on the link between adapter and DSP is lost; `bytes` of its four bytes had crossed.
  virtual void link_lost(unsigned /*slot*/, bool /*to_dsp*/, Word, int /*bytes*/, Time /*now*/) {}
  virtual void scripted(const ScriptedEvent&, Time /*now*/) {}
};

}  // namespace machine

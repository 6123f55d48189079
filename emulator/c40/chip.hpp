#pragma once
/// One TMS320C40: its whole public face. The chip knows no system: it runs until a limit, or until it would touch
/// something that is not its own, and says so.
///
/// Inaccuracies: the analysis block is not modelled (touching it is a fault that names the register); annulled slots
/// update address registers but do not read memory; RCPF and RSQRF seeds are a model. docs/fidelity.md lists every
/// choice.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "c40/board.hpp"
#include "c40/peripherals/comm_port.hpp"
#include "c40/peripherals/dma_wait.hpp"
#include "c40/peripherals/pins.hpp"
#include "c40/pipeline_stages.hpp"
#include "c40/types.hpp"

namespace state {
class Visitor;
}

namespace c40 {

/// An access to an external window that the chip stopped before.
struct ExternalAccess {
  Address address = 0;
  bool write = false;
  bool interlocked = false;  ///< LDII, LDFI, STII, STFI, SIGI
  Word value = 0;            ///< of a write
  Cycles cycle = 0;          ///< when the access begins; one of the processor's never before the chip's cycle()
  int channel = -1;          ///< of the DMA; -1: the processor's
};

/// What an access to a window found at once.
struct WindowAnswer {
  Word value = 0;  ///< of a read
  Cycles arbitration = 0, transfer = 0;
};
/// Who stands behind the windows, and may answer an access without a stop of the chip.
class WindowListener {
 public:
  virtual ~WindowListener() = default;
  /// An access of the processor that can be completed now, whatever others do; nothing where it cannot: then the chip
  /// stops before it. The chip may not be changed here.
  virtual std::optional<WindowAnswer> answer_at_once(const ExternalAccess& access) = 0;
  /// Whether the answer needs the chip's counters: only then are they those of this instant.
  virtual bool needs_counters(const ExternalAccess& access) const = 0;
};

/// Why a chip cannot go on. It is halted until reset.
struct Fault {
  enum class Kind : std::uint8_t {
    reserved_instruction,
    reserved_address,
    not_modelled,
    illegal_sequence,
    software_interrupt  ///< SWI where no debugger is (machine/chip_stop.hpp); a chip itself stops there, and has no
                        ///< fault
  };
  Kind kind = Kind::not_modelled;
  std::string message;
  Address pc = 0;
  Cycles cycle = 0;
  Word word = 0;        ///< the instruction
  Address address = 0;  ///< the address concerned, if any
};

struct StopInfo {
  enum class Reason : std::uint8_t {
    limit,
    external_access,  ///< stopped before an access to a window: complete_read, complete_write
    breakpoint,
    fault,
    port_access,  ///< stopped before an access to a port that a link is attached to: complete_port
    port_wait,    ///< an access to a port with nothing attached waits for a FIFO: without help, for ever
    horizon,  ///< the program began to watch a linked port (watches_ports): run on with a limit that regards its link
    software_interrupt  ///< stopped before SWI, which is a debugger's: nothing of it was done, and it stops there again
  } reason = Reason::limit;
  ExternalAccess access{};
  PortAccess port{};
  std::optional<Fault> fault;
};

std::string_view name(StopInfo::Reason reason);
std::string_view name(Fault::Kind kind);

struct RegisterChange {
  isa::Register reg;
  std::uint64_t value;  ///< 40 bits for R0 to R11
};
struct MemoryEvent {
  Address address;
  Word value;
  bool write;
};
/// What one instruction did.
struct TraceRecord {
  Cycles cycle = 0;  ///< before it
  Address pc = 0;
  Word word = 0;
  Cycles cycles = 0;
  Causes causes{};
  PipelineStages stages;  ///< relative to `cycle`, without what it waited for a shared bus
  std::span<const RegisterChange> registers;
  std::span<const MemoryEvent> memory;
};
class TraceSink {
 public:
  virtual ~TraceSink() = default;
  virtual void instruction(const TraceRecord& record) = 0;
  /// An interrupt was taken: offset in the table, cycle before the entry.
  virtual void interrupt(Word vector, Cycles cycle) = 0;
};

class Engine;
class Memory;
class PeripheralSink;
class Probe;
struct ProbePlan;
struct Float40;
struct State;

class Chip {
 public:
  explicit Chip(Board board);
  ~Chip();
  Chip(Chip&&) noexcept;
  Chip& operator=(Chip&&) noexcept;

  /// Debugger access, without time. Throws std::out_of_range for a reserved address or a window.
  void write_block(Address address, std::span<const Word> words);
  Word peek(Address address) const;
  void poke(Address address, Word value);

  /// Registers to known values (all 0, interface control registers from the board), pipeline empty; memory, cycle and
  /// instruction counts are kept. Ends a fault.
  void reset();
  /// What the RESET pin does: as reset(), but the interface control registers take their reset values, and the PC comes
  /// from the reset vector (Board::pins). With the boot ROM on the board, its loader runs. Throws std::out_of_range if
  /// nothing is there.
  void boot();
  Address pc() const;
  void set_pc(Address pc);
  /// R0 to R11: 40 bits, exponent in 39..32. Others: 32 bits.
  std::uint64_t register_value(isa::Register r) const;
  void set_register(isa::Register r, std::uint64_t value);
  Float40 float_register(isa::Register r) const;
  Word expansion(isa::Expansion r) const;
  void set_expansion(isa::Expansion r, Word value);

  /// Runs whole instructions while cycle() < limit. Results do not depend on how a run is cut into calls.
  StopInfo run_until(Cycles limit) { return run_until(limit, limit); }
  /// \param known what its links do is known up to here: a DMA that uses a linked port, and a processor in IDLE, go no
  /// further. A processor that runs may: an interrupt by a port counts from the next instruction on. Beyond `limit`:
  /// the processor does no more, and the DMA goes on to there.
  StopInfo run_until(Cycles limit, Cycles known);
  /// One instruction (or interrupt entry). In IDLE, one idle cycle. Some ten thousand cycles if a DMA of the first
  /// priority does not let the processor to its bus.
  StopInfo step();
  /// The answer to a read: its value and what the chip waited for it beyond the region's own wait states.
  void complete_read(Word value, Cycles arbitration, Cycles transfer);
  void complete_write(Cycles arbitration, Cycles transfer);
  /// Who is asked first, as long as no DMA channel is active; null: nobody, and the chip stops before each access.
  void set_window_listener(WindowListener* listener);

  /// A link (or another model of the port's other side) is attached; null detaches. Throws std::invalid_argument if the
  /// port does not exist or is taken.
  void attach(int port, PortListener* link);
  /// The port's FIFOs, levels and counters. The link and whoever feeds a port by hand may change it, between runs.
  CommPort& port(int port);
  const CommPort& port(int port) const;
  /// The access that the chip stopped at takes place in cycle `at`, which is not before the access's own; the chip has
  /// waited since. Throws std::logic_error if none is waiting, or if the port is not ready for it.
  void complete_port(Cycles at);
  /// A DMA channel is started. While the processor waits for a port or a window, the DMA goes on: run_until with a
  /// limit that regards everybody else, which ends with the same access again. Accesses of the DMA to linked ports take
  /// place without a stop before them (the limit has seen to it), but end the run (Reason::horizon), because the link
  /// goes on differently now.
  bool dma_active() const;
  /// One could go on now: all others wait for events or FIFOs.
  bool dma_busy() const;
  /// What the others wait for.
  std::vector<DmaWait> dma_waits() const;
  /// Everything before this cycle is done, by the processor and by the DMA. The DMA may be behind cycle(); while the
  /// processor waits for an access, the DMA may be ahead of it.
  Cycles settled() const;
  /// Interrupts that linked ports could raise are enabled, or a started DMA channel uses one: the chip's horizon
  /// depends on its links.
  bool watches_ports() const;

  /// The outside drives a pin to a level from a cycle on, which is not before the last. At IIOF and NMI, going low is
  /// an edge; of RESET the chip knows nothing: who resets it calls reset() or boot(). Throws std::invalid_argument for
  /// RESET.
  void set_pin(Pin pin, bool level, Cycles at);
  /// The listener is told the levels to which the chip drives its pins; null: no listener. A chip that is held drives
  /// no pin.
  /// \param outputs the pins of interest, bit n is pin n
  /// \param inputs pins that others drive: a program that makes outputs of them is a fault
  void watch_pins(PinListener* listener, unsigned outputs, unsigned inputs);
  /// The level at pin TCLKn.
  bool timer_pin(int timer) const;
  /// A peripheral register's value, by the name that the register map gives it (peripherals/register_map.hpp); a FIFO's
  /// oldest word without taking it. Throws std::out_of_range for an unknown name, with the nearest, and for an empty
  /// FIFO.
  Word peripheral(std::string_view name) const;

  /// The level at pin IIOFn: a general-purpose output's, else the board's.
  bool iiof_pin(int pin) const;
  /// A short pulse on IIOFn at the present cycle: an edge, and no level.
  void raise_iiof(int pin);
  /// A short pulse on NMI.
  void raise_nmi();
  /// An edge or level at this pin could be an interrupt that is enabled, an event for the DMA, or a tick of a timer
  /// that runs.
  bool heeds(Pin pin) const;
  /// The next cycle in which a peripheral does something by itself that the processor, or who watches pins, could see;
  /// the greatest number if none will.
  Cycles next_event() const;
  /// The same of one timer: its next interrupt.
  Cycles next_timer_event(int timer) const;
  /// Whether LOCK (LLOCK, the local bus's) is low: an LDII or LDFI has taken it, and no STII or STFI given it back.
  bool locked(bool global_bus) const;
  /// In IDLE with no interrupt to take.
  bool idle() const;
  /// An interrupt is requested and enabled: the next instruction that may be interrupted is.
  bool interrupt_pending() const;
  /// Since when the processor idles, and when the DMA's last access was done: they do not depend on how a run is cut.
  Cycles idle_since() const;
  Cycles dma_done() const;
  /// The timer's next event goes to a DMA channel, and raises no interrupt (DIE, c40-hardware.md 3.8).
  bool timer_drives_dma(int timer) const;
  /// Idle, and no peripheral of its own will change that: only something from outside can.
  bool dormant() const;
  void hold(bool held);
  /// Time passes, and it executes nothing: what its timers do at its pins happens.
  void stand_until(Cycles cycle);
  /// The same of one that waits for an access: its own time stands still.
  void let_peripherals_reach(Cycles cycle);
  /// Held in reset, or stopped by a fault.
  bool halted() const;

  Cycles cycle() const;
  std::uint64_t instructions() const;
  const Causes& causes() const;

  void add_breakpoint(Address address);
  void remove_breakpoint(Address address);
  /// Null switches tracing off. Tracing changes nothing observable.
  void set_trace(TraceSink* sink);
  TraceSink* trace() const;
  /// Null: nobody listens.
  void set_peripheral_sink(PeripheralSink* sink);
  /// Who is told of chosen instructions and accesses; null: nobody. Changes nothing observable, and costs nothing
  /// elsewhere.
  void set_probe(Probe* probe, ProbePlan plan);
  /// One instruction at a time, no blocks: the oracle of the fast path.
  void set_exact(bool exact);

  /// All that lasts and that anything later depends on, memory included. Not breakpoints, listeners, links, sinks and
  /// which engine runs: they stay as they are. Only between runs, and for a chip of the same board.
  void list_state(state::Visitor& list);

  /// For those who look inside; they include c40/state.hpp, c40/memory.hpp.
  const State& state() const;
  const Memory& memory() const;

 private:
  std::unique_ptr<Engine> engine_;
};

}  // namespace c40

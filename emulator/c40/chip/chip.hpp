#pragma once
/// One TMS320C40 and its complete interface. The chip knows no system: it runs until a limit, or until it would access
/// something outside; then it stops and reports this.
///
/// Inaccuracies: the analysis block is not modelled (an access is a fault that names the register). Annulled slots
/// update address registers but do not read memory. RCPF and RSQRF seeds are a model. docs/fidelity.md lists every
/// choice.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "c40/chip/board.hpp"
#include "c40/peripherals/comm_port.hpp"
#include "c40/peripherals/dma_wait.hpp"
#include "c40/peripherals/pins.hpp"
#include "c40/pipeline/pipeline_stages.hpp"
#include "c40/values/types.hpp"

namespace isa {
enum class Register : std::uint8_t;
enum class Expansion : std::uint8_t;
enum class ProgramEnd : std::uint8_t;
}  // namespace isa
namespace state {
class Visitor;
}

namespace c40 {

/// An access to an external window; the chip stopped before it.
struct ExternalAccess {
  Address address = 0;
  bool write = false;
  bool interlocked = false;  ///< LDII, LDFI, STII, STFI, SIGI
  Word value = 0;            ///< the value of a write
  Cycles cycle = 0;  ///< when the access begins; an access of the processor never begins before the chip's cycle()
  int channel = -1;  ///< the DMA channel; -1: the processor
};

/// The immediate answer to an access to a window.
struct WindowAnswer {
  Word value = 0;  ///< of a read
  Cycles arbitration = 0, transfer = 0;
};
/// The device behind the windows, which may answer an access without a stop of the chip.
class WindowListener {
 public:
  virtual ~WindowListener() = default;
  /// Answers an access of the processor that can be completed now, whatever other devices do. False if this is not
  /// possible: the chip then stops before the access. The chip may not be changed here. During a write, its registers
  /// and counters are up to date only after Chip::catch_up().
  virtual bool answer_at_once(const ExternalAccess& access, WindowAnswer& answer) = 0;
};

/// Why a chip cannot continue. The chip is halted until reset.
struct Fault {
  enum class Kind : std::uint8_t {
    reserved_instruction,
    reserved_address,
    not_modelled,
    illegal_sequence,
    software_interrupt  ///< SWI without a debugger (machine/chips/chip_stop.hpp); the chip itself stops before SWI and
                        ///< has no fault
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
    external_access,  ///< stopped before an access to a window: answer with complete_read, complete_write
    breakpoint,
    fault,
    port_access,  ///< stopped before an access to a linked port: answer with complete_port
    port_wait,    ///< an access to a port without a link waits for a FIFO, forever unless someone else changes the FIFO
    horizon,  ///< the program began to watch a linked port (watches_ports): run on with a limit that takes the port's
              ///< link into account
    software_interrupt  ///< stopped before SWI, which is for a debugger: SWI is not executed, and the chip stops there
                        ///< again
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
/// The effects of one instruction.
struct TraceRecord {
  Cycles cycle = 0;  ///< before the instruction
  Address pc = 0;
  Word word = 0;
  Cycles cycles = 0;
  Causes causes{};
  PipelineStages stages;  ///< relative to `cycle`, without waits for a shared bus
  std::span<const RegisterChange> registers;
  std::span<const MemoryEvent> memory;
};
/// The entry into an interrupt.
struct InterruptRecord {
  Cycles cycle = 0;  ///< before the entry
  Word vector = 0;   ///< its offset in the table
  Causes causes{};   ///< of the entry's cycles
};
class TraceSink {
 public:
  virtual ~TraceSink() = default;
  virtual void instruction(const TraceRecord& record) = 0;
  virtual void interrupt(const InterruptRecord& record) = 0;
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

  /// Sets registers to known values (all 0, interface control registers from the board) and empties the pipeline.
  /// Memory, cycle and instruction counts are kept. Ends a fault.
  void reset();
  /// The effect of the RESET pin: as reset(), but the interface control registers get their reset values, and the PC
  /// comes from the reset vector (Board::pins). If the board has the boot ROM, its loader runs. Throws
  /// std::out_of_range if no memory is at the vector.
  void boot();
  Address pc() const;
  void set_pc(Address pc);
  /// R0 to R11: 40 bits, exponent in 39..32. The others: 32 bits.
  std::uint64_t register_value(isa::Register r) const;
  void set_register(isa::Register r, std::uint64_t value);
  Float40 float_register(isa::Register r) const;
  Word expansion(isa::Expansion r) const;
  void set_expansion(isa::Expansion r, Word value);

  /// Runs whole instructions while cycle() < limit. Results do not depend on how a run is divided into calls.
  /// \returns why the run ended; valid until the next run.
  const StopInfo& run_until(Cycles limit) { return run_until(limit, limit); }
  /// \param known the cycle up to which the chip's links are known. A DMA that uses a linked port, and a processor in
  /// IDLE, go no further. A running processor may: an interrupt by a port counts from the next instruction on. If
  /// `known` is beyond `limit`, the processor stops at `limit`, and the DMA continues to `known`.
  const StopInfo& run_until(Cycles limit, Cycles known);
  /// One instruction (or interrupt entry). In IDLE, one idle cycle. Up to some ten thousand cycles if a DMA with the
  /// higher priority keeps the processor from its bus.
  const StopInfo& step();
  /// The answer to a read: its value, and the cycles that the chip waited beyond the region's own wait states.
  void complete_read(Word value, Cycles arbitration, Cycles transfer);
  void complete_write(Cycles arbitration, Cycles transfer);
  /// The listener is called first for an access to a window, as long as no DMA channel is active. Null: no listener,
  /// and the chip stops before each access.
  void set_window_listener(WindowListener* listener);
  /// For the listener, during a write: brings registers and counters up to the access.
  void catch_up();

  /// Attaches a link (or another model of the port's other side); null detaches. Throws std::invalid_argument if the
  /// port does not exist or has a link already.
  void attach(int port, PortListener* link);
  /// The port's FIFOs, levels and counters. A link, or a caller that feeds a port by hand, may change them between
  /// runs.
  CommPort& port(int port);
  const CommPort& port(int port) const;
  /// The access at which the chip stopped takes place in cycle `at`, not before the access's own cycle; the chip has
  /// waited since. Throws std::logic_error if no access waits, or if the port is not ready for it.
  void complete_port(Cycles at);
  /// A DMA channel is started. While the processor waits for a port or a window, the DMA continues: call run_until with
  /// a limit that takes all other devices into account; the call ends with the same access again. DMA accesses to
  /// linked ports take place without a stop before them (the limit makes this correct), but they end the run
  /// (Reason::horizon), because they change what the link does next.
  bool dma_active() const;
  /// A DMA channel could continue now: it waits for no event or FIFO.
  bool dma_busy() const;
  /// A DMA block has had its last access, and its end, due in cycle `cycle` or before, is still to be done.
  bool dma_ends_by(Cycles cycle) const;
  /// What the other channels wait for.
  std::vector<DmaWait> dma_waits() const;
  /// Processor and DMA have done everything before this cycle. The DMA may be behind cycle(); while the processor waits
  /// for an access, the DMA may be ahead of it.
  Cycles settled() const;
  /// Interrupts that linked ports could raise are enabled, or a started DMA channel uses a linked port: how far the
  /// chip may run depends on its links.
  bool watches_ports() const;

  /// The outside drives a pin to a level from a cycle on, not before the cycle of the last call. For IIOF and NMI,
  /// going low is an edge. RESET is not a pin of this model: its driver calls reset() or boot(). Throws
  /// std::invalid_argument for RESET.
  void set_pin(Pin pin, bool level, Cycles at);
  /// The listener is called with the levels to which the chip drives its pins; null: no listener. A chip that is held
  /// in reset drives no pin.
  /// \param outputs the pins of interest, bit n is pin n
  /// \param inputs pins with other drivers: a program that makes them outputs causes a fault
  void watch_pins(PinListener* listener, unsigned outputs, unsigned inputs);
  /// The level at pin TCLKn.
  bool timer_pin(int timer) const;
  /// A peripheral register's value, by its name in the register map (peripherals/register_map.hpp); for a FIFO its
  /// oldest word, which stays there. Throws std::out_of_range for an unknown name (with the nearest one) and for an
  /// empty FIFO.
  Word peripheral(std::string_view name) const;

  /// The level at pin IIOFn: the level of a general-purpose output, else the board's.
  bool iiof_pin(int pin) const;
  /// A short pulse on IIOFn at the present cycle: an edge without a lasting level.
  void raise_iiof(int pin);
  /// A short pulse on NMI.
  void raise_nmi();
  /// The event of a timer, as if TSTAT went from 0 to 1 now.
  void raise_timer(int timer);
  /// An edge or level at this pin could be an enabled interrupt, an event for the DMA, or a tick of a running timer.
  bool reacts_to(Pin pin) const;
  /// The next cycle in which a peripheral changes by itself in a way that the processor, or a listener of pins, could
  /// see; the greatest number if there is none.
  Cycles next_event() const;
  /// The same for one timer: its next interrupt.
  Cycles next_timer_event(int timer) const;
  /// Whether LOCK (for the local bus: LLOCK) is low: an LDII or LDFI has set it, and no STII or STFI has released it
  /// since.
  bool locked(bool global_bus) const;
  /// In IDLE with no interrupt to take.
  bool idle() const;
  /// An interrupt is requested and enabled: the next interruptible instruction is interrupted.
  bool interrupt_pending() const;
  /// The cycle since which the processor idles, and the cycle of the DMA's last access. Both do not depend on how a run
  /// is divided.
  Cycles idle_since() const;
  Cycles dma_done() const;
  /// The timer's next event goes to a DMA channel, and raises no interrupt (DIE, c40-hardware.md 3.8).
  bool timer_drives_dma(int timer) const;
  /// Idle, and no peripheral of the chip will end this: only an event from outside can.
  bool dormant() const;
  void hold(bool held);
  /// Time passes without execution; timers still change their pins.
  void stand_until(Cycles cycle, Cause cause = Cause::halted);
  /// The same for a chip that waits for an access: the chip's own time does not advance.
  void let_peripherals_reach(Cycles cycle);
  /// Held in reset, or stopped by a fault.
  bool halted() const;

  Cycles cycle() const;
  std::uint64_t instructions() const;
  const Causes& causes() const;

  void add_breakpoint(Address address);
  void remove_breakpoint(Address address);
  /// Breakpoints at all ends of a program: IDLE, IDLE2, and an unconditional branch to itself, wherever it is executed.
  void stop_at_ends(bool stops);
  /// The kind of end that the next instruction is.
  isa::ProgramEnd program_end() const;
  /// Null switches tracing off. Tracing changes nothing observable.
  void set_trace(TraceSink* sink);
  TraceSink* trace() const;
  /// Null: no sink.
  void set_peripheral_sink(PeripheralSink* sink);
  /// The probe gets chosen instructions and accesses; null: no probe. Changes nothing observable, and costs nothing for
  /// other instructions.
  void set_probe(Probe* probe, ProbePlan plan);
  /// Executes one instruction at a time, without blocks: the oracle of the fast path.
  void set_exact(bool exact);

  /// Everything that lasts and affects later results, memory included. Breakpoints, listeners, links, sinks and the
  /// choice of the engine are not part of it and stay as they are. Only between runs, and for a chip of the same board.
  void list_state(state::Visitor& list);

  /// For inspection; callers include c40/chip/state.hpp, c40/memory/memory.hpp.
  const State& state() const;
  const Memory& memory() const;

 private:
  std::unique_ptr<Engine> engine_;
};

}  // namespace c40

#pragma once
/// Runs a chip, in two ways with the same result. The exact engine executes one instruction at a time and asks the
/// pipeline model about each. A block is a recording of what the exact engine did: the same handlers in a row, with the
/// cycles and causes that the same model gave. If a guard of a block does not hold, the exact engine takes over.
///
/// The engine has the state and the loop that orders its parts. Whatever lasts beyond one step belongs to a part. The
/// parts do not know the engine.
#include <set>
#include <vector>

#include "c40/chip/chip.hpp"
#include "c40/chip/interrupts.hpp"
#include "c40/chip/state.hpp"
#include "c40/engine/block_store.hpp"
#include "c40/engine/decoded_slots.hpp"
#include "c40/engine/pending_access.hpp"
#include "c40/instructions/bind.hpp"
#include "c40/memory/instruction_cache.hpp"
#include "c40/observers/probe.hpp"
#include "c40/peripherals/dma_side.hpp"
#include "c40/peripherals/peripherals.hpp"
#include "c40/peripherals/ports.hpp"
#include "c40/pipeline/pipeline_table.hpp"
#include "isa/program_end.hpp"

namespace c40 {

/// The last interval in IDLE, however the run was divided.
class IdleSpan {
 public:
  void idled(Cycles from, Cycles until) {
    if (until_ != from) since_ = from;
    until_ = until;
  }
  /// Since when the processor idles, if it idles in cycle `now`; else `now`.
  Cycles since(Cycles now) const { return until_ == now ? since_ : now; }
  void set(Cycles since, Cycles now) { since_ = since, until_ = now; }

 private:
  Cycles since_ = 0, until_ = -1;
};

class Engine {
 public:
  explicit Engine(Board board);
  Engine(const Engine&) = delete;  // the parts refer to each other
  Engine& operator=(const Engine&) = delete;

  void reset();
  void boot();
  const StopInfo& run_until(Cycles limit, Cycles known);
  const StopInfo& step();
  void complete(bool write, Word value, Cycles arbitration, Cycles transfer);
  void watch_pins(PinListener* listener, unsigned outputs, unsigned inputs);
  void hold(bool held);
  void stand_until(Cycles cycle, Cause cause);
  bool waits_in_idle() const { return state_.core.idle && may_interrupt() && interrupts::pending(state_) == 0; }
  void settle_counts();
  /// While a window's listener is asked: brings the state up to the access.
  void catch_up();
  /// After this call the state may be changed from outside.
  State& touch();
  /// Always up to date, except causes, instructions, pipeline and cache; for these call settle_counts() first.
  const State& state() const { return state_; }
  Memory& memory() { return memory_; }
  const Memory& memory() const { return memory_; }
  Word peek(Address address) const;
  void poke(Address address, Word value);
  void flush_blocks();
  void set_probe(Probe* probe, ProbePlan plan);
  void list_state(state::Visitor& list);
  /// A write by the program: CE, CF and CC act on later fetches only.
  void write_status(Word value);
  void set_status(Word value);
  void complete_port(Cycles at);
  /// Bit n: linked port n could raise an interrupt, or move the DMA.
  Word watched_ports() const {
    if ((state_.core.r[reg::IIE] & interrupts::port_sources) == 0 && !peripherals_.dma_active()) return 0;
    return watched_ports_now();
  }
  Ports& ports() { return ports_; }
  Pins& pins() { return pins_; }
  Peripherals& peripherals() { return peripherals_; }
  const Dma& dma() const { return dma_; }
  /// The access for which the processor waits.
  PendingAccess& access() { return access_; }
  Cycles idle_since() const { return idle_.since(state_.cycle); }

  TraceSink* trace = nullptr;
  WindowListener* window_listener = nullptr;
  PeripheralNotifier tell;  ///< reports what the peripherals do
  bool exact_only = false;
  std::set<Address> breakpoints;
  bool stops_at_ends = false;  ///< a breakpoint is also wherever program_end() is one
  /// Of the instruction at PC.
  isa::ProgramEnd program_end() const;

 private:
  enum class Stepped : std::uint8_t { done, external, fault, breakpoint, port, horizon, software_interrupt };

  /// Blocks end before this instruction.
  bool ends_blocks(Address pc) const { return breakpoints.contains(pc) || probe_.at(pc); }
  bool at_end() const { return stops_at_ends && program_end() != isa::ProgramEnd::none; }

  // engine.cpp: knowledge about the chip's state, and dropping it
  void forget_memory();
  void forget_pipelines();
  void process_code_writes();
  void settle_cache_control();

  // engine_run.cpp: the chip's next action, and why it stops
  Word watched_ports_now() const;
  /// A linked port of which the caller does not know could now raise an interrupt, or move the DMA.
  bool watches_another_port() const { return ports_.attached() != 0 && (watched_ports() & ~watched_) != 0; }
  Stepped advance(Cycles limit, bool single);
  Stepped act(Cycles limit, bool single, bool dma_busy);
  const StopInfo& stop(Stepped why);
  /// The stop is before an access. The DMA may pass an access that has been reported, and no other.
  static bool reports_access(Stepped why) { return why == Stepped::external || why == Stepped::port; }
  StopInfo& stopped(StopInfo::Reason reason) {
    stop_.reason = reason;
    stop_.fault.reset();
    return stop_;
  }
  void pass(Cause cause, Cycles until);
  void stand_still(Cycles cycles);
  /// Executes everything up to the present cycle: timer events, and changes of the cache's control.
  void reach_present() {
    if (state_.cycle >= peripherals_.next_event()) [[unlikely]]
      reach_events();
    if (cache_.control_pending()) [[unlikely]]
      settle_cache_control();
  }
  void reach_events();
  void make_dma_current(bool waited);
  /// An instruction whose access has begun, or is answered, is finished first.
  bool may_interrupt() const {
    return state_.core.delay_slots == 0 && state_.core.repeat_single == 0 && !access_.is_answered() && !access_.any();
  }
  bool take_interrupt(Word vector);

  // engine_step.cpp: the exact engine
  Stepped exact_step(Step& step, bool fresh);
  Stepped run_exactly(Cycles limit);
  template <class Continues>
  bool quick_step(const Continues& continues);
  bool meet_transition(DecodedSlot& decoded, Exit exit);
  Stepped traced_step(Step& step);
  Stepped probed_step(Step& step, bool fresh);
  Stepped untraced_step(Step& step, bool fresh);
  bool find_code(Address pc);
  bool caching() const;
  bool by_blocks();
  bool fetch(Step& step);
  bool bind_slot(DecodedSlot& decoded, Word word, bool set_condition);
  Stepped execute(Step& step);
  void annulled(const Step& step);
  bool illegal_in_repeat(Address pc, const BoundInstruction& bound) const;
  Demand demand_through(const Step& step, bool annulled) const;
  const Transition& transition(const Demand& demand, Word word);
  const Transition& annulled_transition(const Step& step);
  const Transition& executed_transition(const Step& step);
  void account(const StepTiming& timing);
  void account(const Transition& transition);
  void account(const Transition& transition, const std::optional<StepTiming>& without_dma);
  void settle_accesses(const Step& step, Address pc);
  void finish_step(const Step& step);
  void advance_pc(Address pc, Flow flow);
  void emit_trace(const Step& step, const Core& before, Cycles cycle, const Causes& causes);

  // engine_access.cpp: accesses whose region is not known yet, and faults
  Stepped resolve(Step& step);
  const Memory::Area* find_area(Step& step, std::size_t k);
  void access_memory(Step& step, std::size_t k, const Memory::Area& area);
  Stepped access_outside(Step& step, std::size_t k, const Memory::Area& area);
  Stepped access_register(Step& step, std::size_t k, Word& cell);
  Stepped access_window(const Step& step, std::size_t k, Word& cell);
  bool is_linked(Address address) const;
  Stepped access_port(const Step& step, std::size_t k, Word& cell);
  Cycles access_start(const Step& step, std::size_t access, PipelineId before);
  Cycles access_cycle(const Step& step, std::size_t access);
  /// Whether there is an answer (opened_.answer) without a stop of the chip.
  bool answers_at_once(const ExternalAccess& access) {
    if (window_listener == nullptr || peripherals_.dma_active() || state_.dma.answered_until > access.cycle)
      return false;
    opened_.answer = {}, opened_.comm_port = 0;
    return window_listener->answer_at_once(access, opened_.answer);
  }
  /// \param comm_port how long the access waited for a port
  void settle_answer(const WindowAnswer& answer, Cycles comm_port) {
    add(state_.causes, Cause::bus_arbitration, answer.arbitration);
    add(state_.causes, Cause::bus_transfer, answer.transfer);
    add(state_.causes, Cause::comm_port, comm_port);
    state_.cycle += answer.arbitration + answer.transfer + comm_port;
  }
  void settle_answers();
  Stepped fail(Fault::Kind kind, std::string message, Address address = 0);
  Stepped nothing_at(std::string_view access, Address address);

  // engine_dma.cpp: the DMA coprocessor beside the processor
  Cycles known_until(Cycles limit, bool idles) const;
  Cycles known_before_access(Cycles limit) const;
  bool uses_linked_port() const;
  std::optional<StopInfo> run_dma(Cycles limit, bool processor_waits);
  StopInfo dma_stop(const DmaRequest& request);
  void complete_dma(bool write, Word value, Cycles waited);

  // engine_record.cpp: recording blocks
  CodeBlockKey plain_key();
  CodeBlockKey key();
  CodeBlock* find_or_record(Cycles limit, Stepped& why);
  CodeBlock* find_or_record_other(CodeBlock& left, Cycles limit, Stepped& why);
  CodeBlock* other_block(const CodeBlock& left);
  void record(const CodeBlockKey& key, Cycles limit, Stepped& why);
  bool recordable(const BoundInstruction& bound) const;

  // engine_blocks.cpp: running blocks
  /// The beginning of a part of a block: its time is added up to `from` (exclusive), everything else up to `seen`
  /// (exclusive).
  struct InBlock {
    std::size_t from = 0, seen = 0;
  };
  struct Passed {
    CodeBlock* block = nullptr;
    InBlock in{};
    std::size_t at = 0;
  };
  Stepped run_blocks(CodeBlock* block, std::size_t at, Cycles limit);
  CodeBlock* continues_beside(Cycles limit);
  CodeBlock::Exit* pass_windows(CodeBlock& block, InBlock in, Outcome outcome, Cycles limit);
  const WindowAccess* open_window(const CodeBlock& block, std::size_t at) const;
  bool opens_answer(const CodeBlock& block, std::size_t at);
  bool reach_window(CodeBlock& block, InBlock& in, const Outcome& outcome);
  bool reach_port(CodeBlock& block, InBlock& in, std::size_t at, const WindowAccess& window);
  /// Why a block was left: an access, or nothing.
  Stepped before_access() const {
    return access_.at_window() ? Stepped::external : access_.at_port() ? Stepped::port : Stepped::done;
  }
  Outcome pass_window(CodeBlock& block, std::size_t at, Cycles limit);
  void leave(CodeBlock& block, InBlock in, std::size_t at);
  void left_block(CodeBlock& block, InBlock in, const Outcome& outcome);
  void rejoin(CodeBlock& block);
  Outcome run_ops(CodeBlock& block, std::size_t from, Cycles budget);
  Outcome run_some_ops(CodeBlock& block, std::size_t from, Cycles budget);
  CodeBlock::Exit* run_special(CodeBlock& block, InBlock in, Cycles limit, Outcome& outcome);
  CodeBlock::Exit* run_repeated(CodeBlock& block, Cycles limit, Outcome& outcome);
  CodeBlock::Exit& end_part(CodeBlock& block, InBlock in, const Outcome& outcome);
  CodeBlock::Exit& end_repeat(CodeBlock& block, std::uint32_t passes);
  std::uint32_t passes_within(const CodeBlock& block, Cycles limit) const;

  State state_;
  PipelineTable pipelines_;
  PipelineNow pipeline_{pipelines_, state_.pipeline};  ///< settle() brings state_.pipeline up to date
  Board board_;
  Memory memory_;
  Ports ports_{state_.ports, tell};
  Pins pins_{state_, board_.pins};
  Peripherals peripherals_{state_, dma_, pins_, tell};
  PendingAccess access_{state_};
  std::optional<Fault> fault_;
  ProbePoint probe_;
  std::optional<Cycles> reported_breakpoint_;  ///< cycle of the last breakpoint stop
  std::vector<MemoryEvent> events_;
  struct Scratch {
    std::array<Word, 2> cell{};
  };
  /// The present instruction's access through a window or to a port that is answered.
  struct Opened {
    const WindowAccess* window = nullptr;  ///< in a block
    Address address = 0;                   ///< in a block
    bool write = false;                    ///< in a block
    WindowAnswer answer;
    Cycles comm_port = 0;
    Answer given(bool writes, Address at) const {
      return {true, writes, at, answer.value, answer.arbitration, answer.transfer, comm_port};
    }
  } opened_;
  Passed passed_;                     ///< while a window's listener is asked: what the state does not have yet
  std::array<Scratch, 2> scratch_{};  ///< used instead of a register or a window during one instruction
  Memory::OpenPages pages_;           ///< of the present step
  DecodedSlotTable decoded_slots_;
  CodeArea code_;
  InstructionCache cache_{state_};
  BlockStore blocks_;
  ExactAddresses exact_addresses_;
  Continuation onward_;
  Dma dma_;
  DmaSide dma_side_;
  DmaEffect dma_effect_ = DmaEffect::none;  ///< on the instruction in execution
  IdleSpan idle_;
  StopInfo stop_;         ///< of the last run
  Cycles run_limit_ = 0;  ///< of the present call: the links are known up to this cycle
  Word watched_ = 0;      ///< of the present call: watched_ports() as the caller knew it
};

}  // namespace c40

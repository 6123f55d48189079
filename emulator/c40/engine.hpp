#pragma once
/// What runs a chip. Two ways to the same result: the exact engine executes one instruction at a time and asks the pipeline model
/// about each; blocks are what the exact engine once did, recorded: the same handlers in a row, and the cycles and causes that the
/// same model gave. A block is left for the exact engine wherever its guards do not hold.
#include <deque>
#include <unordered_map>
#include <vector>

#include "c40/bind.hpp"
#include "c40/chip.hpp"

namespace c40 {

using PipelineId = std::uint32_t;
using Costs = std::array<std::uint16_t, cause_count>;

/// Everything that the recorded timing and the chosen handlers depend on.
struct BlockKey {
  Address pc = 0;
  Address repeat_end = 0;  ///< RE while RM is set
  PipelineId pipeline = 0;
  std::uint32_t mode = 0;  ///< bit 0 SET COND, bit 1 RM, bits 2, 3 the state of RPTS
  friend bool operator==(const BlockKey&, const BlockKey&) = default;
};
struct BlockKeyHash {
  std::size_t operator()(const BlockKey& key) const {
    std::uint64_t h = (std::uint64_t{key.pc} << 32 | key.repeat_end) * 0x9E3779B97F4A7C15u;
    h ^= (h >> 29) ^ (std::uint64_t{key.pipeline} << 4 | key.mode) * 0xBF58476D1CE4E5B9u;
    return static_cast<std::size_t>(h ^ h >> 32);
  }
};

struct Block {
  struct Exit {
    Cycles cycles = 0;
    PipelineId pipeline = 0;
    bool chained = false;  ///< `next` may be kept: nothing but the pc decides which block follows.
    Costs causes{};
    std::uint64_t count = 0;  ///< runs of the whole block not yet in the chip's causes and instructions
    Block* next = nullptr;
  };
  BlockKey key;
  std::vector<Op> ops;  ///< one per instruction, then the terminal if the last instruction is not one itself
  std::size_t size = 0;
  // Before instruction i; the last entry is after all, straight on.
  std::vector<Cycles> start;
  std::vector<Costs> causes;
  std::vector<PipelineId> pipelines;
  std::vector<std::uint8_t> delay_slots;
  std::array<Exit, 2> exits{};
  Cycles last_start = 0;
  bool repeats = false;    ///< ends at RE: the loop hardware decides
  bool self_loop = false;  ///< following itself, it is in the same state again
  bool only_nop = false;
};

class Engine {
 public:
  explicit Engine(Board board);

  void reset();
  StopInfo run_until(Cycles limit);
  StopInfo step();
  void complete(bool write, Word value, Cycles arbitration, Cycles transfer);
  void raise_flag(Word flag);
  void set_level(int pin, bool active);
  bool waits_in_idle() const { return state_.core.idle && pending_vector() == 0; }
  void settle_counts();
  /// The state may be changed from outside after this.
  State& touch();
  const State& state() const { return state_; }
  Memory& memory() { return memory_; }
  const Memory& memory() const { return memory_; }
  Word peek(Address address) const;
  void poke(Address address, Word value);
  void flush_blocks();
  void write_status(Word value);
  void after_interrupt_register_write();
  void complete_port(Cycles at);
  /// The access that the chip stopped at will not be asked for any more.
  void forget_access();
  /// Bit n: linked port n could raise an interrupt.
  Word watched_ports() const;
  CommPort& port(int n) { return state_.ports[static_cast<std::size_t>(n)]; }
  Cycles next_peripheral_event() const { return next_peripheral_event_; }
  void set_timer_pin(int timer, bool level);
  void attach(int n, PortListener* link);
  PortListener* listener(int n) const { return listeners_[static_cast<std::size_t>(n)]; }

  TraceSink* trace = nullptr;
  bool exact_only = false;
  std::set<Address> breakpoints;

 private:
  enum class Stepped : std::uint8_t { done, external, fault, breakpoint, port, horizon };
  /// What the exact engine found out about one instruction.
  struct StepRecord {
    Bound bound;
    Demand demand;
    std::array<Window, 2> windows{};
    std::array<Address, 2> address{};  ///< of each data access
    std::array<bool, 2> register_write{};
    std::array<Cycles, 2> register_cycle{};  ///< when the access to a register takes place
    bool only_ram = true;
    bool taken = false;
    StepTiming timing;
  };

  /// What the pipeline model makes of an instruction in a state of the pipeline: it depends on nothing else.
  struct Transition {
    std::uint64_t demand = ~std::uint64_t{0};  ///< packed, but for the footprint, which is the word's
    PipelineId before = 0;
    isa::Word word = 0;
    StepTiming timing;
    PipelineId after = 0;
  };
  /// An instruction that no block can begin with: the exact engine does it each time.
  struct ExactSite {
    Address pc = 0;
    bool known = false;
    bool external = false;  ///< only as long as it leaves the chip
  };

  // engine.cpp: the exact engine
  Stepped exact_step(StepRecord& record);
  const Bound* fetch(StepRecord& record);
  Stepped execute(StepRecord& record);
  Stepped resolve(StepRecord& record, Op& op);
  Cycles access_cycle(const StepRecord& record, int access);
  const Transition& transition(const Demand& demand, isa::Word word);
  void annulled(const StepRecord& record);
  void account(const StepRecord& record);
  void finish_step(const StepRecord& record);
  void advance_pc(Address pc);
  Stepped fail(Fault::Kind kind, std::string message, Address address = 0);
  bool read_register(Address address, Cycles at, Word& value) const;
  bool write_register(Address address, Word value, Cycles at);
  void advance_peripherals(Cycles at);
  void expect_peripherals();
  void reset_ports();
  Stepped access_port(const StepRecord& record, std::size_t k, Word& cell);
  Word pending_port_vector(Word enabled) const;
  Word pending_vector() const;
  bool take_interrupt(Word vector);
  void pass(Cause cause, Cycles until);
  void emit_trace(const StepRecord& record, const Core& before, Cycles cycle, const Causes& causes);
  StopInfo stop(Stepped why);
  bool may_interrupt() const;
  std::optional<StopInfo> advance(Cycles limit, bool single);

  // engine_blocks.cpp: recording and running blocks
  BlockKey key();
  PipelineId intern(const Pipeline& pipeline);
  PipelineId current_pipeline();
  Block* find_or_record(Cycles limit, Stepped& why);
  void record(const BlockKey& key, Cycles limit, Stepped& why);
  bool recordable(const Bound& bound) const;
  ExactSite& site(Address pc) { return exact_sites_[pc % exact_sites_.size()]; }
  bool exact_site(Address pc) { return site(pc).known && site(pc).pc == pc; }
  void close_straight(Block& block, Cycles cycles, const Costs& costs, const Pipeline& end, bool chained);
  void close_with_branch(Block& block, const StepRecord& step, const Pipeline& before, bool chained);
  void run_blocks(Block* block, std::size_t from, Cycles limit);
  void leave(Block& block, std::size_t from, std::size_t at);
  void left_block(Block& block, std::size_t from, const Outcome& outcome);
  void rejoin(Block& block);
  Block::Exit* run_repeated(Block& block, Cycles limit);
  Block::Exit* run_part(Block& block, std::size_t from, Cycles limit);
  Block::Exit& end_repeat(Block& block, std::uint32_t passes);
  std::uint32_t passes_within(const Block& block, Cycles limit) const;
  void process_code_writes();

  State state_;
  Board board_;
  Memory memory_;
  ExternalAccess waiting_{};
  Cycles next_peripheral_event_ = 0;  ///< before it, no peripheral does anything by itself that the processor could see
  PortAccess port_access_{};
  std::size_t port_slot_ = 2;  ///< which of the instruction's accesses waits for a port; 2: none
  std::array<PortListener*, port_count> listeners_{};
  Word attached_ = 0;  ///< bit n: port n has a listener
  std::size_t waiting_access_ = 2;  ///< which of the instruction's accesses waits; 2: none
  std::optional<Fault> fault_;
  std::optional<Cycles> reported_breakpoint_;  ///< cycle of the last breakpoint stop
  std::vector<MemoryEvent> events_;
  struct Scratch {
    std::array<Word, 2> cell{};
  };
  std::array<Scratch, 2> scratch_{};  ///< stands for a register or a window during one instruction
  struct CachedBound {
    Word word = 0;
    bool valid = false;
    bool set_condition = false;
    Bound bound;
  };
  std::vector<CachedBound> bounds_;
  std::vector<Transition> transitions_;  ///< direct mapped
  std::array<ExactSite, 1024> exact_sites_{};
  const Memory::Area* code_area_ = nullptr;

  std::vector<std::unique_ptr<Block>> blocks_;
  std::unordered_map<BlockKey, Block*, BlockKeyHash> by_key_;
  std::deque<Pipeline> pipelines_;
  std::unordered_map<std::uint64_t, std::vector<PipelineId>> pipeline_ids_;
  Block* resume_ = nullptr;  ///< the block that the last run was cut in, and where
  std::size_t resume_at_ = 0;
  Block* missed_ = nullptr;              ///< the block whose instruction at PC the exact engine must do
  Block::Exit* last_exit_ = nullptr;     ///< the exit that led to PC with nothing in between
  std::optional<PipelineId> known_pipeline_;  ///< of state_.pipeline
};

}  // namespace c40

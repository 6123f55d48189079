#pragma once
/// What the debugger hears while the machine runs: hits of triggers, each with its instant. Chips run ahead of one
/// another, so the hits do not come in the order of time.
#include <map>
#include <memory>
#include <vector>

#include "c40/self_check.hpp"
#include "machine/debug/debugger.hpp"
#include "machine/debug/expression.hpp"

namespace machine::debug {

class Debugger::HitRecorder final : private DebugEventListener, private SharedListener {
 public:
  HitRecorder(Debuggee& debuggee, const std::vector<ProgramView>& programs);
  ~HitRecorder() override;

  /// What to hear of from now on.
  /// \param each the chip of which every instruction counts, if any
  void arm(const std::map<unsigned, Trigger>& triggers, std::optional<std::size_t> each);
  /// The same, and goes on listening with the hits that it has.
  void rearm(const std::map<unsigned, Trigger>& triggers, std::optional<std::size_t> each);
  /// Hits later than `after` are kept from now on; those kept before are gone.
  void listen(Time after);
  void close() { open_ = false; }
  bool hears_late() const { return hears_late_; }
  bool looks_at_values() const;
  /// Hits of values at this instant.
  void look_at_values(Time now);

  std::vector<Hit> hits;  ///< in the order in which they were heard
  /// Of the chip of which every instruction counts.
  struct Instruction {
    Time begins{}, ends{};
    Address pc = 0, sp = 0;  ///< SP after it
    c40::Causes causes{};
  };
  std::vector<Instruction> instructions;
  bool keeps_instructions = false;
  /// The end of the first instruction heard.
  std::optional<Time> stepped;

  /// Whether a condition holds where the machine stands. \throws DebugError
  bool holds(const Hit& hit);

 private:
  class ChipEar;
  void happened(const DebugEvent& happening) override;
  void shared_access(const SharedAccess& access) override;
  void reached(std::size_t chip, Address pc, Time time);
  void accessed(std::size_t chip, const c40::ProbedAccess& access, Time time);
  void executed(std::size_t chip, const c40::TraceRecord& record);
  void broke_rule(std::size_t chip, const c40::Diagnostic& breach, c40::Cycles cycle);
  void add(unsigned number, const Trigger& trigger, Hit hit);
  Expression& condition_of(unsigned number, const Trigger& trigger, std::size_t chip);
  std::string place(std::size_t chip, Address pc) const;
  bool shared(const Trigger& trigger) const;

  Debuggee& debuggee_;
  const std::vector<ProgramView>& programs_;
  std::vector<std::unique_ptr<ChipEar>> chips_;
  std::map<unsigned, Trigger> armed_;
  std::map<std::pair<unsigned, std::size_t>, Expression> conditions_;
  std::map<unsigned, Expression> values_;
  std::map<unsigned, bool> were_;
  std::optional<std::size_t> each_;
  bool open_ = false, hears_late_ = false;
  Time after_{};
};

}  // namespace machine::debug

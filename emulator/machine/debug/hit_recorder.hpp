#pragma once
/// Records hits of triggers while the machine runs, each with its instant. Chips run ahead of one another, so hits are
/// not recorded in the order of time.
#include <map>
#include <memory>
#include <vector>

#include "c40/observers/self_check.hpp"
#include "machine/debug/debugger.hpp"
#include "machine/debug/expression.hpp"

namespace machine::debug {

class Debugger::HitRecorder final : private DebugEventListener, private SharedListener {
 public:
  HitRecorder(Debuggee& debuggee, const std::vector<ProgramView>& programs);
  ~HitRecorder() override;

  /// The triggers to record from now on.
  /// \param each the chip whose every instruction counts, if any
  void arm(const std::map<unsigned, Trigger>& triggers, std::optional<std::size_t> each);
  /// The same, but the recorded hits are kept.
  void rearm(const std::map<unsigned, Trigger>& triggers, std::optional<std::size_t> each);
  /// Records hits later than `after` from now on; earlier records are removed.
  void listen(Time after);
  void close() { open_ = false; }
  bool learns_late() const { return learns_late_; }
  bool looks_at_values() const;
  /// Records hits of values at this instant.
  void look_at_values(Time now);

  std::vector<Hit> hits;  ///< in the order of recording
  /// What the chip whose every instruction counts has done; SP is that after it.
  std::vector<Instruction> instructions;
  bool keeps_instructions = false;
  /// The end of the first recorded instruction, or of an interrupt's entry.
  std::optional<Time> stepped;
  bool hears_calls = true;  ///< an SWI is a hit

  /// Whether a condition holds at the machine's instant. \throws DebugError
  bool holds(const Hit& hit);

 private:
  class ChipEar;
  void happened(const DebugEvent& event) override;
  void shared_access(const SharedAccess& access) override;
  void reached(std::size_t chip, Address pc, Time time);
  void accessed(std::size_t chip, const c40::ProbedAccess& access, Time time);
  void executed(std::size_t chip, const c40::TraceRecord& record);
  void interrupted(std::size_t chip, Time begins, Time ends);
  void came_to_swi(std::size_t chip, Address pc, Time time);
  bool step_may_end(std::size_t chip, Time ends);
  void broke_rule(std::size_t chip, const c40::Diagnostic& breach, c40::Cycles cycle);
  void add(unsigned number, const Trigger& trigger, Hit hit);
  bool is_true(const Expression& expression, unsigned number, std::string_view word) const;
  Expression& condition_of(unsigned number, const Trigger& trigger, std::size_t chip);
  std::string place(std::size_t chip, Address pc) const;
  Address stack_of(std::size_t chip) const;
  bool shared(const Trigger& trigger) const;

  Debuggee& debuggee_;
  const std::vector<ProgramView>& programs_;
  std::vector<std::unique_ptr<ChipEar>> chips_;
  std::map<unsigned, Trigger> armed_;
  std::map<std::pair<unsigned, std::size_t>, Expression> conditions_;
  std::map<unsigned, Expression> values_;
  std::map<unsigned, bool> were_;
  std::optional<std::size_t> each_;
  bool open_ = false, learns_late_ = false;
  Time after_{};
};

}  // namespace machine::debug

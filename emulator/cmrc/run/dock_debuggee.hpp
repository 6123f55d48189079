#pragma once
// The dock in a debugger: its DSPs, shared memory, the events of the run, and the plant's signals as values.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cmrc/run/simulation.hpp"
#include "cmrc/tasks/words.hpp"
#include "machine/debug/debuggee.hpp"
#include "plant/dock/dock.hpp"

namespace cmrc {

class DockDebuggee final : public machine::debug::Debuggee, private report::EventSink {
 public:
  /// The run must outlive this object.
  explicit DockDebuggee(Simulation& simulation);
  ~DockDebuggee() override;

  std::size_t chips() const override;
  std::string chip_name(std::size_t n) const override;
  c40::Chip& chip(std::size_t n) override;
  const toolchain::Image& program(std::size_t n) const override;
  machine::Time time_of(std::size_t n, c40::Cycles cycle) const override;
  std::string describe(std::size_t n) override;
  void set_trace(std::size_t n, c40::TraceSink* sink) override;
  void changed_by_hand(std::optional<std::size_t> moved) override;
  std::optional<std::string> holds_pc(std::size_t n) override;
  machine::Time now() const override;
  std::optional<std::string> over() const override;
  void run_until(machine::Time time) override;
  machine::Time slice() const override { return std::chrono::milliseconds{1}; }
  machine::Time delay() const override { return std::chrono::milliseconds{1}; }
  std::string save() override;
  void load(std::string_view state) override;
  std::optional<Word> peek(std::size_t n, c40::Address address) override;
  void poke(std::size_t n, c40::Address address, Word value) override;
  std::optional<c40::Address> shared_word(std::size_t n, c40::Address address) const override;
  void watch_shared(machine::debug::SharedListener* listener, std::vector<c40::AddressRange> words) override;
  std::vector<machine::debug::EventKind> event_kinds() const override;
  void listen(machine::debug::DebugEventListener* listener, const std::set<std::string>& kinds) override;
  std::vector<std::string> value_names() override;
  std::optional<double> value(std::string_view name) override;
  std::vector<std::string> page_names() const override;
  std::string page(std::string_view name) override;

 private:
  void event(const report::Event& event) override;
  /// Of all kinds of tasks that have a program.
  std::vector<std::string> task_names() const;
  std::string task_name(Word kind) const;
  std::string list_page() const;

  Simulation& simulation_;
  Words words_;
  Word window_;  ///< address of offset 0 of shared memory
  std::map<std::string, std::function<double(const plant::Signal&)>, std::less<>> values_;
  std::vector<c40::TraceSink*> traces_;  ///< sinks that were set before
  machine::debug::DebugEventListener* listener_ = nullptr;
  std::set<report::EventKind> kinds_;
};

}  // namespace cmrc

#pragma once
// cmrc._core.debug: the debugger over what can be debugged.
#include <memory>
#include <utility>

#include "machine/debug/debugger.hpp"
#include "python/bindings/bindings.hpp"
#include "python/bindings/ctrl_c.hpp"

/// A debugger, with the machine that it drives and the objects that must outlive this machine.
class PythonDebugger {
 public:
  /// \param with_gil the run's listeners make Python objects
  PythonDebugger(std::shared_ptr<void> owner, std::unique_ptr<machine::debug::Debuggee> debuggee, bool with_gil = false)
      : owner_(std::move(owner)),
        debuggee_(std::move(debuggee)),
        debugger_(std::make_unique<machine::debug::Debugger>(*debuggee_)),
        with_gil_(with_gil) {}
  machine::debug::Debugger& get() { return *debugger_; }
  /// Ctrl-C ends it between two slices.
  template <class Work>
  auto long_work(Work work) {
    return with_gil_ ? interruptible(work) : interruptible_without_gil(work);
  }

 private:
  std::shared_ptr<void> owner_;
  std::unique_ptr<machine::debug::Debuggee> debuggee_;
  std::unique_ptr<machine::debug::Debugger> debugger_;
  bool with_gil_;
};

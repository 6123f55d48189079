#pragma once
// cmrc._core.debug: the debugger over what can be debugged.
#include <memory>
#include <utility>

#include "machine/debug/debugger.hpp"
#include "python/bindings/bindings.hpp"

/// A debugger, with what it drives and whatever has to outlive that.
class PythonDebugger {
 public:
  PythonDebugger(std::shared_ptr<void> owner, std::unique_ptr<machine::debug::Debuggee> debuggee)
      : owner_(std::move(owner)), debuggee_(std::move(debuggee)), debugger_(std::make_unique<machine::debug::Debugger>(*debuggee_)) {}
  machine::debug::Debugger& get() { return *debugger_; }

 private:
  std::shared_ptr<void> owner_;
  std::unique_ptr<machine::debug::Debuggee> debuggee_;
  std::unique_ptr<machine::debug::Debugger> debugger_;
};

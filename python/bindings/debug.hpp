#pragma once
// cmrc._core.debug: the debugger over what can be debugged.
#include <memory>
#include <optional>
#include <utility>

#include "machine/debug/debugger.hpp"
#include "python/bindings/bindings.hpp"
#include "python/bindings/interpreter/ctrl_c.hpp"
#include "python/bindings/interpreter/one_user.hpp"

/// A debugger, with the machine that it drives and the objects that must outlive this machine. One thread at a time may
/// be in the debugger and in its machine.
class PythonDebugger {
 public:
  /// \param with_gil long calls keep the GIL: the run's listeners make Python objects, or nothing else guards the
  /// machine
  /// \param machine_user who is in the machine, where its own calls release the GIL
  PythonDebugger(std::shared_ptr<void> owner, std::unique_ptr<machine::debug::Debuggee> debuggee, bool with_gil,
                 OneUser* machine_user = nullptr)
      : owner_(std::move(owner)),
        debuggee_(std::move(debuggee)),
        debugger_(std::make_unique<machine::debug::Debugger>(*debuggee_)),
        machine_user_(machine_user),
        with_gil_(with_gil) {}
  /// For short calls. \throws std::runtime_error if another thread is in a long one
  machine::debug::Debugger& get(const char* call) {
    user_.reads(call);
    if (machine_user_ != nullptr) machine_user_->reads("debug");
    return *debugger_;
  }
  /// Ctrl-C ends it between two slices. \throws std::runtime_error if another thread, or this one, is in a long call
  template <class Work>
  auto long_work(const char* call, Work work) {
    const OneUser::Long use(user_, call, false);
    std::optional<OneUser::Long> of_machine;
    if (machine_user_ != nullptr) of_machine.emplace(*machine_user_, "debug", false);
    const auto done = [&] { return work(*debugger_); };
    return with_gil_ ? interruptible(done) : interruptible_without_gil(done);
  }

 private:
  std::shared_ptr<void> owner_;
  std::unique_ptr<machine::debug::Debuggee> debuggee_;
  std::unique_ptr<machine::debug::Debugger> debugger_;
  OneUser user_{"Debugger"};
  OneUser* machine_user_;
  bool with_gil_;
};

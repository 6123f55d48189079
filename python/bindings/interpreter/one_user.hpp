#pragma once
// At most one thread at a time in an object whose calls may run without the GIL.
#include <fmt/format.h>

#include <stdexcept>
#include <thread>

/// The thread that is in a long call of an object. Callers have the GIL, which separates short calls from each other;
/// a short call only checks that no long call is running.
class OneUser {
 public:
  explicit OneUser(const char* what) : what_(what) {}

  /// For calls that change nothing. During a long call only its own thread may make them, from inside a callback.
  /// \throws std::runtime_error
  void reads(const char* call) const {
    if (call_ != nullptr && thread_ != std::this_thread::get_id()) refuse(call);
  }
  /// For calls that change something, and for long calls. \throws std::runtime_error
  void changes(const char* call) const {
    if (call_ != nullptr) refuse(call);
  }

  /// A long call, until its end. A long call that only reads may be nested in another; the outer call stays marked.
  class Long {
   public:
    Long(OneUser& user, const char* call, bool only_reads) : user_(user), outermost_(user.call_ == nullptr) {
      only_reads ? user.reads(call) : user.changes(call);
      if (outermost_) user.call_ = call, user.thread_ = std::this_thread::get_id();
    }
    ~Long() {
      if (outermost_) user_.call_ = nullptr;
    }
    Long(const Long&) = delete;
    Long& operator=(const Long&) = delete;

   private:
    OneUser& user_;
    bool outermost_;
  };

 private:
  [[noreturn]] void refuse(const char* call) const {
    const bool own = thread_ == std::this_thread::get_id();
    throw std::runtime_error(
        own ? fmt::format(
                  "{0}.{1}: not from inside a callback of {2}; there only what reads is allowed, such as result()",
                  what_, call, call_)
            : fmt::format("{0}.{1}: another thread is in {0}.{2}; one thread at a time may use it, so wait for its end",
                          what_, call, call_));
  }

  const char* what_;
  const char* call_ = nullptr;
  std::thread::id thread_;
};

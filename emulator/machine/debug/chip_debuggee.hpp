#pragma once
/// A single chip in a debugger. If the chip needs an answer from outside, it counts as ended until the answer comes.
/// The chip keeps breakpoints at the ends of its program: whoever runs it without the debugger passes over them.
#include "machine/boards/board_devices.hpp"
#include "machine/boards/board_reserved.hpp"
#include "machine/debug/debuggee.hpp"

namespace machine::debug {

class ChipDebuggee final : public Debuggee {
 public:
  /// All must outlive this object.
  /// \param around the devices behind the chip's windows; null: none
  /// \param ignored answers accesses to addresses without memory; null: they are faults
  ChipDebuggee(c40::Chip& chip, const toolchain::Image& program, BoardDevices* devices = nullptr,
               LoneDevices* around = nullptr, IgnoredAccesses* ignored = nullptr);

  std::size_t chips() const override { return 1; }
  std::string chip_name(std::size_t) const override { return "chip"; }
  c40::Chip& chip(std::size_t) override { return chip_; }
  const toolchain::Image& program(std::size_t) const override { return program_; }
  Time time_of(std::size_t, c40::Cycles cycle) const override { return cycle * period; }
  std::string describe(std::size_t) override { return over_.value_or("running"); }
  void set_trace(std::size_t, c40::TraceSink* sink) override;
  Time now() const override { return now_; }
  std::optional<std::string> over() const override { return over_; }
  std::optional<std::size_t> calls() const override {
    return over_ && calls_ ? std::optional<std::size_t>(0) : std::nullopt;
  }
  void look_again() override;
  void changed_by_hand(std::optional<std::size_t>) override { look_again(); }
  void run_until(Time time) override;
  Time slice() const override { return std::chrono::milliseconds{1}; }
  std::string output() override { return devices_ != nullptr ? devices_->console() : std::string(); }
  std::string save() override;
  void load(std::string_view state) override;
  std::optional<Word> peek(std::size_t, Address address) override;
  void poke(std::size_t, Address address, Word value) override { chip_.poke(address, value); }

 private:
  static constexpr Time period = std::chrono::nanoseconds{50};  ///< of an instruction cycle at 40 MHz
  void list_state(state::Visitor& list);
  bool answered(const c40::ExternalAccess& access);
  std::optional<std::string> end_of(const c40::StopInfo& stop) const;
  std::optional<std::string> rests() const;
  void notice_halt();

  c40::Chip& chip_;
  BoardDevices* devices_;
  LoneDevices* around_;
  IgnoredAccesses* ignored_;
  const toolchain::Image& program_;
  Time now_;
  std::optional<std::string> over_;
  bool calls_ = false;  ///< over_ is an SWI
  c40::TraceSink* before_ = nullptr;
};

}  // namespace machine::debug

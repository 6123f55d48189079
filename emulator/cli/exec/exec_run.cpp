// The loop of exec for one chip (exec_run.hpp).
#include "cli/exec/exec_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "c40/values/float40.hpp"
#include "cli/arguments/program.hpp"
#include "io/signals.hpp"
#include "isa/program_end.hpp"
#include "machine/chips/asleep.hpp"
#include "machine/chips/chip_runner.hpp"
#include "machine/time/time.hpp"

namespace cli {
namespace {

using toolchain::Address;
using toolchain::Image;

/// Stops at a branch to itself and at an IDLE that nothing can end.
class Run final : private machine::ChipRunner {
 public:
  Run(c40::Chip& chip, const Until& until, const ExecOptions& options, Connected& connected)
      : chip_(chip),
        until_(until),
        asked_(options.cycles.has_value()),
        given_(options.cycles ? options.cycles : options.max_cycles),
        limit_(given_.value_or(default_max_cycles)),
        connected_(connected) {
    for (const Address pc : until_.pcs) chip_.add_breakpoint(pc);
    chip_.stop_at_ends(true);
  }

  Outcome run() {
    run_chip(chip_);
    return outcome_;
  }

 private:
  static constexpr c40::Cycles slice =
      50'000;  // cycles between two looks at signals: a moment even when each instruction is written to a trace

  std::optional<Span> span() override {
    for (const auto& [address, word] : until_.words)
      if (chip_.peek(address) == word) {
        ends({"until", fmt::format("{:08X}h holds {:08X}h, at {:08X}h", address, word, chip_.pc())});
        return {};
      }
    if (std::exchange(passes_, false)) {
      connected_.devices.limit(limit_);  // events of devices come before the instruction
      return Span{.one_instruction = true};
    }
    if (io::stop_asked()) {
      ends({"interrupted", fmt::format("by a signal, at {:08X}h", chip_.pc())});
      return {};
    }
    const c40::Cycles look =
        chip_.idle() ? 8 : 1000;  // cycles until the next look at the DMA, for which an idle processor may wait
    if (connected_.front.may_be_typed()) {
      connected_.front.listen(chip_.cycle());
      // Who types needs time. Nobody does behind the end of the input.
      if (!given_) limit_ = connected_.front.may_be_typed() ? machine::never_cycle : chip_.cycle() + default_max_cycles;
    }
    const c40::Cycles end = connected_.devices.limit(std::min(limit_, chip_.cycle() + (!until_.words.empty() ? 1
                                                                                       : chip_.dma_active()  ? look
                                                                                                             : slice)));
    return Span{.limit = end, .known = end};
  }

  bool at_limit() override {
    if (chip_.cycle() >= limit_)
      return asked_
                 ? ends({"limit", fmt::format("the {} cycles of --cycles have passed, at {:08X}h", limit_, chip_.pc())})
                 : ends({"limit",
                         fmt::format("--max-cycles {} reached{} at {:08X}h{}", given_.value_or(default_max_cycles),
                                     limit_ == given_.value_or(default_max_cycles) ? "" : " since the end of the input",
                                     chip_.pc(), booting()),
                         run_failed});
    if (!machine::sleeps_forever(chip_) || is_woken()) return true;
    if (machine::awaits_dma(chip_)) return dma_wait();
    return ends({"idle", fmt::format("IDLE at {:08X}h, and no interrupt will come{}", chip_.pc() - 1,
                                     machine::armed_dma(chip_))});
  }

  bool asks_again() override { return at_limit(); }

  bool at_breakpoint() override {
    const Address pc = chip_.pc();
    if (std::ranges::find(until_.pcs, pc) != until_.pcs.end())
      return ends({"until", fmt::format("reached {:08X}h", pc)});
    if (chip_.program_end() == isa::ProgramEnd::halt && !chip_.dma_busy() && !machine::timer_paces_dma(chip_) &&
        !chip_.interrupt_pending()) {
      const bool can = machine::can_interrupt(chip_), awaits_dma = machine::awaits_dma(chip_);
      const bool by_chip = awaits_event() || (awaits_dma && machine::next_dma_tick(chip_) != machine::never_cycle);
      if (can && (by_chip || is_woken())) return passes_ = true;
      if (can && awaits_dma) return dma_wait();
      return ends({"halt", fmt::format("branch to itself at {:08X}h{}", pc, machine::armed_dma(chip_))});
    }
    return passes_ = true;
  }

  bool window_access(const c40::ExternalAccess& access) override {
    if (connected_.devices.serve(access) || connected_.ignored.serve(chip_, access)) return true;
    return ends({"external_access",
                 fmt::format("{}{} at {:08X}h from PC {:08X}h: that is a bus window, and no [[device]] of the board "
                             "file is behind it{}",
                             access.channel < 0 ? "" : fmt::format("DMA channel {}: ", access.channel),
                             access.write ? "write" : "read", access.address, chip_.pc(), booting()),
                 run_failed});
  }

  bool port_access(const c40::PortAccess& access) override { return port_wait(access); }

  bool port_wait(const c40::PortAccess& access) override {
    if (connected_.feeder && connected_.feeder->serve(access)) return true;
    return ends({"port_wait",
                 fmt::format("{} from PC {:08X}h waits forever since cycle {}: nothing is attached to the port{}",
                             c40::describe(access), chip_.pc(), access.cycle, booting()),
                 run_failed});
  }

  bool faulted(const c40::Fault& why) override {
    return ends({"fault", fmt::format("{} (PC {:08X}h, cycle {}){}", why.message, chip_.pc(), why.cycle, booting()),
                 run_failed});
  }

  /// Whether the chip stopped in the loader of the boot ROM, and the position in its stream.
  std::string booting() const {
    if (chip_.pc() >= c40::rom_words) return "";
    if (connected_.stream)
      return fmt::format(
          "; this is the boot loader, which reads the stream at {:08X}h: a whole one is expected, in memory of the "
          "width that its first word says",
          *connected_.stream);
    if (!connected_.feeder) return "";
    return fmt::format("; this is the boot loader, which has got {} of {} words of its stream through port {}",
                       connected_.feeder->sent(), connected_.feeder->size(), connected_.feeder->port());
  }

  /// For a chip that nothing on it will wake: a device will, perhaps because of what somebody types. While only that
  /// can wake the chip, no cycle passes.
  bool is_woken() {
    while (!connected_.devices.could_wake()) {
      if (!connected_.front.may_be_typed() || !connected_.devices.typing_could_wake()) return false;
      connected_.front.listen(chip_.cycle(), true);
      if (io::stop_asked()) return true;  // the next span ends the run
    }
    return true;
  }
  bool awaits_event() const { return machine::next_timer_interrupt(chip_) != machine::never_cycle; }

  bool dma_wait() {
    std::vector<std::string> waits;
    for (const c40::DmaWait& wait : chip_.dma_waits())
      waits.push_back(fmt::format("{} forever since cycle {}", c40::describe(wait), wait.since));
    return ends({"dma_wait", fmt::format("{}; the processor sleeps at PC {:08X}h", fmt::join(waits, "; "), chip_.pc()),
                 run_failed});
  }

  bool ends(Outcome outcome) {
    outcome_ = std::move(outcome);
    return false;
  }

  c40::Chip& chip_;
  const Until& until_;
  bool asked_;  ///< a run to the limit is what the user requested
  std::optional<std::int64_t> given_;
  c40::Cycles limit_;
  bool passes_ = false;  ///< the instruction at the breakpoint is executed next
  Connected& connected_;
  Outcome outcome_;
};

}  // namespace

Until parse_until(const ExecOptions& options, const Image& image) {
  Until until;
  for (const std::string& text : options.until) {
    const std::size_t equals = text.find("==");
    if (equals == std::string::npos)
      until.pcs.push_back(parse_address(text, &image, "--until"));
    else
      until.words.emplace_back(parse_address(text.substr(0, equals), &image, "--until"),
                               parse_address(text.substr(equals + 2), &image, "--until, behind =="));
  }
  return until;
}

Outcome run(c40::Chip& chip, const Until& until, const ExecOptions& options, Connected& connected) {
  return Run(chip, until, options, connected).run();
}

}  // namespace cli

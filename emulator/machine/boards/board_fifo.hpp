#pragma once
/// A FIFO to and from a host; and a mailbox, which is a FIFO of one word in each direction.
///
/// Words: +0 data; +1 status; +2, +3 number of words that wait for the program, for the host; +4 control. Inaccuracies:
/// this is not a real part. The FIFO of a host board has its flags at other bits, but with the same meanings. The host
/// acts in the first possible cycle, and takes no time beyond input_cycles and output_cycles.
#include <algorithm>
#include <deque>
#include <vector>

#include "machine/boards/board_device.hpp"

namespace machine {

class Fifo final : public BoardDevice {
 public:
  static constexpr c40::Address registers = 5;

  explicit Fifo(const DeviceDescription& described)
      : depth_(described.kind == DeviceKind::mailbox ? 1 : described.depth),
        input_cycles_(described.input_cycles),
        output_cycles_(described.output_cycles) {
    if (described.input) host_ = HostScript(described.input->steps);
    advance_to(0);
  }

  c40::Word read(c40::Address offset, c40::Cycles now) override;
  void write(c40::Address offset, c40::Word value, c40::Cycles now) override;
  void advance_to(c40::Cycles now) override;
  c40::Cycles next_event() const override { return control_ == 0 ? never_cycle : next_word(); }
  bool continues() const override { return !in_.empty() || next_word() != never_cycle; }
  bool interrupts() const override;
  const std::vector<c40::Word>* sent() const override { return &sent_; }
  HostScript* host() override { return &host_; }
  void list_state(state::Visitor& list) override;

 private:
  enum Status : c40::Word {
    has_word = 1u << 0,
    has_room = 1u << 1,
    in_full = 1u << 2,
    out_empty = 1u << 3,
    in_half_full = 1u << 4,
    out_half_full = 1u << 5,
    overflow = 1u << 6,
    underflow = 1u << 7
  };
  /// Control: interrupt while a word waits for the program, while no word waits for the host, while the input is half
  /// full.
  static constexpr c40::Word on_input = 1, on_empty = 2, on_half = 4;

  bool half(const std::deque<c40::Word>& fifo) const { return 2 * fifo.size() >= depth_; }
  c40::Word status() const;
  c40::Cycles next_arrival() const {
    return in_.size() < depth_ && host_.next() != never_cycle ? std::max(host_.next(), arrives_from_) : never_cycle;
  }
  c40::Cycles next_leave() const { return out_.empty() ? never_cycle : leaves_from_; }
  c40::Cycles next_word() const { return std::min(next_arrival(), next_leave()); }

  std::size_t depth_;
  c40::Cycles input_cycles_, output_cycles_;
  HostScript host_;
  std::deque<c40::Word> in_, out_;
  std::vector<c40::Word> sent_;
  c40::Cycles arrives_from_ = 0, leaves_from_ = 0;
  c40::Word control_ = 0, errors_ = 0;
};

}  // namespace machine

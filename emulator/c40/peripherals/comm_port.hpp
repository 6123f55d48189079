#pragma once
/// One communication port as its own chip sees it: two FIFOs, the halts, and the right to send (c40-hardware.md 2.1 to
/// 2.3). link.hpp has what happens between two ports.
///
/// Inaccuracies: writing the input FIFO and reading the output FIFO have no effect (the output FIFO reads 0; undefined
/// on the chip). The software reset register of later revisions is not modelled.
#include <array>
#include <span>
#include <string>

#include "c40/peripherals/fields.hpp"

namespace state {
class Visitor;
}

namespace c40 {

inline constexpr int port_count = 6;

/// The port control register, CPCR (c40-hardware.md 2.1).
namespace cpcr {
inline constexpr Field PORT_DIR{"PORT DIR", 2, 1, FieldAccess::read_only,
                                "0: this side has the token (output); 1: it has not (input)"};
inline constexpr Field ICH{"ICH", 3, 1, FieldAccess::read_write, "1: the input channel is halted"};
inline constexpr Field OCH{"OCH", 4, 1, FieldAccess::read_write, "1: the output channel is halted"};
inline constexpr Field OUTPUT_LEVEL{"OUTPUT LEVEL", 5, 4, FieldAccess::read_only,
                                    "words in the output FIFO; 15 means 8, full"};
inline constexpr Field INPUT_LEVEL{"INPUT LEVEL", 9, 4, FieldAccess::read_only,
                                   "words in the input FIFO; 15 means 8, full"};
}  // namespace cpcr

/// Eight words, oldest first.
class Fifo {
 public:
  static constexpr std::size_t depth = 8;

  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  bool full() const { return count_ == depth; }
  Word front() const { return words_[0]; }
  std::span<const Word> words() const { return {words_.data(), count_}; }
  /// The FIFO must not be full.
  void push(Word word) { words_[count_++] = word; }
  /// The FIFO must not be empty.
  Word pop();
  void clear() { *this = Fifo{}; }
  /// In the form that CPCR shows.
  Word level() const { return full() ? 15 : count_; }

  void list_state(state::Visitor& list);
  friend bool operator==(const Fifo&, const Fifo&) = default;

 private:
  std::array<Word, depth> words_{};  ///< words behind the last one are 0
  std::uint8_t count_ = 0;
};

/// Words that passed each place since the chip was made; resets do not clear these counts. Always written = sent +
/// discarded_output + output FIFO, and received = read + discarded_input + input FIFO.
struct PortTraffic {
  std::uint64_t written = 0;           ///< by CPU or DMA, to the output FIFO
  std::uint64_t sent = 0;              ///< from the output FIFO to the link
  std::uint64_t received = 0;          ///< from the link into the input FIFO
  std::uint64_t read = 0;              ///< by CPU or DMA, from the input FIFO
  std::uint64_t discarded_output = 0;  ///< in the output FIFO when the chip was reset
  std::uint64_t discarded_input = 0;   ///< in the input FIFO when the chip was reset
  friend bool operator==(const PortTraffic&, const PortTraffic&) = default;
};

struct CommPort {
  Fifo input, output;
  bool token = false;  ///< this side drives the link
  bool input_halted = false, output_halted = false;
  PortTraffic traffic;

  /// Ports 0, 1, 2 have the token after reset.
  static constexpr bool token_after_reset(int port) { return port < 3; }
  /// The state after reset: FIFOs empty, not halted. Only the port's number decides whether the port has the token.
  void reset(int port);
  /// CPCR.
  Word control() const;
  void write_control(Word value);
  /// The conditions of section 2.3: levels, not latched.
  bool icrdy() const { return !input.empty(); }
  bool icfull() const { return input.full(); }
  bool ocrdy() const { return !output.full(); }
  bool ocempty() const { return output.empty(); }
  /// One word at a time, from the processor's side and from the link's.
  void write(Word word);
  Word read();
  Word send();
  void receive(Word word);

  friend bool operator==(const CommPort&, const CommPort&) = default;
};

enum class PortRegister : std::uint8_t { control, input, output };

/// An access of the chip to a communication port (c40-hardware.md 2.2).
struct PortAccess {
  int port = 0;
  PortRegister reg = PortRegister::control;
  bool write = false;
  Word value = 0;       ///< of a write
  Address address = 0;  ///< of the register
  Cycles cycle = 0;     ///< when the access begins
  /// A read of an empty input FIFO and a write to a full output FIFO have to wait; all other accesses are ready.
  bool ready(const CommPort& side) const {
    if (reg == PortRegister::input && !write) return side.icrdy();
    if (reg == PortRegister::output && write) return side.ocrdy();
    return true;
  }
  /// Performs the access; the port must be ready. Returns the value of a read.
  Word perform(CommPort& side) const;
  /// The value that a read would give, without reading; false if there is no word.
  bool peek(const CommPort& side, Word& value) const;
};

/// Port registers are at 100040h + 10h * n: control, input FIFO, output FIFO (c40-hardware.md 1.3).
bool is_port_register(Address address);
PortAccess port_access(Address address, bool write, Word value, Cycles cycle);

/// "the read of input FIFO 3 (00100071h)"
std::string describe(const PortAccess& access);

/// The listener of what a chip does to its side of a port: the link.
class PortListener {
 public:
  virtual ~PortListener() = default;
  /// The processor wrote or read a FIFO or halted a channel in its cycle `at`.
  virtual void changed(const CommPort& side, Cycles at) = 0;
  /// The chip is reset in its cycle `at`: called before and after the port's reset.
  virtual void about_to_reset(Cycles at) = 0;
  virtual void was_reset(const CommPort& side, Cycles at) = 0;
};

}  // namespace c40

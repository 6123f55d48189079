#pragma once
/// Expressions in conditions, watches and prints: `r0`, `f(r1)`, `ar3 + 2`, `[kernel_state + 4]`, `f([ar0]) > 1.5`,
/// `chip1.pc == kernel_pid`, `TIMER0.counter`, `plant.payload_z_m < 1`, `cycle`, `instructions`, `cause.bus_transfer`,
/// `time_s`. Operators as in C: || && | ^ & == != < <= > >= << >> + - * / % ! ~. Words are signed 32-bit numbers; ==
/// and != compare their 32 bits. f(x): x as a float; of R0 to R11 all 40 bits. u(x): the word as an unsigned number.
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "machine/debug/debuggee.hpp"
#include "machine/debug/inspect.hpp"

namespace machine::debug {

struct Value {
  bool is_float = false;
  std::int64_t integer = 0;
  double real = 0;
  std::optional<Address> address{};  ///< the address of a word in memory, or of a label
  /// It is the value of a register or a counter by itself, which is no address.
  bool is_register = false, is_counter = false;
  std::optional<std::size_t> chip{};  ///< chip1.x: another chip than the one that the expression is for
  /// An integer of 32 bits, signed or unsigned.
  bool is_word() const { return !is_float && integer >= -0x80000000LL && integer <= 0xFFFFFFFFLL; }
  bool truth() const { return is_float ? real != 0 : integer != 0; }
  double number() const { return is_float ? real : static_cast<double>(integer); }
  /// "1.5", "-2 (FFFFFFFEh)"
  std::string text() const;
};

class Expression {
 public:
  /// \throws DebugError that shows the place
  Expression(std::string_view text, Debuggee& debuggee, const std::vector<ProgramView>& programs, std::size_t chip);
  ~Expression();
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) noexcept;

  /// The value for the chip of the constructor. \throws DebugError if memory cannot be read
  Value value() const;
  /// The value while chips are at different instants; none if it depends on more than the chip's own registers and
  /// memory.
  std::optional<Value> own_value() const;

  struct Node;

 private:
  std::unique_ptr<Node> root_;
};

/// The address of a word by a user's words: a label, also one that has the name of a register or a counter; else an
/// expression: `[ar0 + 2]`, `300000h`, `TIMER0.counter`. \param by_register a register by itself is an address, too
/// \throws DebugError for what is none
Address word_named(std::string_view text, Debuggee& debuggee, const std::vector<ProgramView>& programs,
                   std::size_t chip, bool by_register = false);

/// The text with each {expression} replaced by its value.
std::string filled_in(std::string_view text, Debuggee& debuggee, const std::vector<ProgramView>& programs,
                      std::size_t chip);

}  // namespace machine::debug

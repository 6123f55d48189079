// Operands of instructions in the source text.
#include <fmt/format.h>

#include "toolchain/syntax/diagnostics.hpp"
#include "toolchain/syntax/parser.hpp"

namespace toolchain {

std::optional<isa::Register> Parser::register_called(std::string_view name) const {
  if (const auto found = isa::register_named(name, context_.cpu)) return found;
  if (context_.registers == nullptr) return std::nullopt;
  const auto alias = context_.registers->find(name);
  return alias == context_.registers->end() ? std::nullopt : std::optional(alias->second);
}

std::optional<isa::Expansion> Parser::expansion_called(std::string_view name) const {
  return context_.cpu == isa::Cpu::c40 ? isa::expansion_named(name) : std::nullopt;
}

std::optional<isa::Register> Parser::lone_register() {
  const std::size_t start = position_;
  const auto found = accept_register();
  if (found && (at_end() || peek() == ',')) return found;
  position_ = start;
  return std::nullopt;
}

std::optional<isa::Register> Parser::accept_register() {
  skip_blanks();
  const std::size_t start = position_;
  const bool marked = peek() == '%' && is_identifier_start(peek(1));
  if (marked) ++position_;
  if (!is_identifier_start(peek())) return std::nullopt;
  const auto found = register_called(identifier());
  if (!found) position_ = start;
  if (found && marked && context_.dialect != Dialect::gnu)
    throw LineError{start, "'%' before a register is GNU syntax: --dialect gnu, or .dialect gnu"};
  return found;
}

/// GNU as's ^x and #x at the beginning of an operand.
bool Parser::accept_half_of_address(char mark) {
  if (peek() != mark) return false;
  if (context_.dialect != Dialect::gnu)
    throw LineError{
        position_,
        fmt::format(
            "'{0}' at the beginning of an operand is GNU syntax for {1} of an address: --dialect gnu, or {2}(x)", mark,
            mark == '^' ? "the upper half" : "the lower half", mark == '^' ? "hi16" : "lo16")};
  ++position_;
  return true;
}

OperandSyntax Parser::operand() {
  skip_blanks();
  OperandSyntax out;
  out.offset = position_;
  if (peek() == '*') return indirect();
  if (accept("@")) {
    out.kind = OperandSyntax::Kind::direct;
    out.expression = expression();
    return out;
  }
  for (const char mark : {'^', '#'})
    if (const std::size_t at = position_; accept_half_of_address(mark)) {
      out.expression = Expression{Expression::Kind::call, {}, std::string(1, mark), {expression()}, at};
      return out;
    }
  if (accept("=")) {
    out.exact = true;
    out.expression = expression();
    return out;
  }
  const std::size_t start = position_;
  if (const auto found = accept_register()) {
    out.kind = OperandSyntax::Kind::reg;
    out.reg = *found;
    return out;
  }
  if (const auto found = expansion_called(identifier())) {
    out.kind = OperandSyntax::Kind::expansion;
    out.expansion = *found;
    return out;
  }
  position_ = start;
  out.expression = expression();
  return out;
}

OperandSyntax Parser::indirect() {
  using Action = isa::modn::Action;
  OperandSyntax out;
  out.kind = OperandSyntax::Kind::indirect;
  out.offset = position_;
  expect("*");
  skip_blanks();
  const int plus = accept("++") ? 2 : accept("--") ? -2 : accept("+") ? 1 : accept("-") ? -1 : 0;
  const std::size_t register_offset = position_;
  const auto ar = accept_register();
  if (!ar || isa::code(*ar) < 8 || isa::code(*ar) > 15)
    throw LineError{register_offset, "indirect addressing goes through AR0 to AR7"};
  out.reg = *ar;
  const std::size_t post_offset = position_;
  const int post = accept("++") ? 1 : accept("--") ? -1 : 0;
  if (plus != 0 && post != 0)
    throw LineError{post_offset, "an address register is changed either before or after its use, not both"};
  unsigned index = 0;
  const std::size_t amount_offset = position_;
  const bool amount = accept("(");
  if (amount) {
    const auto index_register = accept_register();
    if (index_register) {
      if (*index_register != isa::Register::IR0 && *index_register != isa::Register::IR1)
        throw LineError{amount_offset + 1, "the index is a displacement, IR0 or IR1"};
      index = *index_register == isa::Register::IR0 ? 1 : 2;
    } else {
      out.exact = accept("=");
      out.expression = expression();
    }
    expect(")");
  }
  const bool circular = peek() == '%';
  const bool reversed = (peek() == 'b' || peek() == 'B') && !is_identifier(peek(1));
  if (circular || reversed) {
    if (post == 0 || (reversed && (post != 1 || index != 1)))
      throw LineError{position_, circular ? "circular addressing has the form *ARn++(x)% or *ARn--(x)%"
                                          : "bit-reversed addressing has the form *ARn++(IR0)B"};
    ++position_;
  }
  if (reversed) {
    out.modn = isa::modn::bit_reversed;
    return out;
  }
  if (plus == 0 && post == 0) {
    if (amount) throw LineError{amount_offset, "*ARn takes no index; write *+ARn(x) or *ARn++(x)"};
    out.modn = isa::modn::plain;
    return out;
  }
  const Action action = post > 0     ? (circular ? Action::post_add_circular : Action::post_add)
                        : post < 0   ? (circular ? Action::post_subtract_circular : Action::post_subtract)
                        : plus == 2  ? Action::pre_add
                        : plus == -2 ? Action::pre_subtract
                        : plus == 1  ? Action::add
                                     : Action::subtract;
  out.modn = static_cast<std::uint8_t>(index << 3 | static_cast<unsigned>(action));
  return out;
}

HalfSyntax Parser::half() {
  HalfSyntax out;
  skip_blanks();
  out.offset = position_;
  out.written = required_identifier("an instruction");
  out.mnemonic = lower(out.written);
  if (at_end() || at_bars()) return out;
  do out.operands.push_back(operand());
  while (accept(","));
  return out;
}

}  // namespace toolchain

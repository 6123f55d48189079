#pragma once
// Substitution symbols: names that are replaced by text, from .asg, .eval and the parameters of macros.
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "isa/word.hpp"

namespace toolchain {

using Substitutes = std::map<std::string, std::string, std::less<>>;

/// Replaces the symbols that are whole words outside quotes, character constants and comments; and `\name`, `:name:`,
/// `:name(n):`, `:name(n,count):` (characters from the nth, counted from 1) anywhere. If `nested`, the inserted texts
/// are replaced in turn. Throws LineError if the line grows without bounds.
std::string substitute(const std::string& text, const Substitutes& symbols, bool nested);

/// The same of names that a line declares: whole words stay.
std::string substitute_forced(const std::string& text, const Substitutes& symbols, bool nested);

/// The substitution symbols of a line: the parameters of the present macro, if any, hide the others.
struct SubstituteScopes {
  Substitutes* parameters = nullptr;
  Substitutes* globals = nullptr;
  isa::Cpu cpu = isa::Cpu::c40;                             ///< The processor whose registers $isreg knows.
  std::function<bool(const std::string&)> is_defined = {};  ///< Whether a symbol has this name: for $isdefed.

  const std::string* find(std::string_view name) const;
  /// The symbols to which an assignment to this name belongs.
  Substitutes& owner(std::string_view name) const;
};

/// Replaces $symlen(s), $symcmp(a,b), $firstch(s,'c'), $lastch(s,'c'), $isdefed(s), $ismember(s,list), $iscons(s),
/// $isname(s), $isreg(s) by their numbers, outside quotes; an argument is a substitution symbol or a text. $ismember
/// removes the first item of the list. \param code characters before the comment
std::string replace_functions(std::string_view text, std::size_t code, const SubstituteScopes& symbols);

}  // namespace toolchain

#pragma once
// Substitution symbols: names that stand for text, those of .asg and .eval and the parameters of macros.
#include <map>
#include <string>
#include <string_view>

#include "isa/types.hpp"

namespace toolchain {

using Substitutes = std::map<std::string, std::string, std::less<>>;

/// Replaces the symbols that stand as whole words outside quotes and comments, and `\name`, `:name:`, `:name(n):`,
/// `:name(n,count):` (characters from the nth, counted from 1) anywhere. Texts put in are replaced in turn if `nested`.
/// Throws LineError when the line grows without bounds.
std::string substitute(const std::string& text, const Substitutes& symbols, bool nested);

/// The substitution symbols in force at a line: the parameters of the macro being expanded, if any, hide the others.
struct SubstituteScopes {
  Substitutes* parameters = nullptr;
  Substitutes* globals = nullptr;
  isa::Cpu cpu = isa::Cpu::c40;  ///< Whose registers $isreg knows.

  const std::string* find(std::string_view name) const;
  /// Where an assignment to this name goes.
  Substitutes& owner(std::string_view name) const;
};

/// Replaces $symlen(s), $symcmp(a,b), $firstch(s,'c'), $lastch(s,'c'), $isdefed(s), $ismember(s,list), $iscons(s),
/// $isname(s), $isreg(s) by their numbers; an argument is a substitution symbol or a text. $ismember takes the first
/// item off the list.
std::string replace_functions(const std::string& text, const SubstituteScopes& symbols);

}  // namespace toolchain

#pragma once
// What a program says: everything goes through one place, which lets no input speak to the terminal.
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

namespace io {

/// Text that a terminal shows and does not obey: control characters (C0 but for newline and tab, DEL, C1) and bytes
/// that are no UTF-8 become \xNN.
std::string printable(std::string_view text);

/// Writes printable text. What is lost is told by flush_output().
void say(std::FILE* to, std::string_view text);
/// errno of the first text that did not go to standard output; 0
int lost_in_saying();

template <typename... Arguments>
void print(std::FILE* to, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  say(to, fmt::format(format, std::forward<Arguments>(arguments)...));
}
template <typename... Arguments>
void print(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  say(stdout, fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace io

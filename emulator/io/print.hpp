#pragma once
// All that a program prints goes through here, so that no input can send control characters to the terminal.
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

namespace io {

/// Text that a terminal shows but does not obey: control characters (C0 except newline and tab, DEL, C1) and bytes that
/// are not UTF-8 become \xNN.
std::string printable(std::string_view text);
/// The text of an exception, which would end at a byte 0: it becomes \x00.
std::string exception_text(std::string_view text);
bool is_utf8(std::string_view text);

/// Writes printable text. flush_output() reports losses.
void say(std::FILE* to, std::string_view text);
/// errno of the first text that did not reach standard output; 0 if all did
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

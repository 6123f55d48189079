#pragma once
// How the characters of a text file are written. Every text that is read here has one byte a character: ASCII or
// Latin-1, or UTF-8, whose ASCII has.
#include <fmt/format.h>

#include <string>
#include <string_view>

#include "io/input_file.hpp"

namespace io {

/// "UTF-16" or "UTF-32" for a text of two or four bytes a character: it begins with the mark of one, or every other of
/// its first bytes is 0. Empty for all else.
std::string_view wide_form(std::string_view text);

/// What a message says of such a text, behind "FILE: "; empty for one that can be read.
std::string wide_form_problem(std::string_view text);

/// Without DOS's end of file (1Ah), where nothing but blanks and further such characters is behind it.
std::string_view without_dos_end(std::string_view text);

/// Without the byte order mark of UTF-8, which present-day editors put before a text.
std::string_view without_mark(std::string_view text);

/// A text without byte order mark and DOS's end. \param name of its file, for the message
/// \throws Error "NAME:1: what is wrong"
template <typename Error>
std::string checked_text(std::string text, const std::string& name) {
  if (const std::string problem = wide_form_problem(text); !problem.empty())
    throw Error(fmt::format("{}:1: {}", name, problem));
  return std::string(without_mark(without_dos_end(text)));
}

/// All of a text file. \param expected what the file should be, for the message
/// \throws Error "FILE: what is wrong; EXPECTED is expected"
template <typename Error>
std::string read_text(const std::filesystem::path& path, std::string_view expected) {
  return checked_text<Error>(read_file<Error>(path, expected), path.string());
}

}  // namespace io

#include "toolchain/objects/source_map.hpp"

#include <fmt/format.h>

#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>

#include "io/input_file.hpp"
#include "isa/ascii.hpp"

namespace toolchain {
namespace {

/// The text up to the next blank; the blank is skipped.
std::string_view next_word(std::string_view& line) {
  const std::string_view word = line.substr(0, line.find(' '));
  line.remove_prefix(std::min(word.size() + 1, line.size()));
  return word;
}

template <typename Number>
Number next_number(std::string_view& line, int base) {
  const std::string_view word = next_word(line);
  const auto value = ascii::number<Number>(word, base);
  if (!value) throw std::invalid_argument(fmt::format("source map: \"{}\" is not a number", word));
  return *value;
}

/// A source file: under its own name, else in the folder `beside`, there at last under the last part of its name.
std::optional<std::filesystem::path> source_on_disk(const std::filesystem::path& name,
                                                    const std::filesystem::path& beside) {
  for (const std::filesystem::path& path : {name, beside / name, beside / name.filename()}) {
    std::error_code error;
    if (std::filesystem::is_regular_file(path, error)) return path;
  }
  return std::nullopt;
}

}  // namespace

std::string source_map(const Image& image, const std::filesystem::path& base) {
  std::string out;
  for (const std::string& file : image.files)
    out += fmt::format("file {}\n", std::filesystem::path(file).lexically_proximate(base).generic_string());
  for (const LineRecord& line : image.lines) {
    out += fmt::format("line {:x} {} {} {} {}\n", line.address, line.section, line.file, line.line, line.text);
    if (!line.second.empty()) out += fmt::format("second {}\n", line.second);
  }
  return out;
}

void add_source_text(Image& image, const std::filesystem::path& beside) {
  std::vector<std::vector<std::string>> texts(image.files.size());
  std::set<std::uint32_t> wanted;
  for (const LineRecord& line : image.lines) wanted.insert(line.file);
  for (const std::uint32_t file : wanted) {
    const auto path = source_on_disk(image.files[file], beside);
    if (!path) continue;
    std::istringstream text(io::read_input(*path).text);
    for (std::string line; std::getline(text, line);) texts[file].push_back(std::move(line));
  }
  for (LineRecord& line : image.lines) {
    const std::vector<std::string>& lines = texts[line.file];
    if (line.line >= 1 && static_cast<std::size_t>(line.line) <= lines.size())
      line.text = lines[static_cast<std::size_t>(line.line) - 1];
  }
}

void name_sources_as_found(Image& image, const std::filesystem::path& beside) {
  for (std::string& file : image.files)
    if (const auto path = source_on_disk(file, beside)) file = path->string();
}

void add_source_map(Image& image, std::string_view map) {
  image.files.clear();
  image.lines.clear();
  while (!map.empty()) {
    std::string_view line = map.substr(0, map.find('\n'));
    map.remove_prefix(std::min(line.size() + 1, map.size()));
    const std::string_view what = next_word(line);
    if (what == "file") {
      image.files.emplace_back(line);
      continue;
    }
    if (what == "second" && !image.lines.empty()) {
      image.lines.back().second = line;
      continue;
    }
    if (what != "line")
      throw std::invalid_argument(fmt::format("source map: no line of a source map begins with \"{}\"", what));
    LineRecord record;
    record.address = next_number<Address>(line, 16);
    record.section = next_number<std::uint32_t>(line, 10);
    record.file = next_number<std::uint32_t>(line, 10);
    record.line = next_number<int>(line, 10);
    record.text = line;
    image.lines.push_back(std::move(record));
  }
}

}  // namespace toolchain

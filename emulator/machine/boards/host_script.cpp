#include "machine/boards/host_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "io/text_form.hpp"
#include "isa/ascii.hpp"
#include "toolchain/objects/written_integer.hpp"

namespace machine {
namespace {

constexpr std::array<std::pair<std::string_view, HostStep::When>, 4> whens{{{"at", HostStep::When::at},
                                                                            {"wait", HostStep::When::wait},
                                                                            {"after", HostStep::When::after},
                                                                            {"on", HostStep::When::on}}};

class ScriptReader {
 public:
  ScriptReader(std::string_view text, std::string_view name) : rest_(io::without_mark(text)), name_(name) {}

  std::vector<HostStep> read() {
    std::vector<HostStep> steps;
    while (next_line())
      if (const std::string_view first = token(); !first.empty()) steps.push_back(step(first));
    return steps;
  }

  std::vector<HostStep> read_words() {
    HostStep all;
    while (next_line())
      for (std::string_view word = token(); !word.empty(); word = token()) {
        const auto value = ascii::number<c40::Word>(word, 16);
        if (!value)
          fail(
              fmt::format("\"{}\" is not a word; a word of up to 8 hexadecimal digits is expected on each line", word));
        all.words.push_back(*value);
      }
    return all.words.empty() ? std::vector<HostStep>{} : std::vector{std::move(all)};
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw HostScriptError(fmt::format("{}:{}: {}", name_, number_, what));
  }

  bool next_line() {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++number_;
    return true;
  }

  /// The text up to the next blank; empty at the end of the line.
  std::string_view token() {
    const std::size_t begin = line_.find_first_not_of(" \t\r,");
    line_.remove_prefix(begin == std::string_view::npos ? line_.size() : begin);
    if (line_.empty() || line_[0] == '#') return {};
    if (line_[0] == '"') return quoted();
    const std::string_view found = line_.substr(0, line_.find_first_of(" \t\r,#"));
    line_.remove_prefix(found.size());
    return found;
  }

  std::string_view quoted() {
    for (std::size_t at = 1; at < line_.size(); ++at) {
      if (line_[at] == '\\') {
        ++at;
      } else if (line_[at] == '"') {
        const std::string_view found = line_.substr(0, at + 1);
        line_.remove_prefix(at + 1);
        return found;
      }
    }
    fail("the text in quotes does not end in this line");
  }

  HostStep step(std::string_view first) {
    const auto when = std::ranges::find(whens, first, &std::pair<std::string_view, HostStep::When>::first);
    if (when == whens.end())
      fail(fmt::format("\"{}\": at CYCLE, wait CYCLES, after COUNT or on WORD is expected first", first));
    HostStep step{.when = when->second, .number = 0, .words = {}};
    const std::string_view given = token();
    const auto number = toolchain::written_integer(given);
    const std::uint64_t most = step.when == HostStep::When::on ? 0xFFFFFFFFu : std::uint64_t{1} << 62;
    if (!number || *number > most)
      fail(
          fmt::format("\"{}\": a number (1Fh, 0x1F or decimal) up to {:X}h is expected behind {}", given, most, first));
    step.number = *number;
    for (std::string_view word = token(); !word.empty(); word = token()) add(step, word);
    if (step.words.empty()) fail("there is no word to send; words or \"text\" are expected at the end");
    return step;
  }

  void add(HostStep& step, std::string_view word) const {
    if (word[0] == '"') return add_text(step, word.substr(1, word.size() - 2));
    const auto value = toolchain::written_integer(word);
    if (!value || *value > 0xFFFFFFFF)
      fail(fmt::format("\"{}\" is not a word; 1Fh, 0x1F, decimal or \"text\" is expected", word));
    step.words.push_back(static_cast<c40::Word>(*value));
  }

  void add_text(HostStep& step, std::string_view text) const {
    for (std::size_t at = 0; at < text.size(); ++at) {
      char c = text[at];
      if (c == '\\') {
        constexpr std::string_view letters = "nrt\\\"0", meant{"\n\r\t\\\"\0", 6};
        const std::size_t which = letters.find(text[++at]);
        if (which == std::string_view::npos)
          fail(fmt::format("\\{}: \\n, \\r, \\t, \\0, \\\\ or \\\" is expected", text[at]));
        c = meant[which];
      }
      step.words.push_back(static_cast<unsigned char>(c));
    }
  }

  std::string_view rest_, line_, name_;
  std::size_t number_ = 0;
};

}  // namespace

std::vector<HostStep> parse_host_script(std::string_view text, std::string_view name) {
  return ScriptReader(text, name).read();
}

std::vector<HostStep> parse_host_words(std::string_view text, std::string_view name) {
  return ScriptReader(text, name).read_words();
}

std::vector<HostStep> characters(std::string_view text) {
  if (text.empty()) return {};
  HostStep step;
  for (const char c : text) step.words.push_back(static_cast<unsigned char>(c));
  return {std::move(step)};
}

std::string to_text(const std::vector<HostStep>& steps) {
  std::string out;
  for (const HostStep& step : steps) {
    const auto when = std::ranges::find(whens, step.when, &std::pair<std::string_view, HostStep::When>::second);
    out += fmt::format("{} {}", when->first, step.number);
    for (const c40::Word word : step.words) out += fmt::format(" 0x{:X}", word);
    out += '\n';
  }
  return out;
}

void HostScript::begin(c40::Cycles now) {
  word_ = 0;
  ready_ = never_cycle;
  if (steps_.empty()) return;
  const HostStep& step = steps_.front();
  const auto number = static_cast<c40::Cycles>(step.number);
  switch (step.when) {
    case HostStep::When::at: ready_ = std::max(now, number); break;
    case HostStep::When::wait: ready_ = now + number; break;
    case HostStep::When::after:
      if (heard_ >= step.number) ready_ = now;
      break;
    case HostStep::When::on: break;
  }
}

void HostScript::add(const std::vector<HostStep>& steps, c40::Cycles now) {
  const bool was_done = steps_.empty();
  for (HostStep step : steps) {
    if (step.when == HostStep::When::at) step.number = std::max(step.number, static_cast<std::uint64_t>(now));
    steps_.push_back(std::move(step));
  }
  if (was_done) begin(now);
}

void HostScript::heard(c40::Word word, c40::Cycles now) {
  ++heard_;
  if (steps_.empty() || ready_ != never_cycle) return;
  const HostStep& step = steps_.front();
  const bool met = step.when == HostStep::When::on ? word == step.number : heard_ >= step.number;
  if (met) ready_ = now;
}

c40::Word HostScript::take(c40::Cycles now) {
  const c40::Word word = steps_.front().words[word_];
  if (++word_ == steps_.front().words.size()) {
    steps_.pop_front();
    begin(now);
  }
  return word;
}

void HostScript::list_state(state::Visitor& list) {
  list("steps", steps_);
  list("word", word_);
  list("heard", heard_);
  list("ready", ready_);
}

}  // namespace machine

#include "c40/pipeline/pipeline_diagram.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace c40 {
namespace {

/// The causes with a letter, last ones first.
std::vector<CauseRow> drawn_causes() {
  std::vector<CauseRow> rows;
  std::copy_if(cause_rows.rbegin(), cause_rows.rend(), std::back_inserter(rows),
               [](const CauseRow& row) { return !row.letter.empty(); });
  return rows;
}

/// Of these, the causes whose cycles pass between read and execute: the access waits for something outside the chip.
std::vector<CauseRow> drawn_waits_outside() {
  std::vector<CauseRow> rows = drawn_causes();
  std::erase_if(rows, [](const CauseRow& row) { return static_cast<std::size_t>(row.cause) < pipeline_cause_count; });
  return rows;
}

/// "p port, b shared bus, d DMA"
std::string legend_of_causes() {
  std::vector<std::string_view> letters;
  for (const CauseRow& row : drawn_causes())
    if (std::ranges::find(letters, row.letter) == letters.end()) letters.push_back(row.letter);
  return fmt::format("{}", fmt::join(letters, ", "));
}

}  // namespace

PipelineDiagram::PipelineDiagram(Cycles first, Cycles last, std::function<std::string(Address, Word)> text,
                                 TraceSink* next)
    : first_(first), last_(last), text_(std::move(text)), next_(next) {
  if (first < 0 || last < first || last - first >= widest)
    throw std::invalid_argument(
        fmt::format("cycles {} to {}: 1 to {} cycles, the first not negative, can be drawn", first, last, widest));
}

bool PipelineDiagram::put(std::string& cells, Cycles cycle, char letter) const {
  if (cycle < first_ || cycle > last_) return false;
  cells[static_cast<std::size_t>(cycle - first_)] = letter;
  return true;
}

void PipelineDiagram::instruction(const TraceRecord& record) {
  if (next_ != nullptr) next_->instruction(record);
  const PipelineStages& at = record.stages;
  const auto cycles_of = [&](const CauseRow& row) { return record.causes[static_cast<std::size_t>(row.cause)]; };
  static const std::vector<CauseRow> outside = drawn_waits_outside();
  Cycles waited = 0;
  for (const CauseRow& row : outside) waited += cycles_of(row);
  const Cycles fetched = record.cycle + at.fetch + at.fetch_cycles, decode = record.cycle + at.decode,
               read = record.cycle + at.read, execute = record.cycle + at.execute;
  if (record.cycle + at.fetch > last_ || execute + waited < first_) return;
  std::string cells(static_cast<std::size_t>(last_ - first_ + 1), ' ');
  bool visible = false;
  const auto fill = [&](Cycles from, Cycles to, char letter) {
    for (Cycles c = std::max(from, first_); c < std::min(to, last_ + 1); ++c) visible |= put(cells, c, letter);
  };
  fill(fetched - at.fetch_cycles, fetched, 'F');
  fill(fetched, decode, '-');
  fill(decode, decode + 1, 'D');
  fill(decode + 1, read, '-');
  fill(read, execute, 'R');
  Cycles done = execute;
  for (const CauseRow& row : outside) {
    fill(done, done + cycles_of(row), row.letter.front());
    done += cycles_of(row);
  }
  fill(done, done + 1, 'E');
  if (!visible) return;
  // A delay by the DMA shows as stages that last longer. The causes do not say which of their cycles are the DMA's: the
  // last ones are drawn so.
  Cycles held = record.causes[static_cast<std::size_t>(Cause::dma_conflict)];
  for (Cycles c = execute - 1; held > 0 && c > record.cycle + at.fetch; --c) {
    if (c == read || c == decode) continue;  // each instruction has its own cycle in each stage
    put(cells, c, 'd');
    --held;
  }
  for (Cycles c = record.cycle + at.fetch - 1; held > 0; --c, --held) put(cells, c, 'd');  // its fetch waited
  std::string stalls;
  for (std::size_t i = 1; i < cause_count; ++i)
    if (record.causes[i] != 0) stalls += fmt::format("  {} {}", name(static_cast<Cause>(i)), record.causes[i]);
  const std::string instruction = fmt::format("{:08X}  {}", record.pc, text_(record.pc, record.word));
  rows_.push_back({cells, stalls.empty() ? instruction : fmt::format("{:<50}{}", instruction, stalls)});
}

void PipelineDiagram::interrupt(const InterruptRecord& record) {
  if (next_ != nullptr) next_->interrupt(record);
  std::string cells(static_cast<std::size_t>(last_ - first_ + 1), ' ');
  if (put(cells, record.cycle, 'I')) rows_.push_back({cells, fmt::format("interrupt {:02X}h", record.vector)});
}

/// Every tenth cycle has its number, and the first one if there is room. Numbers too long for one line alternate
/// between several lines.
std::vector<std::string> PipelineDiagram::ruler() const {
  const auto width = static_cast<std::size_t>(last_ - first_ + 1);
  std::vector<std::string> lines;
  const auto put_number = [&](std::size_t at, const std::string& text) {
    for (std::string& line : lines) {
      if (!line.empty() && line.size() >= at) continue;
      line.resize(at, ' ');
      line += text;
      return;
    }
    lines.push_back(std::string(at, ' ') + text);
  };
  const Cycles tenth = (first_ + 9) / 10 * 10;
  const std::string number = fmt::format("{}", first_);
  const bool has_room = tenth == first_ || tenth > last_ || static_cast<Cycles>(number.size()) < tenth - first_;
  lines.emplace_back(has_room ? number : std::string());
  for (Cycles cycle = tenth == first_ ? tenth + 10 : tenth; cycle <= last_; cycle += 10)
    put_number(static_cast<std::size_t>(cycle - first_), fmt::format("{}", cycle));
  std::string& units = lines.emplace_back();
  for (std::size_t i = 0; i < width; ++i) units += static_cast<char>('0' + (first_ + static_cast<Cycles>(i)) % 10);
  return lines;
}

std::string PipelineDiagram::text() const {
  std::string out =
      fmt::format("pipeline, cycles {} to {} (F fetch, D decode, R read, E execute, - holds, {}, I interrupt)\n",
                  first_, last_, legend_of_causes());
  for (const std::string& line : ruler()) out += line + "\n";
  for (const Row& row : rows_) out += fmt::format("{}  {}\n", row.cells, row.label);
  return out;
}

}  // namespace c40

#include "c40/pipeline_diagram.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace c40 {

PipelineDiagram::PipelineDiagram(Cycles first, Cycles last, std::function<std::string(Address, Word)> text, TraceSink* next)
    : first_(first), last_(last), text_(std::move(text)), next_(next) {
  if (first < 0 || last < first || last - first >= widest)
    throw std::invalid_argument(fmt::format("cycles {} to {}: 1 to {} cycles, the first not negative, can be drawn", first, last, widest));
}

bool PipelineDiagram::put(std::string& cells, Cycles cycle, char letter) const {
  if (cycle < first_ || cycle > last_) return false;
  cells[static_cast<std::size_t>(cycle - first_)] = letter;
  return true;
}

void PipelineDiagram::instruction(const TraceRecord& record) {
  if (next_ != nullptr) next_->instruction(record);
  const StepTiming::Stages& at = record.stages;
  const auto cause = [&](Cause c) { return record.causes[static_cast<std::size_t>(c)]; };
  const Cycles bus = cause(Cause::bus_arbitration) + cause(Cause::bus_transfer);
  const Cycles fetched = record.cycle + at.fetch + at.fetch_cycles, decode = record.cycle + at.decode, read = record.cycle + at.read,
               execute = record.cycle + at.execute;
  if (record.cycle + at.fetch > last_ || execute + bus < first_) return;
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
  fill(execute, execute + bus, 'b');
  fill(execute + bus, execute + bus + 1, 'E');
  if (!visible) return;
  std::string stalls;
  for (std::size_t i = 1; i < cause_count; ++i)
    if (record.causes[i] != 0) stalls += fmt::format("  {} {}", name(static_cast<Cause>(i)), record.causes[i]);
  const std::string instruction = fmt::format("{:08X}  {}", record.pc, text_(record.pc, record.word));
  rows_.push_back({cells, stalls.empty() ? instruction : fmt::format("{:<50}{}", instruction, stalls)});
}

void PipelineDiagram::interrupt(Word vector, Cycles cycle) {
  if (next_ != nullptr) next_->interrupt(vector, cycle);
  std::string cells(static_cast<std::size_t>(last_ - first_ + 1), ' ');
  if (put(cells, cycle, 'I')) rows_.push_back({cells, fmt::format("interrupt {:02X}h", vector)});
}

std::string PipelineDiagram::text() const {
  const auto width = static_cast<std::size_t>(last_ - first_ + 1);
  std::string tens(width, ' '), units(width, ' ');
  for (std::size_t i = 0; i < width; ++i) {
    const Cycles cycle = first_ + static_cast<Cycles>(i);
    units[i] = static_cast<char>('0' + cycle % 10);
    if (cycle % 10 != 0 && i != 0) continue;
    const std::string number = fmt::format("{}", cycle);
    if (i + number.size() <= width && (i == 0 || tens[i - 1] == ' ')) tens.replace(i, number.size(), number);
  }
  std::string out = fmt::format("pipeline, cycles {} to {} (F fetch, D decode, R read, E execute, - holds, b shared bus, I interrupt)\n", first_, last_);
  out += fmt::format("{}\n{}\n", tens, units);
  for (const Row& row : rows_) out += fmt::format("{}  {}\n", row.cells, row.label);
  return out;
}

}  // namespace c40

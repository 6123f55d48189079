// One instruction's row of the pipeline diagram, drawn by hand.
#include "c40/pipeline/pipeline_diagram.hpp"

#include <doctest/doctest.h>

#include <initializer_list>
#include <string>
#include <utility>

namespace {

/// The 15 cells from `first` on: the instruction is fetched two cycles later; it executes so many cycles later.
std::string cells(std::int16_t execute, std::initializer_list<std::pair<c40::Cause, c40::Cycles>> causes,
                  c40::Cycles first = 0) {
  c40::PipelineDiagram diagram(first, first + 14, [](c40::Address, c40::Word) { return std::string("nop"); });
  c40::TraceRecord record;
  record.cycle = first + 2;
  record.stages = {0, 1, 1, 2, execute};
  for (const auto& [cause, cycles] : causes) record.causes[static_cast<std::size_t>(cause)] = cycles;
  diagram.instruction(record);
  const std::string text = diagram.text();
  const std::size_t row = text.rfind('\n', text.size() - 2) + 1;
  return text.substr(row, 15);
}

}  // namespace

TEST_CASE("waits stand where they are: for what is outside before the execution, for the DMA within the stages") {
  using enum c40::Cause;
  CHECK(cells(3, {}) == "  FDRE         ");
  CHECK(cells(3, {}, 1000) == "  FDRE         ");
  CHECK(cells(5, {{register_conflict, 2}}) == "  FDRRRE       ");
  CHECK(cells(3, {{comm_port, 3}}) == "  FDRpppE      ");
  CHECK(cells(3, {{bus_arbitration, 1}, {bus_transfer, 2}, {comm_port, 1}}) == "  FDRpbbbE     ");
  CHECK(cells(5, {{dma_conflict, 2}}) == "  FDRddE       ");
  CHECK(cells(4, {{dma_conflict, 1}, {bus_transfer, 2}}) == "  FDRdbbE      ");
}

TEST_CASE("numbers of ten digits, which are as long as the distance between two of them, alternate between two lines") {
  const c40::PipelineDiagram diagram(1'000'000'000, 1'000'000'030, [](c40::Address, c40::Word) { return ""; });
  const std::string text = diagram.text();
  CHECK(text.substr(text.find('\n') + 1) ==
        "1000000000          1000000020\n"
        "          1000000010          1000000030\n"
        "0123456789012345678901234567890\n");
}

#pragma once
/// The pipeline as in the manual's figures: one line per instruction, one column per cycle, each stall with its letter.
#include <functional>
#include <string>
#include <vector>

#include "c40/chip/chip.hpp"

namespace c40 {

class PipelineDiagram final : public TraceSink {
 public:
  static constexpr Cycles widest = 200;

  /// The cycles from first to last. Throws std::invalid_argument if there are none, or more than `widest`.
  /// \param text of the instruction at an address, from its word. \param next gets everything too; may be null and must
  /// outlive this object.
  PipelineDiagram(Cycles first, Cycles last, std::function<std::string(Address, Word)> text, TraceSink* next = nullptr);

  void instruction(const TraceRecord& record) override;
  void interrupt(const InterruptRecord& record) override;

  /// F fetch, D decode, R read, E execute; `-` extends the stage before it; `p`, `b` and `d` wait for a port, a shared
  /// bus and the DMA.
  std::string text() const;

 private:
  struct Row {
    std::string cells, label;
  };
  bool put(std::string& cells, Cycles cycle, char letter) const;
  std::vector<std::string> ruler() const;

  Cycles first_, last_;
  std::function<std::string(Address, Word)> text_;
  TraceSink* next_;
  std::vector<Row> rows_;
};

}  // namespace c40

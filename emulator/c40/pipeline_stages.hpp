#pragma once
/// What the pipeline model tells of one instruction to those who trace it.
#include <cstdint>

namespace c40 {

/// The cycle in which the instruction stood in each stage, and how many its fetch took.
struct PipelineStages {
  std::int16_t fetch = 0, fetch_cycles = 0, decode = 0, read = 0, execute = 0;
  friend bool operator==(const PipelineStages&, const PipelineStages&) = default;
};

}  // namespace c40

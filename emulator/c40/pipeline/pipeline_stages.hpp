#pragma once
/// The pipeline model's stages of one instruction, for traces.
#include <cstdint>

namespace c40 {

/// The cycle of the instruction in each stage, and the number of cycles of its fetch.
struct PipelineStages {
  std::int16_t fetch = 0, fetch_cycles = 0, decode = 0, read = 0, execute = 0;
  friend bool operator==(const PipelineStages&, const PipelineStages&) = default;
};

}  // namespace c40

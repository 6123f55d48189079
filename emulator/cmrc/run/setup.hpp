#pragma once
// Makes the parts of a run from the configuration.
#include <vector>

#include "cmrc/configuration/config.hpp"
#include "cmrc/processes/crane_steps.hpp"
#include "cmrc/processes/fleet.hpp"
#include "cmrc/tasks/words.hpp"
#include "machine/system/machine_config.hpp"
#include "plant/dock/dock.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// With clock deviations if run.phase_jitter is set (clock_deviations.hpp).
/// \param image and `words` of the DSPs' program
/// \throws ConfigError for a dock that cannot be, or in which the controller cannot do its job (dock_job.hpp)
plant::DockConfig dock_of(const Config& config, const toolchain::Image& image, const Words& words);
/// \param dock at power-on
CraneJob crane_of(const Config& config, const plant::DockConfig& layout, plant::Dock& dock);
FleetJob fleet_of(const Config& config, const plant::DockConfig& dock, const Words& words);
/// \throws machine::BoardError
machine::Config machine_of(const Config& config);

/// A word of a job area that the operator loads before the start.
struct AreaWord {
  Word offset;
  Word value;
};
std::vector<AreaWord> initial_words(const Config& config, const plant::DockConfig& layout, const Words& words,
                                    plant::Dock& dock);

}  // namespace cmrc

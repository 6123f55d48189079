#pragma once
// The plant's parameters in the DSPs' programs: crane, drives and vehicles, written into the image when it is loaded.
#include "plant/parameters/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// Writes the words of c40_programs/kernels/plant_constants.asm, K_GRAVITY, K_ONE_OVER_G and K_ID_QUANTUM, the plant's
/// rows of K_NE_TABLE and K_PD_JOINTS, and for a gantry gantry_masses and gantry_limits, as TI single floats.
/// \param container_mass kg, the load of a vehicle or the crane
/// \throws ConfigError if the image lacks one of these labels, or its numbers differ from the devices'
void place_plant_constants(toolchain::Image& image, const plant::DockConfig& dock, double container_mass);

}  // namespace cmrc

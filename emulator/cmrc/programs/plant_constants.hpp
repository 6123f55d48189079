#pragma once
// What the DSPs' programs know of crane, drives and vehicles: the plant's own parameters, put into the image when it is
// loaded.
#include "plant/parameters/config.hpp"
#include "toolchain/objects/image.hpp"

namespace cmrc {

/// Writes the words of c40_programs/kernels/plant_constants.asm, K_GRAVITY, K_ONE_OVER_G and K_ID_QUANTUM, the rows of
/// K_NE_TABLE and K_PD_JOINTS that are the plant's, and of a gantry gantry_masses and gantry_limits, as TI single
/// floats.
/// \param container_mass kg, of what a vehicle or the crane carries
/// \throws ConfigError when the image lacks one of these labels, or has other numbers than the devices
void place_plant_constants(toolchain::Image& image, const plant::DockConfig& dock, double container_mass);

}  // namespace cmrc

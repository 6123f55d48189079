#pragma once
// Numbers that the dock's devices and the DSP programs both have (plant/parameters/device_codes.hpp,
// c40_programs/include/devices.inc): who builds a dock and who programs its controller each need them. They are
// compared when a program is loaded.
#include <optional>
#include <string>

namespace toolchain {
struct Image;
}

namespace machine {

/// Where the program contradicts the devices: each number, what it is and what it should be. None: nowhere. A number
/// that the program does not define contradicts nothing.
std::optional<std::string> contradiction(const toolchain::Image& program);

}  // namespace machine

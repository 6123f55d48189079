#pragma once
// Numbers that both the dock's devices and the DSP programs have (plant/parameters/device_codes.hpp,
// c40_programs/include/devices.inc). The builder of a dock and the programmer of its controller both need them. They
// are compared when a program is loaded.
#include <optional>
#include <string>

namespace toolchain {
struct Image;
}

namespace machine {

/// The differences between the program and the devices: each number, its value and the right value; none: there is no
/// difference. A number that the program does not define is not a difference.
std::optional<std::string> contradiction(const toolchain::Image& program);

}  // namespace machine

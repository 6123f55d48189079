// Peripheral registers, and the streams that the boot loader takes.
#include <pybind11/stl.h>

#include <string>

#include "c40/peripherals/register_map.hpp"
#include "machine/chips/boot.hpp"
#include "python/bindings/c40.hpp"
#include "toolchain/objects/image.hpp"

using c40::Word;

void bind_registers(py::module_& m) {
  m.def(
      "boot_stream",
      [](const toolchain::Image& image, Word ivtp, Word tvtp, c40::Address acknowledge, bool memory) {
        const machine::BootHeader header{0x3E39FFF0u, 0x3E39FFF0u, ivtp, tvtp, acknowledge};
        return memory ? machine::boot_memory(image, header) : machine::boot_stream(image, header);
      },
      py::arg("image"), py::arg("ivtp") = 0, py::arg("tvtp") = 0, py::arg("acknowledge") = 0x2FF800,
      py::arg("memory") = false, "The words that the boot loader takes, from a port or from memory of 32 bits.");
  m.def("register_page", &c40::register_page, "The register tables of docs/peripherals.md.");
  m.def(
      "peripheral_registers",
      [] {
        py::list all;
        for (const c40::RegisterInfo& info : c40::register_map()) {
          py::dict fields;
          for (const c40::Field& field : info.fields)
            fields[py::str(std::string(field.name))] = py::make_tuple(field.low, field.width);
          all.append(py::dict(py::arg("name") = info.name, py::arg("address") = info.address,
                              py::arg("reset") = info.reset, py::arg("fields") = fields,
                              py::arg("meaning") = std::string(info.meaning)));
        }
        return all;
      },
      "Every memory-mapped register: name, address, value after reset, fields (lowest bit, width).");
}

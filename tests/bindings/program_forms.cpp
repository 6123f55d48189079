// Programs in other forms: objects as the bytes of a file, images as the words that the boot loader takes.
#include <pybind11/stl.h>

#include <span>
#include <string>
#include <string_view>

#include "machine/chips/boot.hpp"
#include "tests/bindings/bindings.hpp"
#include "toolchain/objects/coff.hpp"
#include "toolchain/objects/image.hpp"

void bind_program_forms(py::module_& test) {
  py::module_ m = test.def_submodule("forms", "Programs in other forms.");
  m.def(
      "read_object",
      [](const py::bytes& bytes, const std::string& name) {
        const auto view = static_cast<std::string_view>(bytes);
        return toolchain::read_object(std::as_bytes(std::span(view)), name);
      },
      py::arg("bytes"), py::arg("name") = "<bytes>", "Takes a COFF file of any kind apart. Raises CoffError.");
  m.def(
      "object_bytes",
      [](toolchain::Object object, int version) {
        object.version = version;
        const auto bytes = toolchain::coff_bytes(object);
        return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      },
      py::arg("object"), py::arg("version") = 2, "The bytes of a COFF file of this version.");
  m.def(
      "boot_stream",
      [](const toolchain::Image& image, c40::Word ivtp, c40::Word tvtp, c40::Address acknowledge, bool memory) {
        const machine::BootHeader header{0x3E39FFF0u, 0x3E39FFF0u, ivtp, tvtp, acknowledge};
        return memory ? machine::boot_memory(image, header) : machine::boot_stream(image, header);
      },
      py::arg("image"), py::arg("ivtp") = 0, py::arg("tvtp") = 0, py::arg("acknowledge") = 0x2FF800,
      py::arg("memory") = false, "The words that the boot loader takes, from a port or from memory of 32 bits.");
}

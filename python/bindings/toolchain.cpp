#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstdint>
#include <string>
#include <vector>

#include "python/bindings/bindings.hpp"
#include "python/bindings/cpu.hpp"
#include "python/bindings/interpreter/ctrl_c.hpp"
#include "python/bindings/interpreter/errors.hpp"
#include "python/bindings/interpreter/warnings.hpp"
#include "toolchain/assembler/assembler.hpp"
#include "toolchain/linker/linker.hpp"
#include "toolchain/objects/coff.hpp"
#include "toolchain/objects/rom_file.hpp"
#include "toolchain/syntax/float_format.hpp"

namespace {

using toolchain::Image;

/// Keeps the diagnostics on the Python exception: AssemblyError.diagnostics is a list of dicts.
void raise_assembly_error(const py::handle& type, const toolchain::AssemblyError& error) {
  py::list diagnostics;
  for (const toolchain::Diagnostic& d : error.diagnostics()) {
    py::dict entry;
    entry["file"] = d.file;
    entry["line"] = d.line;
    entry["column"] = d.column;
    entry["message"] = python::shown(d.message);
    entry["text"] = python::shown(d.text);
    py::list notes;
    for (const std::string& note : d.notes) notes.append(python::shown(note));
    entry["notes"] = notes;
    diagnostics.append(entry);
  }
  py::object exception = type(python::shown(error.what()));
  exception.attr("diagnostics") = diagnostics;
  PyErr_SetObject(type.ptr(), exception.ptr());
}

toolchain::Options make_options(std::vector<std::filesystem::path> include_dirs,
                                std::map<std::string, toolchain::Word> symbols,
                                const std::map<std::string, toolchain::Address>& sections, std::string entry,
                                const std::optional<std::string>& dialect, const std::string& cpu) {
  toolchain::Options options;
  options.cpu = cpu_called(cpu);
  if (dialect) {
    options.dialect = toolchain::dialect_named(*dialect);
    if (!options.dialect)
      throw py::value_error("dialect: \"" + *dialect + "\" is unknown; \"ti\" or \"gnu\" is expected");
  }
  options.include_dirs = std::move(include_dirs);
  options.symbols = std::move(symbols);
  for (const auto& [name, address] : sections) options.sections[name] = address;
  options.entry = std::move(entry);
  return options;
}

}  // namespace

void bind_toolchain(py::module_& core) {
  py::module_ m = core.def_submodule("toolchain", "Assembler and COFF files of the TMS320C4x.");
  bind_programs(m);

  // It lives as long as the module, which is never unloaded.
  static const py::handle assembly_error =
      py::exception<toolchain::AssemblyError>(m, "AssemblyError", python::error_bases(PyExc_ValueError)).release();
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const toolchain::AssemblyError& error) {
      raise_assembly_error(assembly_error, error);
    }
  });
  python::register_error<toolchain::CoffError>(m, "CoffError", PyExc_ValueError);
  python::register_error<toolchain::LinkError>(m, "LinkError", PyExc_ValueError);
  python::register_error<toolchain::RomError>(m, "RomError", PyExc_ValueError);
  m.def(
      "rom_words",
      [](const std::filesystem::path& path, std::optional<unsigned> width) {
        const std::vector<std::uint8_t> bytes = toolchain::read_rom(path);
        std::vector<toolchain::Word> words = toolchain::rom_words_of(path, bytes, width, "width");
        if (const std::string warning = toolchain::width_contradiction(bytes, width, "width"); !warning.empty())
          python::warn(fmt::format("{}: {}", path.string(), warning));
        return words;
      },
      py::arg("path"), py::arg("width") = py::none(), "What an EPROM holds, as memory of that width has it.");
  python::register_error<toolchain::MemoryMapError>(m, "MemoryMapError", PyExc_ValueError);

  m.def(
      "assemble",
      [](const std::string& text, const std::string& name, std::vector<std::filesystem::path> include_dirs,
         std::map<std::string, toolchain::Word> symbols, const std::map<std::string, toolchain::Address>& sections,
         std::string entry, const std::optional<std::string>& dialect, const std::string& cpu) {
        const auto options =
            make_options(std::move(include_dirs), std::move(symbols), sections, std::move(entry), dialect, cpu);
        return interruptible_without_gil([&] { return toolchain::assemble_text(text, name, options); });
      },
      py::arg("text"), py::arg("name") = "<text>", py::arg("include_dirs") = std::vector<std::filesystem::path>(),
      py::arg("symbols") = std::map<std::string, toolchain::Word>(),
      py::arg("sections") = std::map<std::string, toolchain::Address>(), py::arg("entry") = "",
      py::arg("dialect") = py::none(), py::arg("cpu") = "c40",
      "Assembles a text (docs/assembler.md). Raises AssemblyError with all errors; its `diagnostics` is a list of "
      "dicts.");
  m.def(
      "assemble_file",
      [](const std::filesystem::path& path, std::vector<std::filesystem::path> include_dirs,
         std::map<std::string, toolchain::Word> symbols, const std::map<std::string, toolchain::Address>& sections,
         std::string entry, const std::optional<std::string>& dialect, const std::string& cpu) {
        const auto options =
            make_options(std::move(include_dirs), std::move(symbols), sections, std::move(entry), dialect, cpu);
        return interruptible_without_gil([&] { return toolchain::assemble_file(path, options); });
      },
      py::arg("path"), py::arg("include_dirs") = std::vector<std::filesystem::path>(),
      py::arg("symbols") = std::map<std::string, toolchain::Word>(),
      py::arg("sections") = std::map<std::string, toolchain::Address>(), py::arg("entry") = "",
      py::arg("dialect") = py::none(), py::arg("cpu") = "c40",
      "Assembles a file. Raises AssemblyError with all errors.");
  m.def(
      "assemble_object",
      [](const std::string& text, const std::string& name, std::vector<std::filesystem::path> include_dirs,
         const std::optional<std::string>& dialect, const std::string& cpu) {
        const auto options = make_options(std::move(include_dirs), {}, {}, {}, dialect, cpu);
        return interruptible_without_gil([&] { return toolchain::assemble_object_text(text, name, options).object; });
      },
      py::arg("text"), py::arg("name") = "<text>", py::arg("include_dirs") = std::vector<std::filesystem::path>(),
      py::arg("dialect") = py::none(), py::arg("cpu") = "c40",
      "Assembles a text to a relocatable object. Raises AssemblyError.");
  m.def(
      "link",
      [](std::vector<toolchain::Object> objects, const std::vector<toolchain::Object>& library,
         const std::string& map) {
        const auto memory_map =
            map.empty() ? toolchain::MemoryMap::standard() : toolchain::parse_memory_map(map, "<map>");
        auto linked = toolchain::link(std::move(objects), library, memory_map);
        return std::pair(std::move(linked.image), std::move(linked.map));
      },
      py::arg("objects"), py::arg("library") = std::vector<toolchain::Object>(), py::arg("map") = "",
      "Links objects by a memory map (TOML, docs/assembler.md); gives the image and the map as text. Raises "
      "LinkError.");
  m.def(
      "read_coff", [](const std::filesystem::path& path) { return toolchain::read_coff(path); }, py::arg("path"),
      "Reads a COFF executable of version 0, 1 or 2. Raises CoffError.");
  m.def(
      "read_coff_bytes",
      [](const py::bytes& bytes) {
        const auto view = static_cast<std::string_view>(bytes);
        return toolchain::read_coff(std::as_bytes(std::span(view)));
      },
      py::arg("bytes"), "Reads a COFF executable held in memory. Raises CoffError.");
  m.def("write_coff", py::overload_cast<const Image&, const std::filesystem::path&>(&toolchain::write_coff),
        py::arg("image"), py::arg("path"), "Writes a COFF version-2 executable with all symbols.");
  m.def(
      "single",
      [](const std::string& text) -> std::optional<toolchain::Word> {
        const auto real = toolchain::parse_real(text);
        return real ? toolchain::to_single(*real) : std::nullopt;
      },
      py::arg("text"), "The 32-bit TI float nearest to a decimal number, or None if out of range.");
}

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <memory>
#include <string>

#include "python/bindings/bindings.hpp"
#include "toolchain/assembler.hpp"
#include "toolchain/coff.hpp"
#include "toolchain/float_format.hpp"

namespace {

using toolchain::Image;

/// Sources may hold any bytes, in comments for instance.
py::str as_str(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"));
}

/// Keeps the diagnostics on the Python exception: AssemblyError.diagnostics is a list of dicts.
void raise_assembly_error(const py::handle& type, const toolchain::AssemblyError& error) {
  py::list diagnostics;
  for (const toolchain::Diagnostic& d : error.diagnostics()) {
    py::dict entry;
    entry["file"] = d.file;
    entry["line"] = d.line;
    entry["column"] = d.column;
    entry["message"] = as_str(d.message);
    entry["text"] = as_str(d.text);
    py::list notes;
    for (const std::string& note : d.notes) notes.append(as_str(note));
    entry["notes"] = notes;
    diagnostics.append(entry);
  }
  py::object exception = type(as_str(error.what()));
  exception.attr("diagnostics") = diagnostics;
  PyErr_SetObject(type.ptr(), exception.ptr());
}

toolchain::Options make_options(std::vector<std::filesystem::path> include_dirs,
                                std::map<std::string, toolchain::Word> symbols,
                                const std::map<std::string, toolchain::Address>& sections, std::string entry) {
  toolchain::Options options;
  options.include_dirs = std::move(include_dirs);
  options.symbols = std::move(symbols);
  for (const auto& [name, address] : sections) options.sections[name] = address;
  options.entry = std::move(entry);
  return options;
}

void bind_image(py::module_& m) {
  py::class_<Image::Section>(m, "Section")
      .def_readonly("name", &Image::Section::name)
      .def_readonly("address", &Image::Section::address)
      .def_readonly("size", &Image::Section::size, "In words.")
      .def_readonly("words", &Image::Section::words, "Empty if the section is not loaded.")
      .def_readonly("loaded", &Image::Section::loaded);
  py::class_<toolchain::LineRecord>(m, "LineRecord")
      .def_readonly("address", &toolchain::LineRecord::address)
      .def_readonly("file", &toolchain::LineRecord::file, "Index into Image.files.")
      .def_readonly("line", &toolchain::LineRecord::line)
      .def_property_readonly("text", [](const toolchain::LineRecord& record) { return as_str(record.text); });
  py::class_<Image>(m, "Image", "A program with its addresses settled.")
      .def_readonly("sections", &Image::sections)
      .def_readonly("symbols", &Image::symbols, "Labels and constants by name, as 32-bit words.")
      .def_readonly("entry", &Image::entry)
      .def_readonly("files", &Image::files)
      .def_readonly("lines", &Image::lines)
      .def_property_readonly("warnings",
                             [](const Image& image) {
                               py::list out;
                               for (const std::string& warning : image.warnings) out.append(as_str(warning));
                               return out;
                             })
      .def("listing", [](const Image& image) { return as_str(toolchain::listing(image)); });
}

}  // namespace

void bind_toolchain(py::module_& core) {
  py::module_ m = core.def_submodule("toolchain", "Assembler and COFF files of the TMS320C4x.");
  bind_image(m);

  // The exception types live as long as the module, which is never unloaded.
  static py::object assembly_error = py::exception<toolchain::AssemblyError>(m, "AssemblyError", PyExc_ValueError);
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const toolchain::AssemblyError& error) {
      raise_assembly_error(assembly_error, error);
    }
  });
  py::register_exception<toolchain::CoffError>(m, "CoffError", PyExc_ValueError);

  m.def(
      "assemble",
      [](const std::string& text, const std::string& name, std::vector<std::filesystem::path> include_dirs,
         std::map<std::string, toolchain::Word> symbols, const std::map<std::string, toolchain::Address>& sections,
         std::string entry) {
        const auto options = make_options(std::move(include_dirs), std::move(symbols), sections, std::move(entry));
        py::gil_scoped_release release;
        return toolchain::assemble_text(text, name, options);
      },
      py::arg("text"), py::arg("name") = "<text>", py::arg("include_dirs") = std::vector<std::filesystem::path>(),
      py::arg("symbols") = std::map<std::string, toolchain::Word>(),
      py::arg("sections") = std::map<std::string, toolchain::Address>(), py::arg("entry") = "",
      "Assembles a text (docs/assembler.md). Raises AssemblyError with all errors; its `diagnostics` is a list of "
      "dicts.");
  m.def(
      "assemble_file",
      [](const std::filesystem::path& path, std::vector<std::filesystem::path> include_dirs,
         std::map<std::string, toolchain::Word> symbols, const std::map<std::string, toolchain::Address>& sections,
         std::string entry) {
        const auto options = make_options(std::move(include_dirs), std::move(symbols), sections, std::move(entry));
        py::gil_scoped_release release;
        return toolchain::assemble_file(path, options);
      },
      py::arg("path"), py::arg("include_dirs") = std::vector<std::filesystem::path>(),
      py::arg("symbols") = std::map<std::string, toolchain::Word>(),
      py::arg("sections") = std::map<std::string, toolchain::Address>(), py::arg("entry") = "",
      "Assembles a file. Raises AssemblyError with all errors.");
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
  m.def("write_coff", &toolchain::write_coff, py::arg("image"), py::arg("path"),
        "Writes a COFF version-2 executable with all symbols.");
  m.def(
      "single",
      [](const std::string& text) -> std::optional<toolchain::Word> {
        const auto real = toolchain::parse_real(text);
        return real ? toolchain::to_single(*real) : std::nullopt;
      },
      py::arg("text"), "The 32-bit TI float nearest to a decimal number, or None if out of range.");
}

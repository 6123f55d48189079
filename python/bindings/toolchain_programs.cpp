// Programs and objects, taken apart.
#include <pybind11/stl.h>

#include <string>

#include "isa/types.hpp"
#include "python/bindings/bindings.hpp"
#include "toolchain/assembler/assembler.hpp"
#include "toolchain/objects/object.hpp"

namespace {

using toolchain::Image;

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
      .def_property_readonly("text", [](const toolchain::LineRecord& record) { return python::shown(record.text); });
  py::class_<Image>(m, "Image", "A program with its addresses settled.")
      .def_readonly("sections", &Image::sections)
      .def_readonly("symbols", &Image::symbols, "Labels and constants by name, as 32-bit words.")
      .def_readonly("entry", &Image::entry)
      .def_property_readonly(
          "cpu", [](const Image& image) { return std::string(isa::name(image.cpu)); }, "`c40` or `c3x`.")
      .def_readonly("files", &Image::files)
      .def_readonly("lines", &Image::lines)
      .def_property_readonly("warnings",
                             [](const Image& image) {
                               py::list out;
                               for (const std::string& warning : image.warnings) out.append(python::shown(warning));
                               return out;
                             })
      .def_readonly("dialects", &Image::dialects, "How the source was read, and why: `ti: the default`.")
      .def("listing", [](const Image& image) { return python::shown(toolchain::listing(image)); });
}

void bind_object(py::module_& m) {
  using namespace toolchain;
  py::class_<Relocation>(m, "Relocation")
      .def_readonly("offset", &Relocation::offset)
      .def_property_readonly("type", [](const Relocation& r) { return std::string(name(r.type)); })
      .def_readonly("symbol", &Relocation::symbol, "Index into Object.symbols, or -1: the section itself.")
      .def_readonly("low", &Relocation::low);
  py::class_<ObjectSymbol>(m, "ObjectSymbol")
      .def_readonly("name", &ObjectSymbol::name)
      .def_readonly("value", &ObjectSymbol::value)
      .def_readonly("section", &ObjectSymbol::section, "Index into Object.sections, -1: absolute, -2: undefined.")
      .def_property_readonly("is_global", [](const ObjectSymbol& s) { return s.global; });
  py::class_<ObjectSection>(m, "ObjectSection")
      .def_readonly("name", &ObjectSection::name)
      .def_readonly("address", &ObjectSection::address)
      .def_readonly("size", &ObjectSection::size)
      .def_readonly("words", &ObjectSection::words)
      .def_readonly("loaded", &ObjectSection::loaded)
      .def_readonly("alignment", &ObjectSection::alignment)
      .def_readonly("blocked", &ObjectSection::blocked)
      .def_readonly("relocations", &ObjectSection::relocations);
  py::class_<Object>(m, "Object", "A COFF file taken apart.")
      .def_readonly("name", &Object::name)
      .def_readonly("version", &Object::version)
      .def_property_readonly("cpu", [](const Object& object) { return std::string(isa::name(object.cpu)); })
      .def_readonly("executable", &Object::executable)
      .def_readonly("sections", &Object::sections)
      .def_readonly("symbols", &Object::symbols);
}

}  // namespace

void bind_programs(py::module_& m) {
  bind_image(m);
  bind_object(m);
}

#include "python/bindings/bindings.hpp"
#include "python/bindings/interpreter/without_gil.hpp"

namespace {

/// Pickle's protocols 0 and 1 call the base class of all bound classes with the object as its argument. pybind11 then
/// throws a C++ exception through Python's C code, which ends the process.
PyObject* no_object_of_the_base(PyTypeObject* type, PyObject* arguments, PyObject* keywords) {
  PyObject* base = py::detail::get_internals().instance_base;
  if (type != reinterpret_cast<PyTypeObject*>(base)) return py::detail::pybind11_object_new(type, arguments, keywords);
  const bool copied = PyTuple_GET_SIZE(arguments) == 1;
  return PyErr_Format(PyExc_TypeError, "cannot %s '%s' object", copied ? "pickle" : "make",
                      copied ? Py_TYPE(PyTuple_GET_ITEM(arguments, 0))->tp_name : type->tp_name);
}

/// What `X.__new__(X)` gives has no C++ object. pybind11 would allocate one, without a constructor, at its first use.
void refuse_objects_without_init(const py::module_& core) {
  const std::string module = core.attr("__name__").cast<std::string>();
  for (const auto& [type, info] : py::detail::get_internals().registered_types_cpp) {
    const auto home = py::handle(reinterpret_cast<PyObject*>(info->type)).attr("__module__").cast<std::string>();
    if (home.starts_with(module))
      info->operator_new = [](std::size_t) -> void* {
        throw py::type_error("an object whose __init__ was not called");
      };
  }
}

void raise(PyObject* type, const std::exception& error) { PyErr_SetObject(type, python::shown(error.what()).ptr()); }

/// What pybind11 translates itself, if only the message is UTF-8.
void translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const py::value_error& error) {
    raise(PyExc_ValueError, error);
  } catch (const py::type_error& error) {
    raise(PyExc_TypeError, error);
  } catch (const std::invalid_argument& error) {
    raise(PyExc_ValueError, error);
  }
}

}  // namespace

PYBIND11_MODULE(_core, core) {
  reinterpret_cast<PyTypeObject*>(py::detail::get_internals().instance_base)->tp_new = no_object_of_the_base;
  py::register_exception_translator(translate);  // the first one is tried last
  core.doc() = "The emulator's C++ core. Use the package cmrc; this module is its private part.";
  bind_io(core);
  bind_report(core);
  bind_isa(core);
  bind_toolchain(core);
  bind_c40(core);
  bind_plant(core);
  bind_debug(core);
  bind_network(core);
  bind_cmrc(core);
  bind_why_late(core);
  bind_trace(core);
  refuse_objects_without_init(core);
  await_threads_at_the_end_of_python();
}

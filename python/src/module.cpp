#include <exception>
#include <string>

#include <glog/logging.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl/filesystem.h>

#include "rooms.h"
#include "samara/base/errors.h"
#include "samara/base/units.h"
#include "samara/base/version.h"
#include "samara/io/atomic_file.h"

namespace samara::python {

namespace py = pybind11;

namespace {

/// The class of samara._errors of that name, with the sentence in words of Python. Modules that were imported are kept
/// by the interpreter.
void raise(const char* name, const std::exception& error) {
  const py::module_ errors = py::module_::import("samara._errors");
  const py::object sentence = errors.attr("in_words_of_python")(error.what());
  PyErr_SetObject(errors.attr(name).ptr(), sentence.ptr());
}

/// The family of base/errors.h as that of samara._errors, which are Python's own kinds as well.
void translate(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const OutsideBoxError& error) {
    raise("OutsideBoxError", error);
  } catch (const ArgumentError& error) {
    raise("ArgumentError", error);
  } catch (const InputError& error) {
    raise("InputError", error);
  } catch (const NoResultError& error) {
    raise("NoResultError", error);
  } catch (const Error& error) {
    raise("Error", error);
  }
}

double si(const std::string& text, const std::string& unit) {
  return quantity_to_si(text, unit);
}

double difference_si(const std::string& text, const std::string& unit) {
  return difference_to_si(text, unit);
}

/// The unit of SI symbols with the dimension of another one.
std::string si_unit(const std::string& unit) {
  return to_string(parse_unit(unit).dimension);
}

}  // namespace

}  // namespace samara::python

PYBIND11_MODULE(_core, module) {
  using namespace samara::python;
  // Ceres reports through glog, which would print its own lines; results carry the same in a sentence.
  FLAGS_minloglevel = google::GLOG_FATAL;
  py::register_local_exception_translator(translate);
  module.attr("__version__") = samara::version();
  module.def("write_text", &samara::io::write_text_atomically, py::arg("path"), py::arg("text"));
  module.def("require_name_of_format", &samara::io::require_name_of_format, py::arg("path"),
             py::arg("ending"));
  module.def("si", &si, py::arg("text"), py::arg("unit"));
  module.def("difference_si", &difference_si, py::arg("text"), py::arg("unit"));
  module.def("si_unit", &si_unit, py::arg("unit"));
  add_codebooks(module);
  add_models(module);
  add_sampling(module);
  add_identification(module);
  add_motion(module);
  add_bodies(module);
  add_flows(module);
}

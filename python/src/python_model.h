#pragma once

#include <memory>

#include <pybind11/pybind11.h>

#include "calls.h"
#include "samara/models/interface/model.h"

namespace samara::python {

/// A model by what Python calls it: a name or a file (a str), or a samara.Model, whose functions are called from any
/// thread with the interpreter's lock. What they raise is kept in `failure`, and the library gets an exception in its
/// place.
/// @throws ArgumentError, InputError as codebooks::open_model(), and where the model's name is one of the library's
std::shared_ptr<const models::Model> model_of(const py::object& model,
                                              const std::shared_ptr<Failure>& failure);

}  // namespace samara::python

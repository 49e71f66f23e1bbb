#pragma once

#include <pybind11/pybind11.h>

/// What the extension module is made of: a file for each room of the library.
namespace samara::python {

void add_codebooks(pybind11::module_& module);
void add_models(pybind11::module_& module);
void add_sampling(pybind11::module_& module);
void add_identification(pybind11::module_& module);
void add_motion(pybind11::module_& module);
void add_bodies(pybind11::module_& module);
void add_flows(pybind11::module_& module);

}  // namespace samara::python

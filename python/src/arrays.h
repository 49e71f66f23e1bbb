#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

/// Arrays that go in and out without a copy. A C-ordered NumPy array of (points, coordinates) is in memory what Eigen
/// has as a matrix of coordinates x points.
namespace samara::python {

namespace py = pybind11;

/// Doubles in C order: an array that is so already is taken as it is, another one is converted.
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Shape = std::vector<py::ssize_t>;
using ConstColumns = Eigen::Map<const Eigen::MatrixXd>;
using Columns = Eigen::Map<Eigen::MatrixXd>;

/// "(3, 4)"
std::string shape_text(const Shape& shape);
Shape shape_of(const py::array& array);

/// The shape without the last dimension, which must be of `size`.
/// @throws ArgumentError naming `what`
Shape leading_shape(const py::array& array, py::ssize_t size, const std::string& what);

/// What is written to: a new array, or the one that the caller brought.
/// @throws ArgumentError unless that has the shape, holds doubles in C order and may be written
py::array_t<double> room_for(const Shape& shape, const py::object& out);

/// A copy, in C order, of Eigen's.
py::array_t<double> copied(const Eigen::VectorXd& values);
py::array_t<double> copied(const Eigen::MatrixXd& values);

/// A read-only view on memory that `owner` keeps.
py::array view(const double* data, const Shape& shape, const Shape& strides_in_numbers,
               const py::handle& owner);

}  // namespace samara::python

#include "arrays.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"

namespace samara::python {

std::string shape_text(const Shape& shape) {
  return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

Shape shape_of(const py::array& array) {
  return {array.shape(), array.shape() + array.ndim()};
}

Shape leading_shape(const py::array& array, py::ssize_t size, const std::string& what) {
  Shape shape = shape_of(array);
  if (shape.empty() || shape.back() != size)
    throw ArgumentError(
        fmt::format("{} have the shape {}, expected (.., {})", what, shape_text(shape), size));
  shape.pop_back();
  return shape;
}

py::array_t<double> room_for(const Shape& shape, const py::object& out) {
  if (out.is_none()) return py::array_t<double>(shape);
  if (!py::isinstance<py::array_t<double>>(out)) throw ArgumentError("out is no NumPy array of doubles");
  auto array = py::reinterpret_borrow<py::array_t<double>>(out);
  const bool is_c_ordered = (array.flags() & py::array::c_style) != 0;
  if (shape_of(array) != shape || !is_c_ordered || !array.writeable()) {
    throw ArgumentError(fmt::format("out has the shape {}{}{}, expected a writeable array of {} in C order",
                                    shape_text(shape_of(array)), is_c_ordered ? "" : ", not in C order",
                                    array.writeable() ? "" : ", read-only", shape_text(shape)));
  }
  return array;
}

py::array_t<double> copied(const Eigen::VectorXd& values) {
  return py::array_t<double>(values.size(), values.data());
}

py::array_t<double> copied(const Eigen::MatrixXd& values) {
  py::array_t<double> result({values.rows(), values.cols()});
  Columns(result.mutable_data(), values.cols(), values.rows()) = values.transpose();
  return result;
}

py::array view(const double* data, const Shape& shape, const Shape& strides_in_numbers,
               const py::handle& owner) {
  Shape strides;
  for (const py::ssize_t stride : strides_in_numbers)
    strides.push_back(stride * static_cast<py::ssize_t>(sizeof(double)));
  py::array result(py::dtype::of<double>(), shape, strides, data, owner);
  result.attr("setflags")(py::arg("write") = false);
  return result;
}

}  // namespace samara::python

#include "python_model.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "arrays.h"
#include "samara/base/errors.h"
#include "samara/base/units.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/laws/registry.h"

namespace samara::python {

namespace {

/// Functions of a samara.Model. The last copy may go on any thread.
struct Functions {
  py::object rates;        ///< (t, x, p) -> rates of the states, at one point or at many
  py::object derivatives;  ///< (t, x, p) -> (rates, by states, by parameters), one point
  py::object jacobians;    ///< (t, x, p) -> by states, (states, states, points)
};

std::shared_ptr<const Functions> functions_of(const py::object& model) {
  return {new Functions{model.attr("_rates"), model.attr("_derivatives"), model.attr("_jacobians")},
          [](const Functions* functions) {
            const py::gil_scoped_acquire lock;
            delete functions;
          }};
}

/// @throws ArgumentError unless numbers of the unit may be put into an equation as they are
std::string si_unit_of(const py::handle& item) {
  auto unit = item["unit"].cast<std::string>();
  if (is_coherent_si(unit)) return unit;
  throw ArgumentError(fmt::format("\"{}\" has the unit \"{}\", expected one of the SI, such as \"{}\"",
                                  item["name"].cast<std::string>(), unit,
                                  to_string(parse_unit(unit).dimension)));
}

models::ModelInfo info_of(const py::object& model) {
  const auto description = model.attr("_description").cast<py::dict>();
  models::ModelInfo info;
  const auto text = [&](const char* key) { return description[key].cast<std::string>(); };
  info.name = text("name");
  info.title = text("title");
  info.equations = text("equations");
  info.frames = text("frames");
  info.source = text("source");
  info.validity = text("validity");
  for (const py::handle item : description["states"]) {
    info.states.push_back({.name = item["name"].cast<std::string>(),
                           .unit = si_unit_of(item),
                           .default_initial = item["initial"].cast<double>(),
                           .description = item["description"].cast<std::string>(),
                           .scale = item["scale"].cast<std::optional<double>>()});
  }
  for (const py::handle item : description["parameters"]) {
    info.parameters.push_back({.name = item["name"].cast<std::string>(),
                               .unit = si_unit_of(item),
                               .default_value = item["default"].cast<std::optional<double>>(),
                               .description = item["description"].cast<std::string>(),
                               .lower = item["lower"].cast<double>(),
                               .lower_inclusive = true,
                               .upper = item["upper"].cast<double>()});
  }
  return info;
}

py::array_t<double> array_of(std::span<const double> values) {
  return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

/// Columns of Eigen's are rows of a NumPy array: (points, n) in memory, given as (n, points).
py::array points_first(const double* data, Eigen::Index rows, Eigen::Index columns) {
  py::array_t<double> copy({columns, rows}, data);
  return copy.attr("T").cast<py::array>();
}

class PythonModel final : public models::Model {
 public:
  PythonModel(models::ModelInfo info, std::shared_ptr<const Functions> functions,
              std::shared_ptr<Failure> failure)
      : info_(std::move(info)), functions_(std::move(functions)), failure_(std::move(failure)) {}

  const models::ModelInfo& info() const override { return info_; }

  void rhs(double t, std::span<const double> x, const models::ParameterValues& p,
           std::span<double> dxdt) const override {
    const std::vector<double> all = completed(p);
    guarded([&] { take(functions_->rates(t, array_of(x), array_of(all)), dxdt); });
  }

  void rhs_with_derivatives(double t, std::span<const double> x, const models::ParameterValues& p,
                            std::span<double> dxdt, Eigen::Ref<Eigen::MatrixXd> df_dx,
                            Eigen::Ref<Eigen::MatrixXd> df_dp) const override {
    const std::vector<double> all = completed(p);
    guarded([&] {
      const py::tuple three = functions_->derivatives(t, array_of(x), array_of(all));
      take(three[0], dxdt);
      take(three[1], df_dx);
      take(three[2], df_dp);
    });
    for (std::size_t k = 0; k < p.given.size(); ++k) {
      if (!p.given[k]) df_dp.col(static_cast<Eigen::Index>(k)).setZero();
    }
  }

  void rhs_at_points(const Eigen::Ref<const Eigen::VectorXd>& t, const Eigen::Ref<const Eigen::MatrixXd>& x,
                     const Eigen::Ref<const Eigen::MatrixXd>& p,
                     Eigen::Ref<Eigen::MatrixXd> dxdt) const override {
    guarded([&] { take(at_points(functions_->rates, t, x, p), dxdt); });
  }

  void jacobians_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                           const Eigen::Ref<const Eigen::MatrixXd>& x,
                           const Eigen::Ref<const Eigen::MatrixXd>& p,
                           Eigen::Ref<Eigen::MatrixXd> jacobians) const override {
    const Eigen::Index n = x.rows(), points = x.cols();
    guarded([&] {
      const Array values = array_from(at_points(functions_->jacobians, t, x, p), {n, n, points});
      const double* from = values.data();
      for (Eigen::Index i = 0; i < n; ++i) {
        for (Eigen::Index k = 0; k < n; ++k) {
          for (Eigen::Index j = 0; j < points; ++j) jacobians(i + n * k, j) = from[(i * n + k) * points + j];
        }
      }
    });
  }

  std::vector<double> completed(const models::ParameterValues& p) const override {
    std::vector<double> all(p.value.size());
    complete_into(p, all);
    return all;
  }

  void complete_into(const models::ParameterValues& p, std::span<double> all) const override {
    for (std::size_t k = 0; k < all.size(); ++k)
      all[k] = p.given[k] ? p.value[k] : info_.parameters[k].default_value.value_or(std::nan(""));
  }

  models::Scales scales(const models::ParameterValues&) const override { return {}; }

 private:
  /// With the interpreter's lock. What Python raises is kept.
  template <class Call>
  void guarded(const Call& call) const {
    const py::gil_scoped_acquire lock;
    try {
      call();
      return;
    } catch (...) {
      failure_->keep();
    }
    throw NoResultError(fmt::format("the function of the model \"{}\" raised an exception", info_.name));
  }

  static py::object at_points(const py::object& function, const Eigen::Ref<const Eigen::VectorXd>& t,
                              const Eigen::Ref<const Eigen::MatrixXd>& x,
                              const Eigen::Ref<const Eigen::MatrixXd>& p) {
    const Eigen::MatrixXd states = x, parameters = p;
    return function(copied(Eigen::VectorXd(t)), points_first(states.data(), states.rows(), states.cols()),
                    points_first(parameters.data(), parameters.rows(), parameters.cols()));
  }

  Array array_from(const py::object& result, const Shape& shape) const {
    Array array = Array::ensure(result);
    if (!array) throw py::error_already_set();
    if (shape_of(array) == shape) return array;
    throw ArgumentError(fmt::format("the function of the model \"{}\" gave the shape {}, expected {}",
                                    info_.name, shape_text(shape_of(array)), shape_text(shape)));
  }

  void take(const py::object& result, std::span<double> to) const {
    const Array array = array_from(result, {static_cast<py::ssize_t>(to.size())});
    std::copy_n(array.data(), to.size(), to.begin());
  }

  void take(const py::object& result, Eigen::Ref<Eigen::MatrixXd> to) const {
    const Array array = array_from(result, {to.rows(), to.cols()});
    to = ConstColumns(array.data(), to.cols(), to.rows()).transpose();
  }

  models::ModelInfo info_;
  std::shared_ptr<const Functions> functions_;
  std::shared_ptr<Failure> failure_;
};

}  // namespace

std::shared_ptr<const models::Model> model_of(const py::object& model,
                                              const std::shared_ptr<Failure>& failure) {
  if (py::isinstance<py::str>(model)) return codebooks::open_model(model.cast<std::string>());
  models::ModelInfo info = info_of(model);
  if (models::find_model_or_null(info.name) || models::find_field_model(info.name) != nullptr) {
    throw ArgumentError(
        fmt::format("the name \"{}\" is that of a model of Samara, expected one of its own", info.name));
  }
  return std::make_shared<PythonModel>(std::move(info), functions_of(model), failure);
}

}  // namespace samara::python

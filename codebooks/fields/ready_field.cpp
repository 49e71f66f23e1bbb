#include "samara/codebooks/fields/ready_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/pgd/axes/axis_forms.h"

namespace samara::codebooks {

namespace {

using pgd::Axis;
using pgd::AxisRole;
using pgd::ModeOperator;
using Parts = std::map<std::string, Eigen::VectorXd>;

/// Values of a parameter: over its axis, or one.
class Coefficients {
 public:
  Coefficients(const Plan& plan, const std::vector<Axis>& axes) : plan_(plan), axes_(axes) {}

  /// The axis of the parameter; null if it is fixed.
  const Axis* axis(const std::string& name) const {
    const auto found = std::ranges::find(axes_, name, &Axis::name);
    return found == axes_.end() ? nullptr : &*found;
  }
  double fixed(const std::string& name) const {
    const auto given = plan_.fixed.find(name);
    if (given != plan_.fixed.end()) return given->second;
    return std::ranges::find(plan_.field->info.parameters, name, &models::ParameterInfo::name)
        ->default_value.value();
  }

  /// Powers of parameters * parts of other axes, as a term of the operator
  void add_term(pgd::ParametricProblem& problem, const std::map<std::string, double>& powers,
                std::map<std::string, ModeOperator> parts) const {
    double scale = 1.0;
    for (const auto& [name, power] : powers) {
      const Axis* own = axis(name);
      if (own != nullptr) {
        parts.emplace(name, ModeOperator::diagonal(own->nodes().array().pow(power)));
      } else {
        scale *= std::pow(fixed(name), power);
      }
    }
    problem.add_term(parts, scale);
  }
  /// parameter * nodal values of an axis, as a part of the lift
  void add_to_lift(pgd::ParametricProblem& problem, const std::string& parameter, const std::string& of,
                   const Eigen::VectorXd& values) const {
    Parts parts = {{of, values}};
    const Axis* own = axis(parameter);
    if (own != nullptr) parts.emplace(parameter, own->nodes());
    const double scale = own != nullptr ? 1.0 : fixed(parameter);
    if (scale != 0.0) problem.add_to_lift(parts, scale);
  }

 private:
  const Plan& plan_;
  const std::vector<Axis>& axes_;
};

double lowest_of(const Plan& plan, const std::string& name) {
  const auto entry = std::ranges::find(plan.box, name, &BoxEntry::name);
  return entry != plan.box.end() ? entry->lower : plan.fixed.at(name);
}
double highest_of(const Plan& plan, const std::string& name) {
  const auto entry = std::ranges::find(plan.box, name, &BoxEntry::name);
  return entry != plan.box.end() ? entry->upper : plan.fixed.at(name);
}

/// Nodes on which exp(-c q), for all c that leave something of it at the lower end, is known to the aim. In q it is an
/// exponential of up to ratio * log(1/aim), with that many waves of Chebyshev as the square root tells; in log q it
/// grows beyond the strip of half-width pi/2.
int nodes_for(double ratio, pgd::Transform transform, double aim) {
  const double digits = -std::log(aim);
  if (transform != pgd::Transform::logarithm)
    return 3 + static_cast<int>(std::min(1e6, std::ceil(0.6 * digits * std::sqrt(ratio))));
  const double strip = std::numbers::pi / std::log(ratio);
  return 4 + static_cast<int>(std::ceil(digits / std::asinh(strip)));
}

Axis parameter_axis(const Plan& plan, const BoxEntry& entry, double aim) {
  const auto& parameters = plan.field->info.parameters;
  const std::string& unit = std::ranges::find(parameters, entry.name, &models::ParameterInfo::name)->unit;
  const bool is_linear = std::ranges::count(plan.field->linear_in, entry.name) > 0;
  pgd::Transform transform = entry.transform;
  int nodes = 2;
  if (!is_linear || transform != pgd::Transform::none) {
    const double ratio = entry.upper / entry.lower;
    // What it is linear in is smooth in what a transform makes of it.
    const int of_digits = 4 + static_cast<int>(std::ceil(std::max(2.0, 1.0 - std::log10(aim))));
    const auto needed = [&](pgd::Transform by) { return is_linear ? of_digits : nodes_for(ratio, by, aim); };
    // Over decades of it, a field is smoother in the logarithm.
    const bool is_open = !entry.prescribes_axis() && transform == pgd::Transform::none;
    if (is_open && needed(pgd::Transform::logarithm) < needed(transform))
      transform = pgd::Transform::logarithm;
    nodes = needed(transform);
  }
  const auto axis = [&](int count) {
    return pgd::basis_traits(entry.basis)
        .over_interval({entry.name, unit, AxisRole::parameter, transform}, entry.lower, entry.upper, count);
  };
  if (entry.nodes) return axis(*entry.nodes);
  constexpr int kMostNodes = 2000;  // that a plan may ask for
  if (nodes > kMostNodes)
    throw ArgumentError(
        fmt::format("{} goes from {} to {} in [box], which takes more than {} nodes; a narrower interval, or "
                    "transform = \"log\", was expected",
                    entry.name, entry.lower, entry.upper, kMostNodes));
  // Equations are weighed by the quadrature of the axis, which a logarithm over decades leaves positive on enough
  // nodes only.
  constexpr int kMost = 400;
  while (nodes < kMost && !(axis(nodes).weights().minCoeff() > 0.0)) ++nodes;
  return axis(nodes);
}

/// Elements double from one in which nothing but a layer at the ends, of the size of the aim, changes.
/// @param diffusions of the fastest rod, times the end over the length squared
Axis time_axis(double end, double diffusions, double aim) {
  constexpr int kDegree = 5;
  const int doublings = std::max(1, static_cast<int>(std::ceil(std::log2(2.0 * diffusions / aim))));
  Eigen::VectorXd borders(doublings + 2);
  borders[0] = 0.0;
  for (int e = 0; e <= doublings; ++e) borders[e + 1] = std::ldexp(end, e - doublings);
  return Axis::radau({"t", "s", AxisRole::time}, borders, kDegree);
}

/// One element, whose nodes crowd at the ends: layers that are thinner than the first of them, 1/degree^2 of the
/// length, have come no further than 8/degree^4 of the amplitude.
Axis place_axis(const models::FieldModel& field, double length, double aim) {
  const int degree = static_cast<int>(std::ceil(std::pow(40.0 / aim, 0.25)));
  return Axis::legendre({field.place, "m", AxisRole::space}, 0.0, length, degree + 1);
}

}  // namespace

pgd::ParametricProblem ready_problem(const Plan& plan, double aim) {
  const models::FieldModel& field = *plan.field;
  const double length = plan.fixed.at(field.extent);
  const double fastest = highest_of(plan, "conductivity") / lowest_of(plan, "capacity");
  std::vector<Axis> axes = {time_axis(plan.end, fastest * plan.end / (length * length), aim),
                            place_axis(field, length, aim)};
  for (const BoxEntry& entry : plan.box) axes.push_back(parameter_axis(plan, entry, aim));
  const Axis &t = axes[0], &x = axes[1];
  const Coefficients coefficients(plan, axes);
  pgd::ParametricProblem problem(axes);
  // The equation is divided by the conductivity, so that the residual counts in the same measure, that of the
  // gradient, for all rods; and weighed such that decades of time and of parameters count alike.
  const Eigen::VectorXd weights = (plan.end / (t.nodes().array() + t.borders()[1])).sqrt();
  coefficients.add_term(problem, {{"capacity", 0.5}, {"conductivity", -1.5}},
                        {{t.name(), ModeOperator::sparse(t.derivative()).row_scaled(weights)}});
  coefficients.add_term(
      problem, {{"capacity", -0.5}, {"conductivity", -0.5}},
      {{t.name(), ModeOperator::diagonal(weights)}, {x.name(), ModeOperator::sparse(x.stiffness())}});
  problem.know(x.name(), {0, x.size() - 1});
  problem.know(t.name(), {0});
  problem.measure(x.name(), x.stiffness());
  const Eigen::VectorXd s = x.nodes() / length;
  coefficients.add_to_lift(problem, "amplitude", x.name(), 4.0 * s.array() * (1.0 - s.array()));
  return problem;
}

void add_steady_part(const Plan& plan, pgd::ParametricProblem& problem) {
  const std::vector<Axis> axes = problem.axes();
  const Axis& x = *std::ranges::find(axes, AxisRole::space, &Axis::role);
  const Eigen::VectorXd s = (x.nodes().array() - x.lower()) / x.length();
  const Coefficients coefficients(plan, axes);
  coefficients.add_to_lift(problem, "left", x.name(), 1.0 - s.array());
  coefficients.add_to_lift(problem, "right", x.name(), s);
}

FieldReference exact_reference(const models::FieldModel& model, const std::map<std::string, double>& fixed,
                               const std::vector<std::string>& free) {
  const auto& parameters = model.info.parameters;
  std::vector<double> values;
  for (const models::ParameterInfo& parameter : parameters) {
    const auto given = fixed.find(parameter.name);
    const bool is_known = given != fixed.end() || parameter.default_value || contains(free, parameter.name);
    if (!is_known) {
      throw ArgumentError(
          fmt::format("the parameter \"{}\" of the field \"{}\" is neither fixed nor a coordinate, and has "
                      "no default: its exact solution needs it",
                      parameter.name, model.info.name));
    }
    values.push_back(given != fixed.end() ? given->second : parameter.default_value.value_or(0.0));
  }
  std::vector<std::size_t> places_of_free;
  for (const std::string& name : free) {
    const auto found = std::ranges::find(parameters, name, &models::ParameterInfo::name);
    if (found == parameters.end())
      throw ArgumentError(fmt::format("the field \"{}\" has no parameter \"{}\"", model.info.name, name));
    places_of_free.push_back(static_cast<std::size_t>(found - parameters.begin()));
  }
  FieldReference reference;
  reference.name = model.exact_source;
  reference.values = [exact = model.exact, values, places_of_free](std::span<const double> q,
                                                                   const std::vector<double>& times,
                                                                   const Eigen::VectorXd& places) {
    std::vector<double> p = values;
    for (std::size_t k = 0; k < q.size(); ++k) p[places_of_free[k]] = q[k];
    Eigen::MatrixXd field(static_cast<Eigen::Index>(times.size()), places.size());
    for (Eigen::Index j = 0; j < field.cols(); ++j) {
      for (Eigen::Index i = 0; i < field.rows(); ++i)
        field(i, j) = exact(times[static_cast<std::size_t>(i)], places[j], p);
    }
    return field;
  };
  return reference;
}

FieldReference exact_reference(const Codebook& book) {
  const models::FieldModel* model = models::find_field_model(book.model().name);
  const std::optional<int> space = book.space();
  if (model == nullptr || !space || !book.has_time()) {
    throw ArgumentError(fmt::format(
        "the codebook holds the field \"{}\", which no exact solution is known of here: certify it where its "
        "equations are",
        book.model().name));
  }
  std::vector<std::string> free;
  for (int k = 1; k < book.coordinate_count(); ++k)
    if (k != *space) free.push_back(book.coordinates()[static_cast<std::size_t>(k)].name);
  return exact_reference(*model, book.model().fixed, free);
}

}  // namespace samara::codebooks

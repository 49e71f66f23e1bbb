#include "samara/models/checks/check_model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "samara/base/number_text.h"
#include "samara/base/require.h"
#include "samara/base/text.h"
#include "samara/base/unit_labels.h"
#include "samara/models/checks/check_parts.h"
#include "samara/models/checks/check_physics.h"
#include "samara/models/checks/check_units.h"
#include "samara/models/checks/kinks.h"

namespace samara::models {

namespace {

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool looks_like_a_name(std::string_view name) {
  return !name.empty() && is_letter(name.front()) &&
         std::ranges::all_of(name, [](char c) { return is_letter(c) || is_digit(c) || c == '_'; });
}

void check_texts(const ModelInfo& info, Findings& findings) {
  const auto need = [&](const std::string& text, const std::string& what) {
    if (text.empty()) findings.push_back("model " + in_quotes(info.name) + " has no " + what);
  };
  need(info.name, "name");
  need(info.title, "title");
  need(info.equations, "equations");
  need(info.frames, "words on its frames");
  need(info.source, "source");
  need(info.validity, "range of validity");
  if (info.states.empty()) findings.push_back("model " + in_quotes(info.name) + " has no states");
}

void check_names_and_units(const ModelInfo& info, Findings& findings) {
  std::vector<std::string> seen;
  const auto look = [&](const std::string& name, const std::string& unit, const std::string& description) {
    if (!looks_like_a_name(name)) {
      findings.push_back("name " + in_quotes(name) + " is not made of letters, digits and _, a letter first");
    }
    if (std::ranges::count(seen, name) > 0) findings.push_back("name " + in_quotes(name) + " is used twice");
    if (!reads_as_unit(unit)) {
      findings.push_back("unit " + in_quotes(unit) + " of " + in_quotes(name) + " does not read as a unit");
    }
    if (description.empty()) findings.push_back(in_quotes(name) + " has no description");
    seen.push_back(name);
  };
  for (const StateInfo& state : info.states) look(state.name, state.unit, state.description);
  for (const ParameterInfo& p : info.parameters) look(p.name, p.unit, p.description);
}

void check_defaults(const ModelInfo& info, Findings& findings) {
  for (const StateInfo& state : info.states) {
    if (!std::isfinite(state.default_initial)) {
      findings.push_back("the default initial value of " + in_quotes(state.name) + " is not finite");
    }
  }
  for (const ParameterInfo& parameter : info.parameters) {
    if (!parameter.default_value) continue;
    const double value = *parameter.default_value;
    if (!std::isfinite(value))
      findings.push_back("the default of " + in_quotes(parameter.name) + " is not finite");
    if (!in_meaning(parameter, value)) {
      findings.push_back("the default of " + in_quotes(parameter.name) + ", " + number_text(value) +
                         ", is outside its meaning");
    }
    if (!parameter.derived.empty()) {
      findings.push_back(in_quotes(parameter.name) + " has both a default and a derived default");
    }
  }
}

}  // namespace

double random_value(const ParameterInfo& parameter, std::mt19937& random) {
  std::uniform_real_distribution<double> factor(0.5, 2.0);
  if (std::isfinite(parameter.lower) && std::isfinite(parameter.upper)) {
    return parameter.lower + 0.4 * factor(random) * (parameter.upper - parameter.lower);
  }
  if (parameter.default_value && *parameter.default_value != 0.0) {
    const double value = *parameter.default_value * factor(random);
    if (value > parameter.lower && value < parameter.upper) return value;
  }
  if (std::isfinite(parameter.lower)) return parameter.lower + factor(random);
  if (std::isfinite(parameter.upper)) return parameter.upper - factor(random);
  // Small beside parameters that are not zero: entries off the diagonal of a matrix must leave it regular.
  return 0.1 * (factor(random) - 1.25);
}

Point with_all_given(const Model& model, const Point& point) {
  Point all = point;
  all.p = {model.completed(point.p), std::vector<char>(point.p.given.size(), 1)};
  model.rhs_with_derivatives(all.t, all.x, all.p, all.f, all.df_dx, all.df_dp);
  return all;
}

Eigen::VectorXd term_sizes(const Point& point) {
  const auto vector = [](const std::vector<double>& values) {
    return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()))
        .cwiseAbs();
  };
  return vector(point.f) + point.df_dx.cwiseAbs() * vector(point.x) +
         point.df_dp.cwiseAbs() * vector(point.p.value);
}

namespace {

/// A quaternion of norm one, all attitudes equally likely.
void set_random_attitude(double* q, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Map<Eigen::Vector4d> attitude(q);
  for (double& part : attitude) part = normal(random);
  attitude.normalize();
}

}  // namespace

Point random_point(const Model& model, std::mt19937& random) {
  const ModelInfo& info = model.info();
  std::uniform_real_distribution<double> symmetric(-2.0, 2.0);
  Point point;
  for (const ParameterInfo& parameter : info.parameters) {
    const bool optional = parameter.default_value || !parameter.derived.empty();
    point.p.given.push_back(!optional || symmetric(random) > 0.0 ? 1 : 0);
    point.p.value.push_back(random_value(parameter, random));
  }
  const Scales scales = model.scales(point.p);
  point.t = std::abs(symmetric(random)) * scales.time;
  for (const StateInfo& state : info.states) {
    point.x.push_back(symmetric(random) * state_scale(state, scales));
  }
  for (const StateGroup& group : info.groups) {
    if (group.kind == StateGroupKind::quaternion) set_random_attitude(point.x.data() + group.first, random);
  }
  const auto states = static_cast<Eigen::Index>(info.states.size());
  point.f.resize(info.states.size());
  point.df_dx.resize(states, states);
  point.df_dp.resize(states, static_cast<Eigen::Index>(info.parameters.size()));
  model.rhs_with_derivatives(point.t, point.x, point.p, point.f, point.df_dx, point.df_dp);
  return point;
}

namespace {

bool all_finite(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

void check_values(const Model& model, const Point& point, Findings& findings) {
  const ModelInfo& info = model.info();
  std::vector<double> f(point.f.size());
  model.rhs(point.t, point.x, point.p, f);
  for (std::size_t i = 0; i < f.size(); ++i) {
    // The two routes may round differently; more than that is a mistake. Terms that cancel in f show in its
    // derivatives.
    const auto row = static_cast<Eigen::Index>(i);
    double terms = std::abs(f[i]) + std::abs(point.f[i]);
    for (std::size_t j = 0; j < f.size(); ++j) {
      terms += std::abs(point.df_dx(row, static_cast<Eigen::Index>(j)) * point.x[j]);
    }
    const double round_off = 1e-12 * terms;
    if (!(std::abs(f[i] - point.f[i]) <= round_off)) {
      findings.push_back("the rate of " + in_quotes(info.states[i].name) + " is " + number_text(f[i]) +
                         " without derivatives and " + number_text(point.f[i]) + " with them");
    }
  }
  const std::vector<double> all = model.completed(point.p);
  if (all.size() != info.parameters.size() || !all_finite(all)) {
    findings.push_back("the completed parameters are not one finite number each");
  }
  for (std::size_t j = 0; j < all.size() && j < info.parameters.size(); ++j) {
    if (point.p.given[j] && all[j] != point.p.value[j]) {
      findings.push_back("the given value of " + in_quotes(info.parameters[j].name) +
                         " is changed by completed()");
    }
  }
  const Scales s = model.scales(point.p);
  for (const double size : {s.length, s.time, s.velocity}) {
    if (!(std::isfinite(size) && size > 0.0)) {
      findings.push_back("the scales hold " + number_text(size) + "; finite and positive was expected");
    }
  }
}

/// At many points at once a model says what it says at each of them.
void check_points(const Model& model, const Point& point, Findings& findings) {
  constexpr Eigen::Index kPoints = 3;
  const auto columns = [](const std::vector<double>& values) -> Eigen::MatrixXd {
    return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()))
        .replicate(1, kPoints);
  };
  const Eigen::MatrixXd x = columns(point.x), p = columns(model.completed(point.p));
  const Eigen::VectorXd t = Eigen::VectorXd::Constant(kPoints, point.t);
  Eigen::MatrixXd f(x.rows(), kPoints), jacobians(x.rows() * x.rows(), kPoints);
  model.rhs_at_points(t, x, p, f);
  model.jacobians_at_points(t, x, p, jacobians);
  const Eigen::VectorXd sizes = term_sizes(point);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const std::string name = in_quotes(model.info().states[static_cast<std::size_t>(i)].name);
    const double apart = (f.row(i).array() - point.f[static_cast<std::size_t>(i)]).abs().maxCoeff();
    if (!(apart <= kEqualRates * sizes[i]))
      findings.push_back("the rate of " + name + " at many points is another than at one");
    for (Eigen::Index j = 0; j < x.rows(); ++j) {
      const double slope = point.df_dx(i, j);
      const double slopes_apart = (jacobians.row(i + x.rows() * j).array() - slope).abs().maxCoeff();
      if (!(slopes_apart <= kEqualRates * (std::abs(slope) + sizes[i])))
        findings.push_back("the derivatives of the rate of " + name +
                           " at many points are others than at one");
    }
  }
}

/// What is compared with differences: rates, or outputs.
struct Differentiated {
  std::vector<std::string> names;                        ///< "the rate of "x"", "the output "y""
  std::function<void(std::span<double>)> evaluate = {};  ///< at the point as it is
};

/// Compares one column of derivatives with central differences in `variable`, on which they depend.
void check_column(const Differentiated& of, double& variable, double size, const std::string& name,
                  const Eigen::VectorXd& derivative, double tolerance, Findings& findings) {
  // The step that balances truncation, h^2, against round-off, eps/h.
  const double step = std::cbrt(std::numeric_limits<double>::epsilon()) * size;
  const double middle = variable;
  std::vector<double> above(of.names.size());
  std::vector<double> below(of.names.size());
  const double up = variable = middle + step;
  of.evaluate(above);
  const double down = variable = middle - step;
  of.evaluate(below);
  variable = middle;
  for (std::size_t i = 0; i < of.names.size(); ++i) {
    const double exact = derivative[static_cast<Eigen::Index>(i)];
    const double difference = (above[i] - below[i]) / (up - down);
    const double scale = std::abs(exact) + std::max(std::abs(above[i]), std::abs(below[i])) / size;
    if (std::abs(difference - exact) <= tolerance * scale) continue;
    findings.push_back("the derivative of " + of.names[i] + " by " + in_quotes(name) + " is " +
                       number_text(exact) + "; differences give " + number_text(difference, 8));
  }
}

/// By all states and all parameters that are given.
void check_columns(const Model& model, Point& point, const Differentiated& of,
                   const Eigen::Ref<const Eigen::MatrixXd>& by_x,
                   const Eigen::Ref<const Eigen::MatrixXd>& by_p, double tolerance, Findings& findings) {
  const ModelInfo& info = model.info();
  const Scales scales = model.scales(point.p);
  for (std::size_t i = 0; i < info.states.size(); ++i) {
    const double size = std::max(std::abs(point.x[i]), state_scale(info.states[i], scales));
    check_column(of, point.x[i], size, info.states[i].name, by_x.col(static_cast<Eigen::Index>(i)), tolerance,
                 findings);
  }
  for (std::size_t j = 0; j < info.parameters.size(); ++j) {
    const Eigen::VectorXd column = by_p.col(static_cast<Eigen::Index>(j));
    if (!point.p.given[j]) {
      if (!column.isZero(0.0)) {
        findings.push_back("the derivative by " + in_quotes(info.parameters[j].name) +
                           " is not zero although it is not given");
      }
      continue;
    }
    const double size = point.p.value[j] == 0.0 ? 1.0 : std::abs(point.p.value[j]);
    check_column(of, point.p.value[j], size, info.parameters[j].name, column, tolerance, findings);
  }
}

void check_derivatives(const Model& model, Point& point, double tolerance, Findings& findings) {
  Differentiated rates;
  for (const StateInfo& state : model.info().states)
    rates.names.push_back("the rate of " + in_quotes(state.name));
  rates.evaluate = [&](std::span<double> f) { model.rhs(point.t, point.x, point.p, f); };
  check_columns(model, point, rates, point.df_dx, point.df_dp, tolerance, findings);
}

void check_outputs(const Model& model, Point& point, double tolerance, Findings& findings) {
  const ModelInfo& info = model.info();
  Differentiated outputs;
  for (const OutputInfo& output : info.outputs)
    outputs.names.push_back("the output " + in_quotes(output.name));
  if (outputs.names.empty()) return;
  outputs.evaluate = [&](std::span<double> y) { model.outputs(point.t, point.x, point.p, y); };
  const Eigen::Index count = std::ssize(info.outputs);
  std::vector<double> y(info.outputs.size()), alone(info.outputs.size());
  Eigen::VectorXd by_t(count);
  Eigen::MatrixXd by_x(count, std::ssize(info.states)), by_p(count, std::ssize(info.parameters));
  model.outputs_with_derivatives(point.t, point.x, point.p, y, by_t, by_x, by_p);
  outputs.evaluate(alone);
  if (y != alone) findings.push_back("the outputs with derivatives are others than without");
  check_column(outputs, point.t, std::max(point.t, model.scales(point.p).time), "t", by_t, tolerance,
               findings);
  check_columns(model, point, outputs, by_x, by_p, tolerance, findings);
}

/// Whether f changes where a state moves by its scale: over a jump derivatives are blind.
bool depends_on(const Model& model, const Point& point, std::size_t state) {
  std::vector<double> x = point.x, f(x.size());
  x[state] += state_scale(model.info().states[state], model.scales(point.p));
  model.rhs(point.t, x, point.p, f);
  const Eigen::VectorXd sizes = term_sizes(point);
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (!(std::abs(f[i] - point.f[i]) <= kEqualRates * sizes[static_cast<Eigen::Index>(i)])) return true;
  }
  return false;
}

/// "translation of x" means that f does not depend on x.
void check_symmetries(const Model& model, const Point& point, Findings& findings) {
  const std::string translation = "translation of ";
  const std::vector<StateInfo>& states = model.info().states;
  for (const std::string& symmetry : model.info().symmetries) {
    if (!symmetry.starts_with(translation)) continue;
    const std::string name = symmetry.substr(translation.size());
    const auto state = std::ranges::find(states, name, &StateInfo::name);
    if (state == states.end()) {
      findings.push_back("symmetry " + in_quotes(symmetry) + " names no state");
    } else if (!point.df_dx.col(state - states.begin()).isZero(0.0) ||
               depends_on(model, point, static_cast<std::size_t>(state - states.begin()))) {
      findings.push_back("symmetry " + in_quotes(symmetry) + " does not hold: f depends on " +
                         in_quotes(name));
    }
  }
}

/// The same finding at many points is said once.
void remove_repetitions(Findings& findings) {
  Findings unique;
  for (std::string& finding : findings) {
    if (std::ranges::count(unique, finding) == 0) unique.push_back(std::move(finding));
  }
  findings = std::move(unique);
}

}  // namespace

Check check_model(const Model& model, const CheckModelOptions& options) {
  require(options.points >= 1, "points", options.points, "1 or more");
  require(options.tolerance > 0.0, "tolerance", options.tolerance, "a positive value");
  Check check;
  check_texts(model.info(), check.findings);
  check_names_and_units(model.info(), check.findings);
  check_defaults(model.info(), check.findings);
  check_known_units(model.info(), check.findings);
  if (!check_groups(model.info(), check.findings)) return check;
  std::mt19937 random(options.seed);
  for (int k = 0; k < options.points; ++k) {
    Point point = random_point(model, random);
    check_values(model, point, check.findings);
    check_points(model, point, check.findings);
    check_derivatives(model, point, options.tolerance, check.findings);
    check_outputs(model, point, options.tolerance, check.findings);
    check_symmetries(model, point, check.findings);
    check_rotation(model, point, random, check.findings);
    if (options.units) check_dimensions(model, point, random, check.findings);
    check_affinity(model, point, random, check.findings);
    check_forces(model, point, options.tolerance, check.findings);
    check_passivity(model, point, check.findings);
  }
  remove_repetitions(check.findings);
  for (const Kink& kink : find_kinks(model, {.seed = options.seed})) check.notes.push_back(described(kink));
  return check;
}

}  // namespace samara::models

#include "samara/models/checks/check_units.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "samara/base/text.h"
#include "samara/base/unit_labels.h"
#include "samara/base/units.h"

namespace samara::models {

namespace {

/// A base quantity whose unit is changed. Kelvin, ampere, mole and candela are left as they are.
struct ChangedQuantity {
  int Dimension::*exponent;
  const char* name;
};
constexpr std::array<ChangedQuantity, 3> kChangedQuantities = {
    {{&Dimension::metre, "length"}, {&Dimension::kilogram, "mass"}, {&Dimension::second, "time"}}};

/// A change of the unit of one base quantity: numbers of that dimension are multiplied by `factor`.
struct UnitChange {
  ChangedQuantity quantity;
  double factor;

  double of(const Dimension& dimension) const { return std::pow(factor, dimension.*(quantity.exponent)); }
  double of(const std::string& unit) const { return of(parse_unit(unit).dimension); }
  double of_time() const { return of(Dimension{.second = 1}); }
};

bool all_units_known(const ModelInfo& info) {
  const auto known = [](const auto& item) { return is_coherent_si(item.unit); };
  return std::ranges::all_of(info.states, known) && std::ranges::all_of(info.parameters, known);
}

std::string not_followed(const std::string& what, const std::string& unit, const UnitChange& change) {
  return what + " does not follow its unit, " + unit + ", when the unit of " + change.quantity.name +
         " is changed: a unit is wrong, or a constant has one that is not said";
}

/// t, x and p of a point whose parameters are all given, in changed units; nothing else.
Point in_changed_units(const ModelInfo& info, const Point& point, const UnitChange& change) {
  Point changed;
  changed.t = point.t * change.of_time();
  changed.x = point.x;
  changed.p = point.p;
  for (std::size_t i = 0; i < changed.x.size(); ++i) {
    changed.x[i] *= change.of(info.states[i].unit);
  }
  for (std::size_t j = 0; j < changed.p.value.size(); ++j) {
    changed.p.value[j] *= change.of(info.parameters[j].unit);
  }
  return changed;
}

void check_rates(const Model& model, const Point& point, const Point& changed, const UnitChange& change,
                 Findings& findings) {
  const ModelInfo& info = model.info();
  std::vector<double> f(point.x.size());
  model.rhs(changed.t, changed.x, changed.p, f);
  const Eigen::VectorXd sizes = term_sizes(point);
  for (std::size_t i = 0; i < f.size(); ++i) {
    const std::string& unit = info.states[i].unit;
    const double back = f[i] * change.of_time() / change.of(unit);
    const double bound = kEqualRates * sizes[static_cast<Eigen::Index>(i)];
    if (std::abs(back - point.f[i]) <= bound) continue;
    findings.push_back(
        not_followed("the rate of " + in_quotes(info.states[i].name), in_quotes(unit) + " per s", change));
  }
}

void check_force_units(const Model& model, const Point& point, const Point& changed, const UnitChange& change,
                       Findings& findings) {
  const ModelInfo& info = model.info();
  const ForceUnits units = force_units(info);
  std::vector<Wrench> before(info.force_terms.size());
  std::vector<Wrench> after(info.force_terms.size());
  model.forces(point.t, point.x, point.p, before);
  model.forces(changed.t, changed.x, changed.p, after);
  const auto look = [&](const std::string& what, const std::string& unit, double difference, double size) {
    if (!(difference <= kEqualRates * size)) findings.push_back(not_followed(what, in_quotes(unit), change));
  };
  const auto factor = [&](const std::string& unit) { return change.of(unit); };
  // Terms may be small differences of larger things; all terms together say how large.
  double force = 0.0;
  double torque = 0.0;
  double power = 0.0;
  for (const Wrench& term : before) {
    force += term.force.norm();
    torque += term.torque.norm();
    power += std::abs(term.power);
  }
  for (std::size_t k = 0; k < before.size(); ++k) {
    const std::string of = " of the term " + in_quotes(info.force_terms[k].name);
    look("the force" + of, units.force, (after[k].force / factor(units.force) - before[k].force).norm(),
         force);
    look("the torque" + of, units.torque, (after[k].torque / factor(units.torque) - before[k].torque).norm(),
         torque);
    look("the power" + of, units.power, std::abs(after[k].power / factor(units.power) - before[k].power),
         power);
  }
  const std::optional<double> energy = model.kinetic_energy(point.t, point.x, point.p);
  if (!energy) return;
  const double scaled = model.kinetic_energy(changed.t, changed.x, changed.p).value_or(0.0);
  look("the kinetic energy", units.energy, std::abs(scaled / factor(units.energy) - *energy),
       std::abs(*energy));
}

/// `point` is as it was drawn: some parameters with a derived default are not given.
void check_derived(const Model& model, const Point& point, const UnitChange& change, Findings& findings) {
  const ModelInfo& info = model.info();
  ParameterValues p = {model.completed(point.p), point.p.given};
  for (std::size_t j = 0; j < p.value.size(); ++j) {
    if (info.parameters[j].derived.empty()) p.given[j] = 1;  // constants change with their unit
  }
  const std::vector<double> before = model.completed(p);
  for (std::size_t j = 0; j < p.value.size(); ++j) {
    p.value[j] *= change.of(info.parameters[j].unit);
  }
  const std::vector<double> after = model.completed(p);
  for (std::size_t j = 0; j < p.value.size(); ++j) {
    const std::string& unit = info.parameters[j].unit;
    const double expected = before[j] * change.of(unit);
    if (std::abs(after[j] - expected) <= kEqualRates * std::abs(expected)) continue;
    findings.push_back(not_followed("the derived default of " + in_quotes(info.parameters[j].name),
                                    in_quotes(unit), change));
  }
}

}  // namespace

void check_known_units(const ModelInfo& info, Findings& findings) {
  const auto look = [&](const auto& item) {
    if (!reads_as_unit(item.unit) || is_coherent_si(item.unit)) return;
    findings.push_back("unit " + in_quotes(item.unit) + " of " + in_quotes(item.name) +
                       " is not made of base units of SI, rad, N, J, W, Pa and Hz");
  };
  for (const StateInfo& state : info.states) look(state);
  for (const ParameterInfo& parameter : info.parameters) look(parameter);
}

void check_dimensions(const Model& model, const Point& point, std::mt19937& random, Findings& findings) {
  const ModelInfo& info = model.info();
  if (!all_units_known(info) || time_unit(info) == "1") return;
  const Point all = with_all_given(model, point);
  std::uniform_real_distribution<double> factor(1.5, 3.0);
  for (const ChangedQuantity& quantity : kChangedQuantities) {
    const UnitChange change = {quantity, factor(random)};
    const Point changed = in_changed_units(info, all, change);
    check_rates(model, all, changed, change, findings);
    check_force_units(model, all, changed, change, findings);
    check_derived(model, point, change, findings);
  }
}

}  // namespace samara::models

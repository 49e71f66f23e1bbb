#include "samara/models/checks/check_physics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "samara/base/number_text.h"
#include "samara/base/text.h"

namespace samara::models {

namespace {

std::string rate_of(const ModelInfo& info, std::size_t state) {
  return "the rate of " + in_quotes(info.states[state].name);
}

/// x turned about the vertical by `angle`, group by group. Rates turn the same way.
std::vector<double> turned(std::vector<double> x, const std::vector<StateGroup>& groups, double angle) {
  for (const StateGroup& group : groups) {
    double* const s = x.data() + group.first;
    if (group.kind == StateGroupKind::quaternion) {
      const double c = std::cos(angle / 2);
      const double n = std::sin(angle / 2);
      const std::array<double, 4> q = {s[0], s[1], s[2], s[3]};
      s[0] = c * q[0] - n * q[3];  // (c, 0, 0, n) * q
      s[1] = c * q[1] - n * q[2];
      s[2] = c * q[2] + n * q[1];
      s[3] = c * q[3] + n * q[0];
    } else {
      const double along = s[0];
      s[0] = std::cos(angle) * along - std::sin(angle) * s[1];
      s[1] = std::sin(angle) * along + std::cos(angle) * s[1];
    }
  }
  return x;
}

/// Turning mixes the components of a group: each takes the largest size among them.
Eigen::VectorXd group_sizes(Eigen::VectorXd sizes, const std::vector<StateGroup>& groups) {
  for (const StateGroup& group : groups) {
    auto segment = sizes.segment(group.first, group_size(group.kind));
    segment.setConstant(segment.maxCoeff());
  }
  return sizes;
}

/// Rate of the kinetic energy along f, by central differences, and how sure it is.
struct EnergyRate {
  double value = 0.0;
  double size = 0.0;  ///< the energy over the time in which the state changes by its own size
};

EnergyRate energy_rate(const Model& model, const Point& point) {
  const ModelInfo& info = model.info();
  const Scales scales = model.scales(point.p);
  double time = scales.time;
  for (std::size_t i = 0; i < point.x.size(); ++i) {
    const double size = std::max(std::abs(point.x[i]), state_scale(info.states[i], scales));
    if (point.f[i] != 0.0) time = std::min(time, size / std::abs(point.f[i]));
  }
  const double step = std::cbrt(std::numeric_limits<double>::epsilon()) * time;
  const auto energy = [&](double dt) {
    std::vector<double> x = point.x;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += dt * point.f[i];
    return model.kinetic_energy(point.t + dt, x, point.p).value_or(std::nan(""));
  };
  const double above = energy(step);
  const double below = energy(-step);
  return {(above - below) / (2.0 * step), std::max(std::abs(above), std::abs(below)) / time};
}

}  // namespace

int group_size(StateGroupKind kind) {
  return kind == StateGroupKind::quaternion ? 4 : 3;
}

void check_affinity(const Model& model, const Point& point, std::mt19937& random, Findings& findings) {
  const ModelInfo& info = model.info();
  std::vector<std::size_t> places;
  for (const std::string& name : info.affine_in) {
    const auto place = std::ranges::find(info.parameters, name, &ParameterInfo::name);
    if (place == info.parameters.end()) {
      findings.push_back("f is said to be affine in " + in_quotes(name) + ", which is no parameter");
    } else {
      places.push_back(static_cast<std::size_t>(place - info.parameters.begin()));
    }
  }
  if (places.empty()) return;
  ParameterValues first = {model.completed(point.p), std::vector<char>(info.parameters.size(), 1)};
  ParameterValues second = first;
  Point middle = point;
  middle.p = first;
  for (const std::size_t j : places) {
    first.value[j] = random_value(info.parameters[j], random);
    second.value[j] = random_value(info.parameters[j], random);
    middle.p.value[j] = 0.5 * (first.value[j] + second.value[j]);
  }
  middle = with_all_given(model, middle);
  std::vector<double> f1(point.x.size());
  std::vector<double> f2(point.x.size());
  model.rhs(point.t, point.x, first, f1);
  model.rhs(point.t, point.x, second, f2);
  const Eigen::VectorXd sizes = term_sizes(middle);
  for (std::size_t i = 0; i < f1.size(); ++i) {
    const double bound =
        kEqualRates * (sizes[static_cast<Eigen::Index>(i)] + std::abs(f1[i]) + std::abs(f2[i]));
    if (std::abs(f1[i] + f2[i] - 2.0 * middle.f[i]) <= bound) continue;
    findings.push_back(rate_of(info, i) + " is not affine in the parameters of affine_in together");
  }
}

void check_forces(const Model& model, const Point& point, double tolerance, Findings& findings) {
  const ModelInfo& info = model.info();
  if (info.force_terms.empty()) return;
  std::vector<Wrench> terms(info.force_terms.size());
  model.forces(point.t, point.x, point.p, terms);
  double power = 0.0;
  double size = 0.0;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const Wrench& term = terms[k];
    if (!term.force.allFinite() || !term.torque.allFinite() || !std::isfinite(term.power)) {
      findings.push_back("the force term " + in_quotes(info.force_terms[k].name) + " is not finite");
      return;
    }
    power += term.power;
    size += std::abs(term.power);
  }
  const std::optional<double> energy = model.kinetic_energy(point.t, point.x, point.p);
  if (!energy) return;
  if (!std::isfinite(*energy)) {
    findings.push_back("the kinetic energy is " + number_text(*energy));
    return;
  }
  const EnergyRate rate = energy_rate(model, point);
  if (std::abs(rate.value - power) <= tolerance * (rate.size + size)) return;
  findings.push_back("the powers of the force terms do not sum to the rate of the kinetic energy");
}

void check_passivity(const Model& model, const Point& point, Findings& findings) {
  const ModelInfo& info = model.info();
  std::vector<Wrench> terms(info.force_terms.size());
  model.forces(point.t, point.x, point.p, terms);
  const Scales scales = model.scales(point.p);
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const ForceTermInfo& term = info.force_terms[k];
    const bool is_idle = term.description.ends_with("no power");
    if (!is_idle && !term.description.ends_with("takes power")) continue;
    // A product of random states is a few times that of their scales.
    const double size = terms[k].force.norm() * scales.velocity + terms[k].torque.norm() / scales.time;
    const double power = terms[k].power;
    if (power <= kEqualRates * size && (!is_idle || power >= -kEqualRates * size)) continue;
    findings.push_back("the force term " + in_quotes(term.name) + " is said to " +
                       (is_idle ? "do no power" : "take power") + ", and gives " + number_text(power));
  }
}

bool check_groups(const ModelInfo& info, Findings& findings) {
  std::vector<int> uses(info.states.size(), 0);
  for (std::size_t k = 0; k < info.groups.size(); ++k) {
    const StateGroup& group = info.groups[k];
    const int end = group.first + group_size(group.kind);
    if (group.first < 0 || end > static_cast<int>(info.states.size())) {
      findings.push_back("group " + number_text(static_cast<double>(k)) + " of states reaches from " +
                         number_text(group.first) + " to " + number_text(end - 1) +
                         ", beyond the states of the model");
      return false;
    }
    for (int i = group.first; i < end; ++i) ++uses[static_cast<std::size_t>(i)];
  }
  bool apart = true;
  for (std::size_t i = 0; i < uses.size(); ++i) {
    if (uses[i] < 2) continue;
    findings.push_back("state " + in_quotes(info.states[i].name) + " is in two groups");
    apart = false;
  }
  return apart;
}

void check_rotation(const Model& model, const Point& point, std::mt19937& random, Findings& findings) {
  const ModelInfo& info = model.info();
  const Eigen::VectorXd sizes = group_sizes(term_sizes(point), info.groups);
  for (const StateGroup& group : info.groups) {
    if (group.kind != StateGroupKind::quaternion) continue;
    const Eigen::Map<const Eigen::Vector4d> q(point.x.data() + group.first);
    const Eigen::Map<const Eigen::Vector4d> rate(point.f.data() + group.first);
    if (!(std::abs(q.dot(rate)) <= kEqualRates * sizes[group.first])) {
      findings.push_back("the norm of the quaternion from " +
                         in_quotes(info.states[static_cast<std::size_t>(group.first)].name) +
                         " on changes along f");
    }
  }
  if (std::ranges::count(info.symmetries, "rotation about z") == 0) return;
  std::uniform_real_distribution<double> any(0.0, 2.0 * std::numbers::pi);
  const double angle = any(random);
  std::vector<double> f(point.f.size());
  model.rhs(point.t, turned(point.x, info.groups, angle), point.p, f);
  const std::vector<double> expected = turned(point.f, info.groups, angle);
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (std::abs(f[i] - expected[i]) <= kEqualRates * sizes[static_cast<Eigen::Index>(i)]) continue;
    findings.push_back("symmetry \"rotation about z\" does not hold: " + rate_of(info, i) +
                       " does not turn with the states");
  }
}

}  // namespace samara::models

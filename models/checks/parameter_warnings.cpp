#include "samara/models/checks/parameter_warnings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

namespace samara::models {

namespace {

// Between these values nothing is said.
constexpr double kAnySolid = 100.0, kAnyFluid = 1000.0;
constexpr double kLongest = 10.0;
/// What measured or rounded moments may be off.
constexpr double kSlack = 1.01;

/// Parameters by name.
class Values {
 public:
  Values(const Model& model, const std::map<std::string, double>& given) : info_(model.info()) {
    ParameterValues p;
    bool all = true;
    for (const ParameterInfo& parameter : info_.parameters) {
      const auto found = given.find(parameter.name);
      const bool is_given = found != given.end();
      const double value = is_given ? found->second : parameter.default_value.value_or(kUnknown);
      const bool is_known = is_given || parameter.default_value || !parameter.derived.empty();
      all = all && is_known && (!is_given || in_meaning(parameter, value));
      p.value.push_back(value);
      p.given.push_back(is_given ? 1 : 0);
    }
    if (all) all_ = model.completed(p);
  }

  /// NaN if the model has no such parameter with a unit, or it is not known: a plain number of one's own equations that
  /// is called "c" is no thickness.
  double operator()(const std::string& name) const {
    for (std::size_t k = 0; k < all_.size(); ++k) {
      if (info_.parameters[k].name == name && info_.parameters[k].unit != "1") return all_[k];
    }
    return kUnknown;
  }

 private:
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const ModelInfo& info_;
  std::vector<double> all_;
};

/// In ascending order, of the model's principal moments or of its tensor; NaN if it has none.
Eigen::Vector3d principal_moments(const Values& at) {
  Eigen::Vector3d moments(at("I_x"), at("I_y"), at("I_z"));
  if (!std::isnan(at("I_xx"))) {
    Eigen::Matrix3d tensor;
    tensor << at("I_xx"), at("I_xy"), at("I_xz"), at("I_xy"), at("I_yy"), at("I_yz"), at("I_xz"), at("I_yz"),
        at("I_zz");
    moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor, Eigen::EigenvaluesOnly).eigenvalues();
  }
  std::sort(moments.begin(), moments.end());
  return moments;
}

void doubt_moments(const Values& at, std::vector<std::string>& warnings) {
  const Eigen::Vector3d moments = principal_moments(at);
  if (moments[2] > kSlack * (moments[0] + moments[1])) {
    warnings.push_back(
        fmt::format("the moments of inertia are {:g}, {:g} and {:g} kg m^2: no body has one that exceeds the "
                    "sum of the other two",
                    moments[0], moments[1], moments[2]));
  }
  const double sphere = 0.25 * at("mass") * at("diameter") * at("diameter");
  const double a = at("chord"), b = at("thickness");
  const double rectangle = 0.25 * at("density") * a * b * (a * a + b * b);
  const auto doubt = [&](const char* name, const char* unit, double rim) {
    if (!(at(name) > kSlack * rim)) return;
    warnings.push_back(
        fmt::format("{} is {:g} {}, more than {:g}, which it would be with all mass at the rim", name,
                    at(name), unit, rim));
  };
  doubt("inertia", "kg m^2", sphere);
  doubt("moment_of_inertia", "kg m", rectangle);
}

void doubt_thickness(const Values& at, std::vector<std::string>& warnings) {
  const auto doubt = [&](const char* name, double width, const std::string& what) {
    if (!(at(name) > width)) return;
    warnings.push_back(fmt::format("{} is {:g} m, more than {}, {:g} m: were the two mixed up?", name,
                                   at(name), what, width));
  };
  doubt("thickness", std::sqrt(at("area") / std::numbers::pi), "the radius of a disc of that area");
  doubt("thickness", at("chord"), "the chord");
  doubt("semi_thickness", at("semi_chord"), "semi_chord");
  const double narrow = std::min(at("a"), at("b"));
  doubt("c", narrow, at("a") < at("b") ? "a" : "b");
}

}  // namespace

std::vector<std::string> density_warnings(double solid, double fluid) {
  std::vector<std::string> warnings;
  if (solid > 0.0 && solid < 20.0) {
    warnings.push_back(
        fmt::format("the solid has a density of {:g} kg/m^3: this looks like g/cm^3; {:g} kg/m^3?", solid,
                    1000.0 * solid));
  }
  if (fluid > 5.0 && fluid < 500.0) {
    warnings.push_back(
        fmt::format("the fluid has a density of {:g} kg/m^3, between those of gases and liquids", fluid));
  } else if ((fluid > 0.0 && fluid < 0.05) || fluid > 2e4) {
    warnings.push_back(fmt::format("the fluid has a density of {:g} kg/m^3; air has 1.2, water 998", fluid));
  }
  return warnings;
}

std::vector<std::string> parameter_warnings(const Model& model, const std::map<std::string, double>& values) {
  double solid = kAnySolid, fluid = kAnyFluid;
  std::vector<std::string> warnings;
  for (const ParameterInfo& parameter : model.info().parameters) {
    const auto given = values.find(parameter.name);
    if (given == values.end()) continue;
    if (parameter.name == "density" && parameter.unit == "kg/m^3") solid = given->second;
    if (parameter.name == "fluid_density" && parameter.unit == "kg/m^3") fluid = given->second;
    if (parameter.unit == "m" && given->second > kLongest) {
      warnings.push_back(
          fmt::format("{} is {:g} m: was it given in mm or cm?", parameter.name, given->second));
    }
  }
  const std::vector<std::string> of_densities = density_warnings(solid, fluid);
  warnings.insert(warnings.end(), of_densities.begin(), of_densities.end());
  const Values at(model, values);
  doubt_moments(at, warnings);
  doubt_thickness(at, warnings);
  return warnings;
}

}  // namespace samara::models

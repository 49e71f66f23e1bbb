#pragma once

#include <random>
#include <string>
#include <vector>

#include "samara/models/interface/model.h"

/// The parts of check_model(): each looks at one promise of a model and adds a sentence per broken one.
namespace samara::models {

using Findings = std::vector<std::string>;

std::string quoted(const std::string& text);

/// f and its derivatives at one point, by the model.
struct Point {
  double t = 0.0;
  std::vector<double> x;
  ParameterValues p;
  std::vector<double> f;
  Eigen::MatrixXd df_dx;
  Eigen::MatrixXd df_dp;
};

/// A value of a parameter within its meaning, never at its bound, where f need not be smooth.
double random_value(const ParameterInfo& parameter, std::mt19937& random);

/// The same point with all parameters given, f and its derivatives evaluated there.
Point with_all_given(const Model& model, const Point& point);

/// Per rate, the size of what it may be a small difference of: |f| and |df/dz| |z| over all states and
/// parameters z. Equalities between rates are asked for relative to it.
Eigen::VectorXd term_sizes(const Point& point);

/// Largest difference of two rates that should be equal, over their term sizes.
constexpr double kEqualRates = 1e-9;

/// Units that are no SI units: nothing else on units can be checked then.
void check_known_units(const ModelInfo& info, Findings& findings);
/// With the unit of length, mass or time changed, rates, derived defaults, forces and energy follow as their
/// units say.
void check_dimensions(const Model& model, const Point& point, std::mt19937& random, Findings& findings);

/// ModelInfo::affine_in holds names of parameters, and f is affine in them together.
void check_affinity(const Model& model, const Point& point, std::mt19937& random, Findings& findings);

/// Force terms are finite, and their powers sum to the rate of the kinetic energy where there is one.
void check_forces(const Model& model, const Point& point, double tolerance, Findings& findings);

/// Groups lie within the states and do not overlap; false if they do not.
bool check_groups(const ModelInfo& info, Findings& findings);
/// Quaternions keep their norm; where "rotation about z" is a symmetry, f turns with the groups.
void check_rotation(const Model& model, const Point& point, std::mt19937& random, Findings& findings);
/// Number of states in a group.
int group_size(StateGroupKind kind);

}  // namespace samara::models

#pragma once

#include <random>
#include <string>
#include <vector>

#include "samara/models/interface/model.h"

/// The parts of check_model(): each checks one law of a model and adds a sentence for each way in which it
/// fails.
namespace samara::models {

using Findings = std::vector<std::string>;

/// f and its derivatives at one point, by the model.
struct Point {
  double t = 0.0;
  std::vector<double> x;
  ParameterValues p;
  std::vector<double> f;
  Eigen::MatrixXd df_dx;
  Eigen::MatrixXd df_dp;
};

/// States within two scales of zero, parameters within their meaning, some of them left to their defaults.
Point random_point(const Model& model, std::mt19937& random);

/// A value of a parameter within its meaning, never at its bound, where f need not be smooth.
double random_value(const ParameterInfo& parameter, std::mt19937& random);

/// The same point with all parameters given, f and its derivatives evaluated there.
Point with_all_given(const Model& model, const Point& point);

/// Per rate, the size of what it may be a small difference of: |f| and |df/dz| |z| over all states and
/// parameters z. Equalities between rates are asked for relative to it.
Eigen::VectorXd term_sizes(const Point& point);

/// Largest difference of two rates that should be equal, over their term sizes.
constexpr double kEqualRates = 1e-9;

}  // namespace samara::models

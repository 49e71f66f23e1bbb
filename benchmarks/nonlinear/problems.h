#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/plan/plan.h"
#include "samara/codebooks/source/model_system.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/pgd/evolution/evolution_problem.h"
#include "samara/pgd/evolution/polynomial_system.h"

/// The problems of this benchmark, and how errors are measured.
namespace samara::benchmarks {

/// A free coordinate with its interval.
struct Interval {
  std::string name;
  double lower = 0.0;
  double upper = 1.0;
};

/// A box of a model's free coordinates, with the system the engine solves: the model itself, or the same
/// equations as a polynomial of some of the states.
struct Problem {
  std::shared_ptr<models::ParametricModel> model;
  std::shared_ptr<const pgd::EvolutionSystem> system;
  std::vector<Interval> box;
  std::vector<int> states;  ///< of the system: which of the model's
  double end = 1.0;

  /// On a fixed grid.
  pgd::EvolutionProblem on(int slabs, int time_points, int nodes) const;
};

/// (6.20), C_D in [0.5, 2], as a polynomial.
Problem quadratic_drag(double end);
/// (6.22) over initial values in [0, 1]^3, as a polynomial.
Problem triple_product(double end);
/// The reference plate over C_T, C_R, A; translations are left out: nothing depends on them.
Problem plate3(double end);
/// The reference plate over C_T and C_R, at its terminal speed broadside on but for a tilt. The last state is
/// that broadside fall.
Problem broadside_plate(double tilt, double end);
Eigen::VectorXd broadside_fall();
/// (6.24) of an ellipsoid in water over six initial velocities, as a polynomial.
Problem kirchhoff(double end);

/// The reference plate with 3, 5 or 7 free coordinates as a plan, by slabs.
codebooks::Plan plate_plan(int coordinates, double end, double tolerance);

/// Errors of states at random points of box and time, against CVODES at tight tolerance.
struct Errors {
  Eigen::VectorXd largest;       ///< over the range of the state at these points
  Eigen::VectorXd relative_rms;  ///< over that of the state
  Eigen::VectorXd absolute;      ///< largest, SI
};
/// @param value the states at (time, parameters..)
Errors errors_of(const Problem& problem, const std::function<Eigen::VectorXd(std::span<const double>)>& value,
                 double end, int points);

}  // namespace samara::benchmarks

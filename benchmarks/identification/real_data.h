#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "report.h"
#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"
#include "samara/pgd/tensors/random.h"

/// What cases with measured captures share.
namespace samara::benchmarks::identification {

/// Where the measurements of a case lie, which the project does not contain: a folder in the one to which the
/// environment variable SAMARA_DATA leads. Empty if the case is not wanted, and, with a line on stderr, where
/// there is none.
std::optional<std::filesystem::path> measured_set(const Options& options, const std::string& test_case,
                                                  const std::string& set);

using Box = std::map<std::string, samara::models::Interval>;
using Coefficients = std::map<std::string, double>;

/// Frames first, first + 1, .. of a capture as one of its own, whose times count from `origin` [s].
samara::identification::Capture frames_of(const samara::identification::Capture& capture, Eigen::Index first,
                                          Eigen::Index count, double origin = 0.0);

/// The positions of a capture, frames x (x, y, z).
Eigen::MatrixX3d positions_of(const samara::identification::Capture& capture);

Coefficients values_of(const samara::identification::FitResult& result);
/// Value of a coefficient of a fit that has it.
double value_of(const samara::identification::FitResult& result, const std::string& name);
double error_of(const samara::identification::FitResult& result, const std::string& name);

/// What fits of a case claim, held to each other: whether they converge, and whether disjoint halves of the
/// data agree within what is said.
class Claims {
 public:
  void add(const samara::identification::FitResult& result);
  /// Two fits of disjoint captures, not added yet. A coefficient counts where both give it an error, and as
  /// one that disagrees where no value of the one (another optimum counts) is within two errors of one of the
  /// other.
  void add_halves(const samara::identification::FitResult& one,
                  const samara::identification::FitResult& other);

  double converged_fraction() const;
  double halves_beyond_two_errors() const;

 private:
  int fits_ = 0, converged_ = 0;
  int compared_ = 0, beyond_ = 0;
};

/// 0, 1, .. count - 1 in a random order: which motions are fitted, and which are asked about.
std::vector<std::size_t> random_order(std::size_t count, pgd::Random& random);

double median_of(std::vector<double> values);
double rms_of(const std::vector<double>& values);

}  // namespace samara::benchmarks::identification

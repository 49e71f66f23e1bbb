#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/forecasts/covariant_kernel.h"

/// Regression that turns with the motion: what it learned holds however a motion is turned about the vertical, and for
/// its mirror image; with views, for quarter turns and mirror images.
///
/// A moment has level features a, others b that do not turn and views v, each in units of its deviation, and the
/// kernels are those of covariant_kernel.h between features times weights w, in lengths h: w a/h, w b/h and w v/h. With
/// k_n of a moment j, and k_n' of its mirror image, values that turn are
///
///     sum_k beta_k a_k + sum_j (k_1 c_j + k_1' c_j*)/2,  beta real, c_j complex,
///
/// and others gamma_0 + sum_k gamma_k b_k + sum_k delta_k (v_k of both views) + sum_j (k_0 + k_0') d_j/2. Coefficients
/// have the least sum of squares over all training moments and the penalty r (c . K c + |beta|^2/30), K the kernel
/// between the centres j: moments, or every so many of them (regression on a subset; Rasmussen and Williams, Gaussian
/// Processes for Machine Learning, 2006, section 8.3.1). The length h and the ridge r of either kind of values are
/// those with which parts of the training predict the others best.
namespace samara::identification {

/// Numbers of a moment (covariant_kernel.h).
struct Turning {
  Eigen::VectorXcd level = {};
  Eigen::VectorXd others = {};
  Eigen::VectorXcd views = {};  ///< none of values
};

class CovariantRegression {
 public:
  /// So many moments at most, and so many centres; of more, every so many in the order of the parts. Length and ridge
  /// are chosen with fewer.
  static constexpr Eigen::Index kMost = 4000, kCentres = 600, kChoosing = 600, kChoosingCentres = 150;

  /// What the kernel takes features times: 0 for those of which it sees nothing.
  struct Weights {
    Eigen::VectorXd level = {}, others = {}, views = {};
  };

  /// @param features, values of each moment, as many for all
  /// @param parts of the training, from 0, to which the moments belong
  /// @throws ArgumentError for sizes that differ and numbers that are not finite
  static CovariantRegression fit(std::span<const Turning> features, std::span<const Turning> values,
                                 std::span<const std::size_t> parts, const Weights& weights);

  /// Whether there were two parts or more to choose by, and the equations could be solved.
  bool is_fitted() const { return level_.length > 0.0; }
  /// Of values that turn.
  double length() const { return level_.length; }
  double ridge() const { return level_.ridge; }

  /// @throws ArgumentError before a fit, and for features of other numbers than those of the training
  Turning at(const Turning& features) const;
  /// The same by coefficients found without a part of the training.
  Turning without(std::size_t part, const Turning& features) const;

 private:
  /// What is found of one kind of values.
  struct Found {
    double length = 0.0, ridge = 0.0;
    Eigen::MatrixXd coefficients = {};          ///< terms x values
    std::vector<Eigen::MatrixXd> without = {};  ///< each part
  };
  struct Steps;  ///< of the fit

  /// The common mean of both views, as seen in both.
  Eigen::RowVectorXcd in_both_views() const;
  /// Features in units of their deviation.
  TurningRows scaled(TurningRows features) const;
  /// These as the kernel takes them: times weights, in lengths.
  TurningRows in_kernel(const TurningRows& rows, double length) const;
  /// Terms of values that turn, rows of their real parts and below them of their imaginary ones.
  Eigen::MatrixXd level_terms(const TurningRows& rows, double length) const;
  Eigen::MatrixXd other_terms(const TurningRows& rows, double length) const;
  Turning values_at(const Turning& features, const Eigen::MatrixXd& level,
                    const Eigen::MatrixXd& others) const;

  Weights weights_ = {};
  Eigen::RowVectorXd level_width_ = {}, middle_ = {}, width_ = {}, view_middle_ = {}, view_width_ = {};
  TurningRows centres_ = {};
  Found level_ = {}, others_ = {};
};

}  // namespace samara::identification

#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/forecasts/recent_motion.h"

/// What a prediction misses, as it missed it in moments like the one that is asked about: ridge regression with a
/// Gaussian kernel that knows a mirror.
///
/// A moment m has features, even ones e and odd ones o, each in units of its deviation; its mirror image m' has the odd
/// ones with the other sign. With
///
///     k(m, n) = exp(-(|e_m - e_n|^2 + |o_m - o_n|^2)/(2 N h^2)),   N the number of features,
///
/// even values at m are sum_j c_j (k(m, m_j) + k(m, m_j')), odd ones sum_j c_j (k(m, m_j) - k(m, m_j')) over training
/// moments j, with coefficients of (K + r) c = y. So the mirror image of a moment has the mirror image of its values,
/// and far from all training both are 0. The length h and the ridge r are those with which parts of the training
/// predict the others best. If none is better than no correction, there is none.
namespace samara::identification {

class KernelCorrection {
 public:
  /// So many moments at most. Of more, every so many in the order of parts and features are taken; length and ridge are
  /// chosen with fewer.
  static constexpr Eigen::Index kMost = 4000, kChoosing = 600;
  /// Of more moments than the first number, whose cube is what a fit costs, so many are centres m_j: every so many.
  /// Their coefficients have the least sum of squares over all moments with the ridge's penalty (regression on a
  /// subset; Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, section 8.3.1).
  static constexpr Eigen::Index kExact = 2000, kCentres = 600;

  /// @param features, values of each moment, as many for all; values farther than four times the median distance
  ///   from 0 count as being there
  /// @param parts of the training, from 0, to which the moments belong
  /// @throws ArgumentError for sizes that differ and numbers that are not finite
  static KernelCorrection fit(std::span<const Mirrored> features, std::span<const Mirrored> values,
                              std::span<const std::size_t> parts);

  /// Whether it helps: else all values are 0.
  bool is_fitted() const { return length_ > 0.0; }
  double length() const { return length_; }
  double ridge() const { return ridge_; }

  Mirrored at(const Mirrored& features) const;
  /// The same by coefficients found without a part of the training.
  Mirrored without(std::size_t part, const Mirrored& features) const;

 private:
  struct Centres {
    Eigen::MatrixXd even = {}, odd = {};  ///< features in units of their deviation, a row each
  };
  struct Coefficients {
    Eigen::MatrixXd even = {}, odd = {};  ///< moments x values
  };
  struct Steps;  ///< of the fit
  Mirrored values_at(const Coefficients& coefficients, const Mirrored& features) const;
  Centres scaled(const Mirrored& features) const;

  Eigen::RowVectorXd middle_ = {}, even_width_ = {}, odd_width_ = {};
  Eigen::Index even_values_ = 0, odd_values_ = 0;
  double count_ = 0.0;  ///< of features that vary
  Centres centres_ = {};
  double length_ = 0.0, ridge_ = 0.0;
  Coefficients coefficients_ = {};
  std::vector<Coefficients> without_ = {};  ///< each part
};

}  // namespace samara::identification

#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "samara/pgd/fields/train_field.h"

namespace samara::pgd {

struct RoundedField {
  TrainField field;
  double error = 0.0;  ///< largest change of an output seen, over its scale
};

/// A train of fewer numbers: ranks are cut by singular values until outputs change by as much as `tolerance`
/// of their scale at some of a few thousand points of the box, in its inside, at its borders and near the
/// centres. Singular values know the mean square over all nodes only; how much of it is allowed is found by
/// trial.
/// @param scale per output, positive
/// @param centres axes x points: where narrow features are, which points of the whole box do not see
/// @throws ArgumentError if sizes or numbers are not as said
RoundedField rounded(const TrainField& field, const Eigen::VectorXd& scale, double tolerance,
                     std::uint64_t seed, const Eigen::MatrixXd& centres = {});

}  // namespace samara::pgd

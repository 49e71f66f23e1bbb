#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/certify/certify_field.h"
#include "samara/codebooks/certify/point_errors.h"
#include "samara/codebooks/query/query.h"

namespace samara::codebooks {

/// A field at a point of its parameters and all times and places of its certificate. One per thread; the
/// codebook must outlive it.
class FieldAnswers {
 public:
  /// @param times of the certificate; empty where the codebook has no time
  /// @throws ArgumentError unless the codebook has one coordinate of space
  FieldAnswers(const Codebook& book, std::vector<double> times, Eigen::VectorXd places);

  /// @param q the coordinates but time; that of space does not count
  PointErrors compare(std::span<const double> q, const FieldReference& reference);

 private:
  Eigen::Index rows() const;  ///< times, or one
  /// Into values_, at the parameters that points_ holds.
  void ask();

  Query query_;
  std::vector<double> times_;
  Eigen::VectorXd places_;
  Eigen::Index space_;  ///< row of the points
  Eigen::Index first_;  ///< of the rows that are no time
  Eigen::Index places_at_once_ = 1;
  Eigen::MatrixXd points_;    ///< coordinates x (times x places at once), times running fastest
  Eigen::MatrixXd values_;    ///< 1 x (times x places)
  std::vector<double> rest_;  ///< the coordinates but time and space
};

}  // namespace samara::codebooks

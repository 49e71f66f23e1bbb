#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/certify/certify_field.h"
#include "samara/codebooks/certify/point_errors.h"
#include "samara/codebooks/query/query.h"

namespace samara::codebooks {

/// A field at a point of its parameters and all times and places of its certificate. What it keeps are blocks of some
/// times at all places. One per thread; the codebook must outlive it.
class FieldAnswers {
 public:
  /// @param times of the certificate; empty where the codebook has no time
  /// @throws ArgumentError unless the codebook has one coordinate of space
  FieldAnswers(const Codebook& book, std::vector<double> times, Eigen::VectorXd places);

  /// @param q the coordinates but time; that of space does not count
  PointErrors compare(std::span<const double> q, const FieldReference& reference);

 private:
  Eigen::Index rows() const;  ///< times, or one
  /// The codebook at some of the times, at the parameters that points_ holds, and a block of the reference.
  void compare_block(Eigen::Index first_time, const Eigen::Ref<const Eigen::MatrixXd>& expected,
                     PointErrors& errors);
  /// @throws ArgumentError unless a reference gave all times and places
  void check_size(Eigen::Index rows_given, Eigen::Index places_given) const;

  Query query_;
  std::vector<double> times_;
  Eigen::VectorXd places_;
  Eigen::Index space_;  ///< row of the points
  Eigen::Index first_;  ///< of the rows that are no time
  Eigen::Index times_at_once_ = 1, places_at_once_ = 1;
  Eigen::MatrixXd points_;    ///< coordinates x (times at once x places at once), times running fastest
  Eigen::MatrixXd values_;    ///< 1 x (times at once x places)
  Eigen::MatrixXd expected_;  ///< times at once x places, of a reference that gives time by time
  std::vector<double> rest_;  ///< the coordinates but time and space
};

}  // namespace samara::codebooks

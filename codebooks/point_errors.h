#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/certificate.h"
#include "samara/codebooks/codebook.h"
#include "samara/codebooks/query.h"

/// What every certificate is made of, whatever the codebook is compared with.
namespace samara::codebooks {

struct CertifyOptions;

/// Per output, what one parameter point contributes.
struct PointErrors {
  bool usable = false;
  std::string failure;  ///< of what the codebook is compared with
  Eigen::VectorXd max_error, sum_error2, sum_value2, smallest, largest;
  std::vector<int> worst_time;
};

/// Times between the builder's nodes and at its borders: twice as many in every time element as it has nodes;
/// none where the codebook has no time.
std::vector<double> certificate_times(const Codebook& book);

/// Scrambled Sobol' points of the box: parameters x count. Of lists, each value as often as the others.
Eigen::MatrixXd certificate_points(const Codebook& book, int count, std::uint64_t seed);

/// A codebook at a point and all times of its certificate. One per thread; the codebook must outlive it.
class CertifiedAnswers {
 public:
  CertifiedAnswers(const Codebook& book, const std::vector<double>& times);
  /// times x outputs; without time, one row
  const Eigen::MatrixXd& at(std::span<const double> q);

 private:
  std::variant<Query, TrajectoryQuery> query_;
  Eigen::MatrixXd values_;
  Eigen::VectorXd at_point_;
};

/// @param reference as values, in the same order
PointErrors compare(const Eigen::MatrixXd& values, const Eigen::MatrixXd& reference);

/// Puts the points' errors together, in the order of the points; points that were not compared count as
/// failed. What the errors are against is the caller's to say.
Certificate certificate_of(const std::vector<PointErrors>& errors, const Codebook& book,
                           const CertifyOptions& options, const Eigen::MatrixXd& q,
                           const std::vector<double>& times);

}  // namespace samara::codebooks

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/attitude_length.h"
#include "samara/codebooks/book/certificate.h"
#include "samara/codebooks/book/certificate_points.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"

/// Errors at single points, and their summary as a certificate, whatever the codebook is compared with.
namespace samara::codebooks {

struct CertifyOptions;

/// Errors and ranges of one output at one parameter point.
struct PointErrors {
  bool usable = false;
  std::string failure;  ///< of what the codebook is compared with
  Eigen::VectorXd max_error, sum_error2, sum_value2, smallest, largest;
  std::vector<int> worst_time;
  double max_norm_defect = 0.0, sum_norm_defect2 = 0.0;  ///< where there is a quaternion
  /// Of a field, which is compared everywhere in space at once: the place of the largest error.
  std::optional<double> worst_place = {};
};

/// Compares answers (rows x outputs) with a reference; worst_time counts rows.
PointErrors compared_rows(const Eigen::MatrixXd& values, const Eigen::MatrixXd& reference);

/// A codebook at a point and all times of its certificate. One per thread; the codebook must outlive it.
class CertifiedAnswers {
 public:
  CertifiedAnswers(const Codebook& book, const std::vector<double>& times);
  /// @param reference times x outputs; without time, one row
  PointErrors compare(std::span<const double> q, const Eigen::MatrixXd& reference);

 private:
  /// Into values_, quaternions as they are stored.
  void ask(std::span<const double> q);
  /// Of values_ as they are stored, against the length with which the reference begins.
  void measure_norms(const Eigen::MatrixXd& reference, PointErrors& errors) const;

  std::variant<Query, TrajectoryQuery> query_;
  std::optional<std::array<int, 4>> quaternion_;  ///< places among the outputs
  std::optional<AttitudeLength> attitude_;
  Eigen::MatrixXd values_;
  Eigen::VectorXd at_point_;
};

/// What the errors of every output are divided by (pgd/fields/error_scale.h), from its values over points and
/// times; empty where no point was compared.
Eigen::VectorXd error_scales(const std::vector<PointErrors>& errors, const Codebook& book,
                             const CertifyOptions& options);

/// The largest error of a point that was compared, over the outputs and their scales.
double largest_over_scales(const PointErrors& point, const Eigen::VectorXd& scales);

/// Points with their errors, which has fewer entries where later points were not asked.
struct ComparedPoints {
  Eigen::MatrixXd q;  ///< parameters x points
  std::vector<PointErrors> errors;
};

/// Puts the points' errors together, in the order of the points; points that were not compared count as
/// failed. Ends of climbs count for the largest errors only; without their errors nothing is met. What the
/// errors are against is the caller's to say.
Certificate certificate_of(const ComparedPoints& points, const ComparedPoints& climbs, const Codebook& book,
                           const CertifyOptions& options, const std::vector<double>& times);

}  // namespace samara::codebooks

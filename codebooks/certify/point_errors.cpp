#include "samara/codebooks/certify/point_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/codebooks/source/model_measure.h"
#include "samara/pgd/fields/error_scale.h"

namespace samara::codebooks {

namespace {

/// Takes the largest error of one output among points, and where it is.
/// @param space the codebook's coordinate of space
void take_largest(const ComparedPoints& points, int output, const std::vector<double>& times,
                  std::optional<int> space, OutputError& result) {
  for (std::size_t i = 0; i < points.errors.size(); ++i) {
    const PointErrors& errors = points.errors[i];
    if (!errors.usable) continue;
    if (!result.worst.empty() && !(errors.max_error[output] > result.max_si)) continue;
    result.max_si = errors.max_error[output];
    result.worst.clear();
    const int worst_time = errors.worst_time[static_cast<std::size_t>(output)];
    if (!times.empty()) result.worst.push_back(times[static_cast<std::size_t>(worst_time)]);
    const auto q = points.q.col(static_cast<Eigen::Index>(i));
    result.worst.insert(result.worst.end(), q.begin(), q.end());
    if (errors.worst_place) result.worst[static_cast<std::size_t>(*space)] = *errors.worst_place;
  }
}

/// Puts the points' errors of one output together. @param range what its errors are divided by
OutputError summarise(const ComparedPoints& points, const ComparedPoints& climbs, int output,
                      const pgd::OutputLabel& label, double range, const std::vector<double>& times,
                      std::optional<int> space) {
  OutputError result;
  result.name = label.name;
  result.unit = label.unit;
  double error2 = 0.0;
  double value2 = 0.0;
  std::vector<double> largest;
  for (const PointErrors& errors : points.errors) {
    if (!errors.usable) continue;
    error2 += errors.sum_error2[output];
    value2 += errors.sum_value2[output];
    largest.push_back(errors.max_error[output]);
  }
  if (largest.empty()) {
    result.range = result.max = result.p95 = result.mean = result.rms = result.max_si =
        std::numeric_limits<double>::quiet_NaN();
    return result;
  }
  take_largest(points, output, times, space, result);
  take_largest(climbs, output, times, space, result);
  result.range = range;
  result.max = result.max_si / range;
  std::sort(largest.begin(), largest.end());
  double sum = 0.0;
  for (const double e : largest) sum += e;
  result.mean = sum / static_cast<double>(largest.size()) / range;
  result.p95 =
      largest[static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(largest.size()))) - 1] / range;
  result.rms = value2 > 0.0 ? std::sqrt(error2 / value2) : std::sqrt(error2);
  return result;
}

/// NaN from a broken codebook must not hide: it counts as infinite.
double distance(double a, double b) {
  const double distance = std::abs(a - b);
  return std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance;
}

std::vector<int> all_outputs(const Codebook& book) {
  std::vector<int> all(static_cast<std::size_t>(book.output_count()));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// Of the points that were compared, each at as many times.
NormDefect norm_defect(const std::vector<PointErrors>& all, std::size_t times) {
  NormDefect result;
  double sum = 0.0;
  std::size_t count = 0;
  for (const PointErrors& point : all) {
    if (!point.usable) continue;
    result.max = std::max(result.max, point.max_norm_defect);
    sum += point.sum_norm_defect2;
    count += std::max<std::size_t>(1, times);
  }
  if (count == 0) result.max = std::numeric_limits<double>::quiet_NaN();
  result.rms = std::sqrt(sum / static_cast<double>(count));
  return result;
}

}  // namespace

PointErrors compared_rows(const Eigen::MatrixXd& values, const Eigen::MatrixXd& reference) {
  PointErrors errors;
  const Eigen::Index outputs = values.cols();
  errors.usable = true;
  errors.max_error.resize(outputs);
  errors.worst_time.resize(static_cast<std::size_t>(outputs));
  errors.sum_error2.resize(outputs);
  errors.sum_value2.resize(outputs);
  errors.smallest.resize(outputs);
  errors.largest.resize(outputs);
  for (Eigen::Index o = 0; o < outputs; ++o) {
    const Eigen::VectorXd difference = values.col(o).binaryExpr(reference.col(o), &distance);
    Eigen::Index worst = 0;
    errors.max_error[o] = difference.maxCoeff(&worst);
    errors.worst_time[static_cast<std::size_t>(o)] = static_cast<int>(worst);
    errors.sum_error2[o] = difference.squaredNorm();
    errors.sum_value2[o] = reference.col(o).squaredNorm();
    errors.smallest[o] = reference.col(o).minCoeff();
    errors.largest[o] = reference.col(o).maxCoeff();
  }
  return errors;
}

double largest_over_scales(const PointErrors& point, const Eigen::VectorXd& scales) {
  return point.max_error.cwiseQuotient(scales).maxCoeff();
}

CertifiedAnswers::CertifiedAnswers(const Codebook& book, const std::vector<double>& times)
    : query_([&]() -> std::variant<Query, TrajectoryQuery> {
        const QueryOptions options{.as_stored = true};
        if (book.has_time()) return TrajectoryQuery(book, times, options);
        return Query(book, options);
      }()),
      quaternion_(quaternion_places(book, all_outputs(book))),
      attitude_(AttitudeLength::of(book, all_outputs(book))),
      values_(static_cast<Eigen::Index>(std::max<std::size_t>(1, times.size())), book.output_count()),
      at_point_(book.output_count()) {}

void CertifiedAnswers::ask(std::span<const double> q) {
  if (auto* trajectory = std::get_if<TrajectoryQuery>(&query_)) {
    trajectory->values(q, values_);
  } else {
    std::get<Query>(query_).values(q, at_point_);
    values_ = at_point_.transpose();
  }
}

void CertifiedAnswers::measure_norms(const Eigen::MatrixXd& reference, PointErrors& errors) const {
  const double start = reference(0, *quaternion_).norm();
  const Eigen::VectorXd lengths = values_(Eigen::all, *quaternion_).rowwise().norm();
  const Eigen::VectorXd defects =
      (lengths / start).unaryExpr([](double length) { return distance(length, 1.0); });
  errors.max_norm_defect = defects.maxCoeff();
  errors.sum_norm_defect2 = defects.squaredNorm();
}

PointErrors CertifiedAnswers::compare(std::span<const double> q, const Eigen::MatrixXd& reference) {
  ask(q);
  PointErrors norms;
  if (quaternion_) measure_norms(reference, norms);
  double* const columns = values_.data();
  if (attitude_) attitude_->restore(&columns, 0, 0, static_cast<int>(values_.rows()));
  PointErrors errors = compared_rows(values_, reference);
  errors.max_norm_defect = norms.max_norm_defect;
  errors.sum_norm_defect2 = norms.sum_norm_defect2;
  return errors;
}

Eigen::VectorXd error_scales(const std::vector<PointErrors>& errors, const Codebook& book,
                             const CertifyOptions& options) {
  Eigen::VectorXd smallest, largest;
  for (const PointErrors& point : errors) {
    if (!point.usable) continue;
    smallest = smallest.size() == 0 ? point.smallest : smallest.cwiseMin(point.smallest).eval();
    largest = largest.size() == 0 ? point.largest : largest.cwiseMax(point.largest).eval();
  }
  return pgd::error_scales(smallest, largest,
                           {.floors = floors_of(options.absolute, book.outputs()),
                            .sizes = floors_of(options.sizes, book.outputs())});
}

Certificate certificate_of(const ComparedPoints& points, const ComparedPoints& climbs, const Codebook& book,
                           const CertifyOptions& options, const std::vector<double>& times) {
  const std::vector<PointErrors>& errors = points.errors;
  Certificate certificate;
  certificate.tolerance = options.tolerance;
  certificate.points = options.points;
  certificate.times = static_cast<int>(times.size());
  certificate.seed = options.seed;
  certificate.climbed_points = static_cast<int>(climbs.errors.size());
  certificate.failed_points =
      static_cast<int>(options.points - std::count_if(errors.begin(), errors.end(),
                                                      [](const PointErrors& e) { return e.usable; }));
  const auto first_failure =
      std::find_if(errors.begin(), errors.end(), [](const PointErrors& e) { return !e.failure.empty(); });
  if (first_failure != errors.end()) certificate.failure = first_failure->failure;
  // Climbs that were broken off leave what stands out unexplained.
  const bool has_climbed = static_cast<Eigen::Index>(climbs.errors.size()) == climbs.q.cols();
  certificate.met = certificate.failed_points == 0 && has_climbed;
  if (certificate.failed_points == options.points)
    certificate.max_error = std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd scales = error_scales(errors, book, options);
  for (int o = 0; o < book.output_count(); ++o) {
    const double range = scales.size() == 0 ? 0.0 : scales[o];
    certificate.outputs.push_back(summarise(points, climbs, o, book.outputs()[static_cast<std::size_t>(o)],
                                            range, times, book.space()));
    const double error = certificate.outputs.back().max;
    if (error > certificate.max_error) certificate.max_error = error;
    certificate.met = certificate.met && error <= options.tolerance;
  }
  if (options.tolerance > 0.0) {
    certificate.wrong_points =
        certificate.failed_points +
        static_cast<int>(std::count_if(errors.begin(), errors.end(), [&](const auto& e) {
          return e.usable && !(largest_over_scales(e, scales) <= options.tolerance);
        }));
  }
  if (quaternion_places(book, all_outputs(book))) certificate.norm_defect = norm_defect(errors, times.size());
  return certificate;
}

}  // namespace samara::codebooks

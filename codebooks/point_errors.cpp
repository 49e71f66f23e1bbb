#include "samara/codebooks/point_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "samara/codebooks/certify.h"
#include "samara/codebooks/sobol_points.h"

namespace samara::codebooks {

namespace {

/// The values of a coordinate that is a list in some piece, ascending; empty for an interval.
std::vector<double> listed_values(const Codebook& book, std::size_t coordinate) {
  std::set<double> values;
  for (const Piece& piece : book.pieces()) {
    const pgd::Axis& axis = piece.groups().front().axes()[coordinate];
    if (axis.basis() == pgd::Basis::discrete || axis.basis() == pgd::Basis::imported)
      values.insert(axis.nodes().begin(), axis.nodes().end());
  }
  return {values.begin(), values.end()};
}

/// Puts the points' errors of one output together, in the order of the points.
OutputError summarise(const std::vector<PointErrors>& all, int output, const Codebook& book, double floor,
                      const Eigen::MatrixXd& q, const std::vector<double>& times) {
  const pgd::OutputLabel& label = book.outputs()[static_cast<std::size_t>(output)];
  OutputError result;
  result.name = label.name;
  result.unit = label.unit;
  double smallest = std::numeric_limits<double>::infinity();
  double largest = -smallest;
  double error2 = 0.0;
  double value2 = 0.0;
  std::vector<double> errors;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].usable) continue;
    smallest = std::min(smallest, all[i].smallest[output]);
    largest = std::max(largest, all[i].largest[output]);
    error2 += all[i].sum_error2[output];
    value2 += all[i].sum_value2[output];
    errors.push_back(all[i].max_error[output]);
    if (result.worst.empty() || errors.back() > result.max_si) {
      result.max_si = errors.back();
      result.worst.clear();
      const int worst_time = all[i].worst_time[static_cast<std::size_t>(output)];
      if (!times.empty()) result.worst.push_back(times[static_cast<std::size_t>(worst_time)]);
      for (Eigen::Index k = 0; k < q.rows(); ++k) result.worst.push_back(q(k, static_cast<Eigen::Index>(i)));
    }
  }
  if (errors.empty()) {
    result.range = result.max = result.p95 = result.mean = result.rms = result.max_si =
        std::numeric_limits<double>::quiet_NaN();
    return result;
  }
  result.range = std::max(largest - smallest, floor);
  const double scale = result.range > 0.0 ? result.range : 1.0;
  result.max = result.max_si / scale;
  std::sort(errors.begin(), errors.end());
  double sum = 0.0;
  for (const double e : errors) sum += e;
  result.mean = sum / static_cast<double>(errors.size()) / scale;
  result.p95 =
      errors[static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(errors.size()))) - 1] / scale;
  result.rms = value2 > 0.0 ? std::sqrt(error2 / value2) : std::sqrt(error2);
  return result;
}

/// NaN from a broken codebook must not hide: it counts as infinite.
double distance(double a, double b) {
  const double distance = std::abs(a - b);
  return std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance;
}

/// @param reference as values, in the same order
void compare_outputs(const Eigen::MatrixXd& values, const Eigen::MatrixXd& reference, PointErrors& errors) {
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

std::vector<double> certificate_times(const Codebook& book) {
  std::vector<double> times;
  if (!book.has_time()) return times;
  for (const Piece& piece : book.pieces()) {
    const pgd::Axis& time = piece.groups().front().axes().front();
    const int per_element = 2 * time.degree() + 1;
    for (int e = 0; e < time.elements(); ++e) {
      for (int i = 0; i < per_element; ++i) {
        const double fraction = static_cast<double>(i) / per_element;
        const double left = time.borders()[e];
        const double width = transformed_distance(time.transform(), left, time.borders()[e + 1]);
        times.push_back(transformed_advance(time.transform(), left, fraction * width));
      }
    }
    times.push_back(time.upper());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

Eigen::MatrixXd certificate_points(const Codebook& book, int count, std::uint64_t seed) {
  Eigen::MatrixXd q = sobol_points(static_cast<int>(book.parameters().size()), count, seed);
  for (Eigen::Index k = 0; k < q.rows(); ++k) {
    const Coordinate& c = book.parameters()[static_cast<std::size_t>(k)];
    const std::size_t coordinate = static_cast<std::size_t>(k) + (book.has_time() ? 1 : 0);
    const std::vector<double> values = listed_values(book, coordinate);
    for (double& u : q.row(k)) {
      u = values.empty() ? c.lower + u * (c.upper - c.lower)
                         : values[static_cast<std::size_t>(u * static_cast<double>(values.size()))];
    }
  }
  return q;
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
  PointErrors errors;
  ask(q);
  if (quaternion_) measure_norms(reference, errors);
  double* const columns = values_.data();
  if (attitude_) attitude_->restore(&columns, 0, 0, static_cast<int>(values_.rows()));
  compare_outputs(values_, reference, errors);
  return errors;
}

Certificate certificate_of(const std::vector<PointErrors>& errors, const Codebook& book,
                           const CertifyOptions& options, const Eigen::MatrixXd& q,
                           const std::vector<double>& times) {
  Certificate certificate;
  certificate.tolerance = options.tolerance;
  certificate.points = options.points;
  certificate.times = static_cast<int>(times.size());
  certificate.seed = options.seed;
  certificate.failed_points = static_cast<int>(
      std::count_if(errors.begin(), errors.end(), [](const PointErrors& e) { return !e.usable; }));
  const auto first_failure =
      std::find_if(errors.begin(), errors.end(), [](const PointErrors& e) { return !e.failure.empty(); });
  if (first_failure != errors.end()) certificate.failure = first_failure->failure;
  certificate.met = certificate.failed_points == 0;
  if (certificate.failed_points == options.points)
    certificate.max_error = std::numeric_limits<double>::quiet_NaN();
  for (int o = 0; o < book.output_count(); ++o) {
    const auto floor = options.absolute.find(book.outputs()[static_cast<std::size_t>(o)].name);
    certificate.outputs.push_back(
        summarise(errors, o, book, floor == options.absolute.end() ? 0.0 : floor->second, q, times));
    const double error = certificate.outputs.back().max;
    if (error > certificate.max_error) certificate.max_error = error;
    certificate.met = certificate.met && error <= options.tolerance;
  }
  if (quaternion_places(book, all_outputs(book))) certificate.norm_defect = norm_defect(errors, times.size());
  return certificate;
}

}  // namespace samara::codebooks

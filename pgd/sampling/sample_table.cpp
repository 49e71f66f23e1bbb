#include "samara/pgd/sampling/sample_table.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/fields/error_scale.h"
#include "samara/pgd/sampling/leja.h"

namespace samara::pgd {

SampledFunction::SampledFunction(const std::vector<SampledCoordinate>& coordinates,
                                 const std::vector<OutputLabel>& outputs, const PointsFunction& function,
                                 const SamplingOptions& options)
    : coordinates_(coordinates), outputs_(outputs), function_(function), options_(options) {
  const auto count = static_cast<Eigen::Index>(outputs.size());
  smallest_.setConstant(count, std::numeric_limits<double>::infinity());
  largest_ = -smallest_;
}

double SampledFunction::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::string SampledFunction::described(const Eigen::VectorXd& point) const {
  std::string text;
  for (std::size_t k = 0; k < coordinates_.size(); ++k) {
    const Axis::Label& label = coordinates_[k].label;
    text +=
        fmt::format("{}{} = {:.9g}{}{}", k == 0 ? "" : ", ", label.name, point[static_cast<Eigen::Index>(k)],
                    label.unit == "1" ? "" : " ", label.unit == "1" ? "" : label.unit);
  }
  return text;
}

Eigen::VectorXd SampledFunction::scale() const {
  return error_scales(smallest_, largest_, {.floors = options_.absolute});
}

void SampledFunction::check_limits(Eigen::Index more) {
  if (calls_ + more > options_.max_calls) {
    throw SamplingStopped(
        {Termination::max_calls, fmt::format("{} calls of the {} allowed were used, {} more were needed",
                                             calls_, options_.max_calls, more)});
  }
  if (options_.max_seconds > 0.0 && seconds() >= options_.max_seconds) {
    throw SamplingStopped(
        {Termination::max_seconds, fmt::format("the {} s allowed are used up", options_.max_seconds)});
  }
  if (options_.progress && !options_.progress({"sampling", fraction_})) {
    throw SamplingStopped({Termination::cancelled, "the build was cancelled"});
  }
}

void SampledFunction::call(const Eigen::MatrixXd& points, Eigen::MatrixXd& values) const {
  values.setZero(outputs(), points.cols());
  function_(points, values);
  if (values.rows() == outputs() && values.cols() == points.cols()) return;
  throw SamplingStopped(
      {Termination::failed, fmt::format("the function made a table of {} x {} for {} outputs at {} points",
                                        values.rows(), values.cols(), outputs(), points.cols())});
}

/// Finds the point from which an exception came.
void SampledFunction::call_one_by_one(const Eigen::MatrixXd& points, Eigen::MatrixXd& values) const {
  values.resize(outputs(), points.cols());
  Eigen::MatrixXd one;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    std::string what;
    try {
      call(points.col(j), one);
      values.col(j) = one;
      continue;
    } catch (const SamplingStopped&) {
      throw;
    } catch (const std::exception& error) {
      what = error.what();
    } catch (...) {
      what = "an exception that is no std::exception";
    }
    const Eigen::VectorXd point = points.col(j);
    throw SamplingStopped({Termination::failed,
                           fmt::format("the function failed at {}: {}", described(point), what),
                           {point.begin(), point.end()}});
  }
}

void SampledFunction::check_values(const Eigen::MatrixXd& points, const Eigen::MatrixXd& values) const {
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    if (values.col(j).allFinite()) continue;
    Eigen::Index m = 0;
    while (std::isfinite(values(m, j))) ++m;
    const Eigen::VectorXd point = points.col(j);
    throw SamplingStopped({Termination::not_finite,
                           fmt::format("{} is {} at {}", outputs_[static_cast<std::size_t>(m)].name,
                                       values(m, j), described(point)),
                           {point.begin(), point.end()}});
  }
}

Eigen::MatrixXd SampledFunction::operator()(const Eigen::MatrixXd& points) {
  check_limits(points.cols());
  Eigen::MatrixXd values;
  try {
    call(points, values);
  } catch (const SamplingStopped&) {
    throw;
  } catch (...) {
    call_one_by_one(points, values);
  }
  calls_ += points.cols();
  check_values(points, values);
  if (points.cols() > 0) {
    smallest_ = smallest_.cwiseMin(values.rowwise().minCoeff());
    largest_ = largest_.cwiseMax(values.rowwise().maxCoeff());
  }
  return values;
}

Eigen::MatrixXd SampledFunction::recalled(const Eigen::MatrixXd& points) {
  const auto key = [&](Eigen::Index j) {
    return std::string(reinterpret_cast<const char*>(points.col(j).data()),
                       static_cast<std::size_t>(points.rows()) * sizeof(double));
  };
  std::vector<Eigen::Index> missing;
  std::set<std::string> keys;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    if (!recalled_.contains(key(j)) && keys.insert(key(j)).second) missing.push_back(j);
  }
  if (!missing.empty()) {
    const Eigen::MatrixXd values = (*this)(points(Eigen::all, missing));
    for (std::size_t i = 0; i < missing.size(); ++i)
      recalled_[key(missing[i])] = values.col(static_cast<Eigen::Index>(i));
  }
  Eigen::MatrixXd values(outputs(), points.cols());
  for (Eigen::Index j = 0; j < points.cols(); ++j) values.col(j) = recalled_.at(key(j));
  return values;
}

CoordinateMap::CoordinateMap(double lower, double upper, Transform transform)
    : lower_(lower),
      upper_(upper),
      transform_(transform),
      length_(transformed_distance(transform, lower, upper)) {}

double CoordinateMap::from_unit(double u) const {
  if (u == -1.0) return lower_;
  if (u == 1.0) return upper_;
  return std::clamp(transformed_advance(transform_, lower_, 0.5 * (u + 1.0) * length_), lower_, upper_);
}

double CoordinateMap::to_unit(double x) const {
  return 2.0 * transformed_distance(transform_, lower_, x) / length_ - 1.0;
}

SampleTable::SampleTable(SampledFunction& function, std::vector<CoordinateMap> maps)
    : function_(function),
      maps_(std::move(maps)),
      outputs_(function.outputs()),
      leja_(leja_points(kMostLejaPoints)) {}

Eigen::VectorXd SampleTable::point(const Eigen::Ref<const Eigen::VectorXi>& nodes) const {
  Eigen::VectorXd x(nodes.size());
  for (Eigen::Index k = 0; k < nodes.size(); ++k) {
    x[k] = maps_[static_cast<std::size_t>(k)].from_unit(leja_[nodes[k]]);
  }
  return x;
}

std::vector<int> SampleTable::places(const IndexBatch& points) {
  static_assert(kMostLejaPoints < 256, "a node's number is one byte of the key");
  std::vector<int> places(static_cast<std::size_t>(points.cols()));
  std::vector<std::string> new_keys;
  std::vector<Eigen::Index> missing;
  const auto known = static_cast<int>(places_.size());
  std::string key(static_cast<std::size_t>(points.rows()), '\0');
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      key[static_cast<std::size_t>(k)] = static_cast<char>(points(k, j));
    }
    const auto [entry, is_new] = places_.try_emplace(key, known + static_cast<int>(missing.size()));
    if (is_new) {
      missing.push_back(j);
      new_keys.push_back(key);
    }
    places[static_cast<std::size_t>(j)] = entry->second;
  }
  if (missing.empty()) return places;
  Eigen::MatrixXd x(points.rows(), static_cast<Eigen::Index>(missing.size()));
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    x.col(j) = point(points.col(missing[static_cast<std::size_t>(j)]));
  }
  try {
    // A single coordinate shares points with its trial and its checks: the ends. Grids of more are too large to be
    // kept twice.
    const Eigen::MatrixXd values = x.rows() == 1 ? function_.recalled(x) : function_(x);
    values_.insert(values_.end(), values.data(), values.data() + values.size());
  } catch (...) {
    for (const std::string& unknown : new_keys) places_.erase(unknown);
    throw;
  }
  return places;
}

}  // namespace samara::pgd

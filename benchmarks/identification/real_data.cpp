#include "real_data.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <numeric>
#include <utility>

#include "samara/base/errors.h"

namespace samara::benchmarks::identification {

using samara::identification::Capture;
using samara::identification::Channel;
using samara::identification::Coefficient;
using samara::identification::FitResult;

std::optional<std::filesystem::path> measured_set(const Options& options, const std::string& test_case,
                                                  const std::string& set) {
  if (!options.wants(test_case)) return {};
  const char* const root = std::getenv("SAMARA_DATA");
  const std::filesystem::path path = root ? std::filesystem::path(root) / set : std::filesystem::path();
  if (root && std::filesystem::is_directory(path)) return path;
  std::cerr << test_case << " skipped: SAMARA_DATA does not lead to \"" << set << "\"\n";
  return {};
}

Capture frames_of(const Capture& capture, Eigen::Index first, Eigen::Index count, double origin) {
  Capture part = capture;
  part.times = capture.times.segment(first, count).array() - origin;
  part.shift = capture.shift + origin;
  for (Channel& channel : part.channels)
    channel.values = Eigen::VectorXd(channel.values.segment(first, count));
  return part;
}

Eigen::MatrixX3d positions_of(const Capture& capture) {
  Eigen::MatrixX3d positions(capture.frame_count(), 3);
  for (Eigen::Index k = 0; k < 3; ++k) positions.col(k) = capture.channel(std::string(1, "xyz"[k])).values;
  return positions;
}

namespace {

const Coefficient& coefficient_of(const FitResult& result, const std::string& name) {
  const auto found = std::ranges::find(result.coefficients, name, &Coefficient::name);
  if (found == result.coefficients.end()) throw ArgumentError("the fit has no coefficient \"" + name + "\"");
  return *found;
}

}  // namespace

Coefficients values_of(const FitResult& result) {
  Coefficients values;
  for (const Coefficient& c : result.coefficients) values[c.name] = c.value;
  return values;
}

double value_of(const FitResult& result, const std::string& name) {
  return coefficient_of(result, name).value;
}

double error_of(const FitResult& result, const std::string& name) {
  return coefficient_of(result, name).standard_error.value_or(std::numeric_limits<double>::quiet_NaN());
}

namespace {

struct Claim {
  double value, error;
};

/// Of the answer, and of optima that are as good.
std::vector<Claim> claims_of(const FitResult& result, std::size_t coefficient) {
  const Coefficient& c = result.coefficients[coefficient];
  const auto error = samara::identification::widened_error(result, c);
  if (!error || c.at_bound || !c.determined) return {};
  const double widening = c.standard_error ? *error / *c.standard_error : 1.0;
  std::vector<Claim> claims = {{c.value, *error}};
  for (const auto& optimum : result.other_optima) {
    const double there = optimum.standard_errors[coefficient];
    if (!std::isfinite(there)) continue;
    claims.push_back({optimum.coefficients[coefficient], widening * there});
  }
  return claims;
}

}  // namespace

void Claims::add(const FitResult& result) {
  ++fits_;
  converged_ += result.status == Termination::converged ? 1 : 0;
}

void Claims::add_halves(const FitResult& one, const FitResult& other) {
  add(one);
  add(other);
  for (std::size_t k = 0; k < one.coefficients.size(); ++k) {
    const std::vector<Claim> here = claims_of(one, k);
    const std::vector<Claim> there = claims_of(other, k);
    if (here.empty() || there.empty()) continue;
    bool agree = false;
    for (const Claim& a : here) {
      for (const Claim& b : there)
        agree = agree || std::abs(a.value - b.value) <= 2.0 * std::hypot(a.error, b.error);
    }
    ++compared_;
    beyond_ += agree ? 0 : 1;
  }
}

double Claims::converged_fraction() const {
  return static_cast<double>(converged_) / fits_;
}

double Claims::halves_beyond_two_errors() const {
  return static_cast<double>(beyond_) / compared_;
}

std::vector<std::size_t> random_order(std::size_t count, pgd::Random& random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t k = count; k > 1; --k)
    std::swap(order[k - 1], order[static_cast<std::size_t>(random.below(static_cast<int>(k)))]);
  return order;
}

double median_of(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double rms_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace samara::benchmarks::identification

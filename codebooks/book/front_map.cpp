#include "samara/codebooks/book/front_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::codebooks {

namespace {

/// Chebyshev polynomials of degree 0 and more, with their first and second derivatives.
struct ChebyshevValues {
  std::array<double, FrontMap::kMostCoefficients> value, slope, curvature;

  ChebyshevValues(double x, int count) {
    value[0] = 1.0;
    slope[0] = curvature[0] = 0.0;
    if (count > 1) {
      value[1] = x;
      slope[1] = 1.0;
      curvature[1] = 0.0;
    }
    for (std::size_t n = 2; n < static_cast<std::size_t>(count); ++n) {
      value[n] = 2.0 * x * value[n - 1] - value[n - 2];
      slope[n] = 2.0 * value[n - 1] + 2.0 * x * slope[n - 1] - slope[n - 2];
      curvature[n] = 4.0 * slope[n - 1] + 2.0 * x * curvature[n - 1] - curvature[n - 2];
    }
  }
};

void require_front(bool holds, const char* what) {
  if (!holds) throw ArgumentError(fmt::format("a coordinate counted from a front {}", what));
}

}  // namespace

/// The place of the front on [-1, 1], and its derivatives by the others.
struct FrontMap::Place {
  double value = 0.0;
  std::array<double, kMostOthers> first = {};
  std::array<std::array<double, kMostOthers>, kMostOthers> second = {};
};

FrontMap::FrontMap(int coordinate, double lower, double upper, std::vector<Other> others,
                   Eigen::VectorXd place)
    : coordinate_(coordinate),
      lower_(lower),
      upper_(upper),
      others_(std::move(others)),
      place_(std::move(place)) {
  require_front(std::isfinite(lower) && std::isfinite(upper) && lower < upper && coordinate >= 0,
                "has no interval");
  require_front(others_.size() <= kMostOthers, "knows a front that depends on more than four others");
  Eigen::Index count = 1;
  for (const Other& other : others_) {
    require_front(std::isfinite(other.lower) && std::isfinite(other.upper) && other.lower < other.upper &&
                      other.coordinate >= 0 && other.coordinate != coordinate,
                  "knows a front that depends on no interval");
    require_front(std::ranges::count(others_, other.coordinate, &Other::coordinate) == 1,
                  "knows a front that depends on one other twice");
    require_front(other.coefficients >= 1 && other.coefficients <= kMostCoefficients,
                  "knows a front with more than sixteen coefficients along an other");
    count *= other.coefficients;
  }
  require_front(count <= kMostTogether, "knows a front with more than 512 coefficients");
  require_front(place_.size() == count && place_.allFinite(),
                "knows a front with other coefficients than it says");
  // The sum of their sizes bounds the polynomial, but by far: it is looked at where the others have equal steps.
  constexpr int kSteps = 16;
  std::vector<double> x(1);
  for (const Other& other : others_)
    x.resize(std::max(x.size(), static_cast<std::size_t>(other.coordinate) + 1));
  std::size_t points = 1;
  for (std::size_t k = 0; k < others_.size(); ++k) points *= kSteps + 1;
  for (std::size_t n = 0; n < points; ++n) {
    std::size_t rest = n;
    for (const Other& other : others_) {
      const double share = static_cast<double>(rest % (kSteps + 1)) / kSteps;
      x[static_cast<std::size_t>(other.coordinate)] = other.lower + share * (other.upper - other.lower);
      rest /= kSteps + 1;
    }
    require_front(std::abs(place_at(x.data(), false).value) < 1.0, "knows a front that leaves its interval");
  }
}

FrontMap::Place FrontMap::place_at(const double* x, bool with_derivatives) const {
  const std::size_t count = others_.size();
  std::array<std::array<const double*, 3>, kMostOthers> polynomials = {};
  std::array<double, kMostOthers> steps = {};
  std::array<ChebyshevValues, kMostOthers> values = {ChebyshevValues(0.0, 1), ChebyshevValues(0.0, 1),
                                                     ChebyshevValues(0.0, 1), ChebyshevValues(0.0, 1)};
  for (std::size_t k = 0; k < count; ++k) {
    steps[k] = 2.0 / (others_[k].upper - others_[k].lower);
    values[k] = ChebyshevValues(steps[k] * (x[others_[k].coordinate] - others_[k].lower) - 1.0,
                                others_[k].coefficients);
    polynomials[k] = {values[k].value.data(), values[k].slope.data(), values[k].curvature.data()};
  }
  /// The sum of the products, with so many derivatives by each.
  const auto sum = [&](const std::array<std::size_t, kMostOthers>& orders) {
    double result = 0.0;
    for (Eigen::Index n = 0; n < place_.size(); ++n) {
      double product = place_[n];
      Eigen::Index rest = n;
      for (std::size_t k = 0; k < count; ++k) {
        product *= polynomials[k][orders[k]][rest % others_[k].coefficients];
        rest /= others_[k].coefficients;
      }
      result += product;
    }
    return result;
  };
  Place place;
  std::array<std::size_t, kMostOthers> orders = {};
  place.value = sum(orders);
  for (std::size_t i = 0; with_derivatives && i < count; ++i) {
    ++orders[i];
    place.first[i] = sum(orders) * steps[i];
    for (std::size_t j = 0; j <= i; ++j) {
      ++orders[j];
      place.second[i][j] = place.second[j][i] = sum(orders) * steps[i] * steps[j];
      --orders[j];
    }
    --orders[i];
  }
  return place;
}

double FrontMap::front_at(const double* x) const {
  return unscaled(place_at(x, false).value);
}

double FrontMap::to_axis(const double* x) const {
  const double g = place_at(x, false).value, own = scaled(x[coordinate_]);
  return std::clamp(unscaled((own - g) / (1.0 - g * own)), lower_, upper_);
}

double FrontMap::from_axis(const double* x) const {
  const double g = place_at(x, false).value, v = scaled(x[coordinate_]);
  return std::clamp(unscaled((v + g) / (1.0 + g * v)), lower_, upper_);
}

double FrontMap::to_axis(const double* x, Derivatives& derivatives) const {
  const Place place = place_at(x, true);
  const double g = place.value, own = scaled(x[coordinate_]), half = 0.5 * (upper_ - lower_);
  const double d = 1.0 - g * own, d2 = d * d, d3 = d2 * d;
  const double by_g = (own * own - 1.0) / d2, by_g_g = 2.0 * own * (own * own - 1.0) / d3;
  derivatives.first[0] = (1.0 - g * g) / d2;
  derivatives.second[0][0] = 2.0 * g * (1.0 - g * g) / d3 / half;
  for (std::size_t i = 0; i < others_.size(); ++i) {
    derivatives.first[1 + i] = half * by_g * place.first[i];
    derivatives.second[0][1 + i] = derivatives.second[1 + i][0] = 2.0 * (own - g) / d3 * place.first[i];
    for (std::size_t j = 0; j < others_.size(); ++j)
      derivatives.second[1 + i][1 + j] =
          half * (by_g_g * place.first[i] * place.first[j] + by_g * place.second[i][j]);
  }
  return std::clamp(unscaled((own - g) / d), lower_, upper_);
}

FrontMap FrontMap::shifted(int by) const {
  std::vector<Other> others = others_;
  for (Other& other : others) other.coordinate += by;
  return {coordinate_ + by, lower_, upper_, std::move(others), place_};
}

FrontMap FrontMap::restricted(int place, double value) const {
  std::vector<Other> others;
  Eigen::VectorXd coefficients = place_;
  Eigen::Index inner = 1;  // products of those in front of the number
  for (const Other& other : others_) {
    if (other.coordinate == place) {
      const double at = 2.0 * (value - other.lower) / (other.upper - other.lower) - 1.0;
      const ChebyshevValues values(at, other.coefficients);
      const Eigen::Index outer = coefficients.size() / inner / other.coefficients;
      Eigen::VectorXd sums = Eigen::VectorXd::Zero(inner * outer);
      for (Eigen::Index n = 0; n < coefficients.size(); ++n) {
        const Eigen::Index along = n / inner % other.coefficients, rest = n / inner / other.coefficients;
        sums[n % inner + inner * rest] += values.value[static_cast<std::size_t>(along)] * coefficients[n];
      }
      coefficients = std::move(sums);
      continue;
    }
    inner *= other.coefficients;
    others.push_back(other);
    if (other.coordinate > place) --others.back().coordinate;
  }
  return {coordinate_ - (coordinate_ > place ? 1 : 0), lower_, upper_, std::move(others),
          std::move(coefficients)};
}

}  // namespace samara::codebooks

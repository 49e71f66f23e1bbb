#include "samara/codebooks/book/front_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
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

void require_front(bool holds, const std::string& what) {
  if (!holds) throw ArgumentError("a coordinate counted from a front " + what);
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
  require_front(others_.size() <= kMostOthers,
                fmt::format("knows a front that depends on {} others; {} at most were expected",
                            others_.size(), kMostOthers));
  Eigen::Index count = 1;
  for (const Other& other : others_) {
    require_front(other.coordinate != coordinate, "knows a front that depends on the coordinate itself");
    require_front(std::isfinite(other.lower) && std::isfinite(other.upper) && other.lower < other.upper &&
                      other.coordinate >= 0,
                  "knows a front that depends on no interval");
    require_front(std::ranges::count(others_, other.coordinate, &Other::coordinate) == 1,
                  "knows a front that depends on one other twice");
    require_front(other.coefficients >= 1 && other.coefficients <= kMostCoefficients,
                  fmt::format("knows a front with {} coefficients along an other; 1 to {} were expected",
                              other.coefficients, kMostCoefficients));
    count *= other.coefficients;
  }
  require_front(
      count <= kMostTogether,
      fmt::format("knows a front with {} coefficients; {} at most were expected", count, kMostTogether));
  require_front(
      place_.size() == count && place_.allFinite(),
      fmt::format("knows a front by {} coefficients; {} finite ones were expected", place_.size(), count));
  require_front(stays_inside(), "knows a front that leaves its interval");
}

/// Whether |G| is below 1 everywhere. The sum of the coefficients bounds it, but by far; else a polynomial of degree
/// n is nowhere larger than 1/cos(pi n/(2 N)) times the largest of its values at the N + 1 points cos(pi k/N) (Ehlich
/// and Zeller, Math. Z. 86 (1964) 41-44), along each of the others.
bool FrontMap::stays_inside() const {
  if (place_.cwiseAbs().sum() < 1.0) return true;
  constexpr int kDenser = 6;  // N/n
  std::vector<double> x(1);
  std::size_t points = 1;
  double most = 1.0;
  for (const Other& other : others_) {
    x.resize(std::max(x.size(), static_cast<std::size_t>(other.coordinate) + 1));
    points *= static_cast<std::size_t>(kDenser * (other.coefficients - 1) + 1);
    if (other.coefficients > 1) most *= std::cos(std::numbers::pi / (2 * kDenser));
  }
  for (std::size_t n = 0; n < points; ++n) {
    std::size_t rest = n;
    for (const Other& other : others_) {
      const auto steps = static_cast<std::size_t>(kDenser * (other.coefficients - 1));
      const double angle =
          steps > 0 ? std::numbers::pi * static_cast<double>(rest % (steps + 1)) / static_cast<double>(steps)
                    : 0.0;
      x[static_cast<std::size_t>(other.coordinate)] =
          0.5 * (other.lower + other.upper) + 0.5 * (other.upper - other.lower) * std::cos(angle);
      rest /= steps + 1;
    }
    if (std::abs(place_at(x.data(), false).value) >= most) return false;
  }
  return true;
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
  FrontMap map = *this;
  map.coordinate_ += by;
  for (Other& other : map.others_) other.coordinate += by;
  return map;
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
  FrontMap map = *this;  // which stays inside, as this one does
  if (coordinate_ > place) --map.coordinate_;
  map.others_ = std::move(others);
  map.place_ = std::move(coefficients);
  return map;
}

}  // namespace samara::codebooks

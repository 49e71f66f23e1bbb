#include "samara/base/exponentials.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/base/streams.h"

using samara::take_exponentials;
using samara::take_logarithms;

namespace {

std::vector<double> exponentials_of(std::vector<double> x) {
  take_exponentials(x);
  return x;
}

/// In units in the last place of a double.
double apart(double value, long double exact) {
  int exponent = 0;
  std::frexp(static_cast<double>(exact), &exponent);
  return static_cast<double>(std::abs(static_cast<long double>(value) - exact) /
                             std::ldexp(1.0L, exponent - std::numeric_limits<double>::digits));
}

/// From the exponential in extended precision.
double distance(double value, double x) {
  return apart(value, std::exp(static_cast<long double>(x)));
}

}  // namespace

TEST_CASE("exponentials are within 1.1 units in the last place, those of the library within 1") {
  static_assert(std::numeric_limits<long double>::digits > std::numeric_limits<double>::digits);
  samara::Stream random(3, 1);
  for (const double range : {1e-6, 1e-2, 0.5, 5.0, 700.0}) {
    std::vector<double> x(100000);
    for (double& one : x) one = range * (2.0 * random.uniform() - 1.0);
    const std::vector<double> found = exponentials_of(x);
    double worst = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      worst = std::max(worst, distance(found[i], x[i]));
    }
    INFO("up to " << range);
    CHECK(worst < 1.1);
  }
}

TEST_CASE("exponentials at the ends of the doubles are what they tend to") {
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> found =
      exponentials_of({0.0, -0.0, -infinity, -708.0, infinity, 709.79, std::nan("")});
  CHECK(found[0] == 1.0);
  CHECK(found[1] == 1.0);
  CHECK(found[2] == 0.0);
  CHECK(found[3] == 0.0);
  CHECK(found[4] == infinity);
  CHECK(found[5] == infinity);
  CHECK(std::isnan(found[6]));
  for (const double x : {-707.7, 709.782712893384}) CHECK(distance(exponentials_of({x})[0], x) < 1.1);
}

TEST_CASE("an exponential has the same bits alone and among any others") {
  std::vector<double> x;
  samara::Stream random(4, 1);
  for (int i = 0; i < 37; ++i) x.push_back(-10.0 * random.uniform());
  const std::vector<double> together = exponentials_of(x);
  for (std::size_t i = 0; i < x.size(); ++i) CHECK(exponentials_of({x[i]})[0] == together[i]);
  CHECK(exponentials_of({}).empty());
}

TEST_CASE("logarithms are within a unit in the last place, alone and among any others") {
  samara::Stream random(5, 1);
  for (const double range : {1e-9, 1e-3, 0.7, 50.0, 700.0}) {
    std::vector<double> x(100003);
    for (double& one : x) one = std::exp(range * (2.0 * random.uniform() - 1.0));
    std::vector<double> found = x;
    take_logarithms(found);
    double worst = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i)
      worst = std::max(worst, apart(found[i], std::log(static_cast<long double>(x[i]))));
    INFO("up to e^" << range);
    CHECK(worst < 1.0);
    // The last of what is taken together, and what is left of it.
    for (std::size_t i = x.size() - 11; i < x.size(); ++i) {
      std::vector<double> alone = {x[i]};
      take_logarithms(alone);
      CHECK(alone[0] == found[i]);
    }
  }
  std::vector<double> ends = {1.0, std::numeric_limits<double>::min(), std::numeric_limits<double>::max()};
  const std::vector<double> x = ends;
  take_logarithms(ends);
  CHECK(ends[0] == 0.0);
  for (const std::size_t i : {1, 2}) CHECK(apart(ends[i], std::log(static_cast<long double>(x[i]))) < 1.0);
}

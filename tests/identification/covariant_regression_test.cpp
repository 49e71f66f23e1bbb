#include "samara/identification/forecasts/covariant_regression.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/base/streams.h"

using namespace samara::identification;

namespace {

constexpr std::size_t kRegressionParts = 5;

const CovariantRegression::Weights kAllAlike{Eigen::VectorXd::Ones(2), Eigen::VectorXd::Ones(2)};

/// Features at random, with values that turn with them and are mirrored with them.
struct TurningSample {
  std::vector<Turning> features = {}, values = {};
  std::vector<std::size_t> parts = {};
};

Turning bent_values(const Turning& features) {
  const std::complex<double> a = features.level[0], b = features.level[1];
  const double e = features.others[0], f = features.others[1];
  return {
      Eigen::VectorXcd::Constant(1, 0.7 * a * std::cos(e) + 0.3 * b * std::norm(a) / (1.0 + std::norm(a))),
      Eigen::VectorXd::Constant(1, std::sin(f) + 0.5 * std::tanh((a * std::conj(b)).real()))};
}

Turning linear_values(const Turning& features) {
  return {Eigen::VectorXcd::Constant(1, 0.3 * features.level[0] - 2.0 * features.level[1]),
          Eigen::VectorXd::Constant(1, 1.5 + features.others[0] - 0.5 * features.others[1])};
}

TurningSample turning_sample(int count, std::uint64_t number, Turning (*values)(const Turning&) = bent_values,
                             double noise = 0.0) {
  samara::Stream stream(51, number);
  const auto complex = [&] {
    const double real = stream.normal();
    return std::complex<double>(real, stream.normal());
  };
  TurningSample sample;
  for (int k = 0; k < count; ++k) {
    Turning one{Eigen::VectorXcd(2), Eigen::Vector2d(stream.normal(), stream.normal())};
    for (std::complex<double>& a : one.level) a = complex();
    Turning value = values(one);
    value.level[0] += noise * complex();
    value.others[0] += noise * stream.normal();
    sample.features.push_back(std::move(one));
    sample.values.push_back(std::move(value));
    sample.parts.push_back(static_cast<std::size_t>(k / 4) % kRegressionParts);
  }
  return sample;
}

CovariantRegression learned(const TurningSample& sample) {
  return CovariantRegression::fit(sample.features, sample.values, sample.parts, kAllAlike);
}

double apart(const Turning& one, const Turning& other) {
  return std::hypot((one.level - other.level).norm(), (one.others - other.others).norm());
}

/// Root of the mean squared distance on moments of its own.
double rms_on_unseen(const CovariantRegression& regression) {
  const TurningSample unseen = turning_sample(200, 99);
  double squares = 0.0;
  for (std::size_t k = 0; k < unseen.features.size(); ++k)
    squares += std::pow(apart(regression.at(unseen.features[k]), unseen.values[k]), 2);
  return std::sqrt(squares / 200.0);
}

}  // namespace

TEST_CASE("a covariant regression learns what bends, the better the more moments show it") {
  const double few = rms_on_unseen(learned(turning_sample(60, 1))),
               many = rms_on_unseen(learned(turning_sample(240, 1))),
               most = rms_on_unseen(learned(turning_sample(960, 1)));
  CHECK(many < 0.7 * few);
  CHECK(most < 0.7 * many);
  CHECK(most < 0.15);
}

TEST_CASE("a covariant regression goes on as a linear one where no training was") {
  const CovariantRegression regression = learned(turning_sample(200, 2, linear_values));
  Turning far{Eigen::VectorXcd::Constant(2, {30.0, 10.0}), Eigen::Vector2d(20.0, -40.0)};
  far.level[1] *= std::complex<double>(0.0, 1.0);
  const Turning expected = linear_values(far);
  CHECK(apart(regression.at(far), expected) <
        1e-2 * apart(expected, {Eigen::VectorXcd::Zero(1), Eigen::VectorXd::Zero(1)}));
}

TEST_CASE("values turn with the moment, and are mirrored with it") {
  const CovariantRegression regression = learned(turning_sample(200, 3, bent_values, 0.1));
  const std::complex<double> turn = std::polar(1.0, 0.7);
  for (const Turning& one : turning_sample(20, 4).features) {
    for (const bool all : {true, false}) {
      const auto said = [&](const Turning& asked) {
        return all ? regression.at(asked) : regression.without(2, asked);
      };
      const Turning plain = said(one), turned = said({turn * one.level, one.others}),
                    mirrored = said({one.level.conjugate(), one.others});
      CHECK(apart(turned, {turn * plain.level, plain.others}) < 1e-10);
      CHECK(apart(mirrored, {plain.level.conjugate(), plain.others}) < 1e-10);
    }
  }
}

namespace {

/// Along each axis values depend on what is seen along it: quarter turns exchange both, other turns nothing.
Turning viewed_values(const Turning& features) {
  const std::complex<double> a = features.level[0], view = features.views[0];
  return {Eigen::VectorXcd::Constant(1, {a.real() * view.real(), a.imag() * view.imag()}),
          Eigen::VectorXd::Constant(1, view.real() * view.imag())};
}

/// Views beside moments at random, with values of these.
TurningSample viewed_sample(int count, std::uint64_t number) {
  TurningSample sample = turning_sample(count, number);
  samara::Stream stream(53, number);
  for (std::size_t k = 0; k < sample.features.size(); ++k) {
    const double along_x = stream.uniform();
    sample.features[k].views = Eigen::VectorXcd::Constant(1, {along_x, stream.uniform()});
    sample.values[k] = viewed_values(sample.features[k]);
  }
  return sample;
}

}  // namespace

TEST_CASE("a covariant regression learns of views, and quarter turns exchange them") {
  const TurningSample sample = viewed_sample(500, 12), unseen = viewed_sample(50, 13);
  const CovariantRegression::Weights weights{Eigen::VectorXd::Ones(2), Eigen::VectorXd::Ones(2),
                                             Eigen::VectorXd::Ones(1)};
  const CovariantRegression regression =
      CovariantRegression::fit(sample.features, sample.values, sample.parts, weights);
  TurningSample blind = sample;
  for (Turning& one : blind.features) one.views.resize(0);
  const CovariantRegression without = learned(blind);
  double left = 0.0, left_without = 0.0;
  for (std::size_t k = 0; k < unseen.features.size(); ++k) {
    const Turning& one = unseen.features[k];
    const Turning said = regression.at(one);
    left += apart(said, unseen.values[k]);
    left_without += apart(without.at({one.level, one.others}), unseen.values[k]);
    const std::complex<double> quarter(0.0, 1.0);
    const Turning turned = regression.at({quarter * one.level, one.others, quarter * one.views.conjugate()}),
                  mirrored = regression.at({one.level.conjugate(), one.others, one.views});
    CHECK(apart(turned, {quarter * said.level, said.others}) < 1e-10);
    CHECK(apart(mirrored, {said.level.conjugate(), said.others}) < 1e-10);
  }
  CHECK(left < 0.5 * left_without);
  CHECK_THROWS_WITH(regression.at({unseen.features[0].level, unseen.features[0].others}),
                    Catch::Contains("1 of views was asked about 2, 2 and 0"));
}

TEST_CASE("training that is turned and mirrored, each moment by itself, teaches the same") {
  TurningSample sample = turning_sample(150, 5, bent_values, 0.1);
  const CovariantRegression before = learned(sample);
  samara::Stream stream(52, 0);
  for (std::size_t k = 0; k < sample.features.size(); ++k) {
    const std::complex<double> turn = std::polar(1.0, 6.28 * stream.uniform());
    const bool mirror = stream.uniform() < 0.5;
    for (Turning* one : {&sample.features[k], &sample.values[k]}) {
      if (mirror) one->level = one->level.conjugate().eval();
      one->level *= turn;
    }
  }
  const CovariantRegression after = learned(sample);
  REQUIRE(after.length() == before.length());
  REQUIRE(after.ridge() == before.ridge());
  for (const Turning& one : turning_sample(20, 6).features)
    CHECK(apart(before.at(one), after.at(one)) < 1e-6);
}

TEST_CASE("what a part of the training says has no say in the covariant regression without it") {
  const auto holds = [](int count) {
    TurningSample sample = turning_sample(count, 7, bent_values, 0.1);
    const CovariantRegression before = learned(sample);
    for (std::size_t k = 0; k < sample.parts.size(); ++k) {
      if (sample.parts[k] != 3) continue;
      sample.values[k].level *= 1.02;  // the choices stay
      sample.values[k].others *= 1.02;
    }
    const CovariantRegression after = learned(sample);
    double with_it = 0.0;
    for (const Turning& one : turning_sample(20, 8).features) {
      CHECK(apart(after.without(3, one), before.without(3, one)) < 1e-6);
      with_it = std::max(with_it, apart(after.without(2, one), before.without(2, one)));
      CHECK(apart(after.without(kRegressionParts, one), after.at(one)) == 0.0);  // of no part: by all
    }
    CHECK(with_it > 1e-4);
  };
  holds(200);
  holds(static_cast<int>(CovariantRegression::kCentres) * 3 / 2);
}

TEST_CASE("round-off of the kernels does not spoil the equations of a covariant regression") {
  // Of few numbers the kernels of many moments are nearly of less than full rank.
  for (const std::uint64_t number : {1, 2, 3}) {
    samara::Stream stream(7, number);
    const auto complex = [&] {
      const double real = stream.normal();
      return std::complex<double>(real, stream.normal());
    };
    const auto value_of = [](const std::complex<double>& a) {
      return Turning{Eigen::VectorXcd::Constant(1, a * (1.0 + std::tanh(0.5 * std::abs(a)))),
                     Eigen::VectorXd::Constant(1, std::sin(2.0 * std::abs(a)))};
    };
    TurningSample sample;
    for (int k = 0; k < 600; ++k) {
      const std::complex<double> a = complex();
      Turning value = value_of(a);
      value.level[0] += 0.5 * complex();
      value.others[0] += 0.5 * stream.normal();
      sample.features.push_back(
          {Eigen::VectorXcd::Constant(1, a), Eigen::VectorXd::Constant(1, stream.normal())});
      sample.values.push_back(std::move(value));
      sample.parts.push_back(static_cast<std::size_t>(k / 4) % kRegressionParts);
    }
    const CovariantRegression regression = CovariantRegression::fit(
        sample.features, sample.values, sample.parts, {Eigen::VectorXd::Ones(1), Eigen::VectorXd::Ones(1)});
    double squares = 0.0;
    for (const Turning& one : sample.features)
      squares += std::pow(apart(regression.at(one), value_of(one.level[0])), 2);
    CHECK(std::sqrt(squares / 600.0) < 0.3);
  }
}

TEST_CASE("numbers that are nothing but round-off have no say in a covariant regression") {
  TurningSample sample = turning_sample(400, 11, bent_values, 0.1);
  const CovariantRegression without_them = learned(sample);
  samara::Stream stream(52, 0);
  for (Turning& one : sample.features) {
    one.level.conservativeResize(4);
    for (const Eigen::Index k : {2, 3})
      one.level[k] = 1e-17 * std::complex<double>(stream.normal(), stream.normal());
  }
  const CovariantRegression with_them = CovariantRegression::fit(
      sample.features, sample.values, sample.parts, {Eigen::VectorXd::Ones(4), Eigen::VectorXd::Ones(2)});
  for (Turning one : turning_sample(20, 12).features) {
    const Turning expected = without_them.at(one);
    one.level.conservativeResize(4);
    one.level.tail(2).setConstant(1e-17);
    CHECK(apart(with_them.at(one), expected) < 1e-6);
  }
}

TEST_CASE("a covariant regression is not fitted where the moments that it chooses by are of one part") {
  TurningSample sample = turning_sample(2 * static_cast<int>(CovariantRegression::kChoosing) + 100, 13);
  std::ranges::fill(sample.parts, std::size_t{0});
  sample.parts.back() = 1;
  CHECK_FALSE(learned(sample).is_fitted());
}

TEST_CASE(
    "the order of moments in a plane, of which nothing else is known, does not change what is learned") {
  TurningSample sample = turning_sample(900, 14);
  for (Turning& one : sample.features) one.others.resize(0);
  const CovariantRegression::Weights weights{Eigen::VectorXd::Ones(2), Eigen::VectorXd(0)};
  const auto fit = [&] {
    return CovariantRegression::fit(sample.features, sample.values, sample.parts, weights);
  };
  const CovariantRegression before = fit();
  std::ranges::reverse(sample.features);
  std::ranges::reverse(sample.values);
  std::ranges::reverse(sample.parts);
  const CovariantRegression reversed = fit();
  for (int k = 0; k < 20; ++k) {
    const Turning& one = sample.features[static_cast<std::size_t>(k)];
    CHECK(apart(before.at(one), reversed.at(one)) < 1e-6);
  }
}

TEST_CASE("the order of moments does not change what a covariant regression learns") {
  TurningSample sample =
      turning_sample(static_cast<int>(CovariantRegression::kChoosing) + 100, 9, bent_values, 0.1);
  const CovariantRegression before = learned(sample);
  std::ranges::reverse(sample.features);
  std::ranges::reverse(sample.values);
  std::ranges::reverse(sample.parts);
  const CovariantRegression reversed = learned(sample);
  CHECK(reversed.length() == before.length());
  CHECK(reversed.ridge() == before.ridge());
  for (const Turning& one : turning_sample(20, 10).features)
    CHECK(apart(before.at(one), reversed.at(one)) < 1e-6);
}

TEST_CASE("a covariant regression refuses what does not match, and one part has nothing to choose by") {
  TurningSample sample = turning_sample(30, 11);
  const CovariantRegression regression = learned(sample);
  CHECK_THROWS_WITH(regression.at({Eigen::VectorXcd::Zero(3), Eigen::VectorXd::Zero(2)}),
                    Catch::Contains("3, 2 and 0"));
  std::ranges::fill(sample.parts, std::size_t{0});
  CHECK_FALSE(learned(sample).is_fitted());
  CHECK_FALSE(CovariantRegression::fit({}, {}, {}, kAllAlike).is_fitted());
  CHECK_THROWS_AS(CovariantRegression().at(sample.features[0]), samara::ArgumentError);
  sample.parts.pop_back();
  CHECK_THROWS_WITH(learned(sample), Catch::Contains("29 parts"));
  sample.parts.push_back(1);
  sample.features[3].level = Eigen::VectorXcd::Zero(1);
  CHECK_THROWS_WITH(learned(sample), Catch::Contains("1 level"));
  sample.features[3] = sample.features[2];
  sample.values[3].others = Eigen::VectorXd::Constant(1, std::numeric_limits<double>::quiet_NaN());
  CHECK_THROWS_WITH(learned(sample), Catch::Contains("not finite"));
}

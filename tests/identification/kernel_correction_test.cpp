#include "samara/identification/forecasts/kernel_correction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/base/streams.h"

using namespace samara::identification;

namespace {

constexpr std::size_t kKernelParts = 5;

/// Features at random, with values that are smooth functions of them: even and odd ones as their kind.
struct KernelSample {
  std::vector<Mirrored> features = {}, values = {};
  std::vector<std::size_t> parts = {};
};

Mirrored smooth_values(const Mirrored& features) {
  const double a = features.even[0], b = features.even[1], o = features.odd[0];
  return {Eigen::Vector2d(std::sin(a) * std::cos(o), 1.0 + 0.5 * a * b),
          Eigen::VectorXd::Constant(1, std::sin(o) * b)};
}

KernelSample sample_of(int count, std::uint64_t number, double noise = 0.0) {
  samara::Stream stream(31, number);
  KernelSample sample;
  for (int k = 0; k < count; ++k) {
    Mirrored one{Eigen::Vector2d(stream.normal(), stream.normal()),
                 Eigen::VectorXd::Constant(1, stream.normal())};
    Mirrored value = smooth_values(one);
    for (double& v : value.even) v += noise * stream.normal();
    for (double& v : value.odd) v += noise * stream.normal();
    sample.features.push_back(std::move(one));
    sample.values.push_back(std::move(value));
    sample.parts.push_back(static_cast<std::size_t>(k / 4) % kKernelParts);
  }
  return sample;
}

KernelCorrection learned(const KernelSample& sample) {
  return KernelCorrection::fit(sample.features, sample.values, sample.parts);
}

double apart(const Mirrored& one, const Mirrored& other) {
  return std::hypot((one.even - other.even).norm(), (one.odd - other.odd).norm());
}

/// Root of the mean squared distance on moments of its own.
double rms_on_unseen(const KernelCorrection& correction) {
  const KernelSample unseen = sample_of(200, 99);
  double squares = 0.0;
  for (std::size_t k = 0; k < unseen.features.size(); ++k)
    squares += std::pow(apart(correction.at(unseen.features[k]), unseen.values[k]), 2);
  return std::sqrt(squares / 200.0);
}

}  // namespace

TEST_CASE("a kernel learns a smooth function of the features, the better the more moments show it") {
  const double few = rms_on_unseen(learned(sample_of(60, 1))),
               many = rms_on_unseen(learned(sample_of(240, 1))),
               most = rms_on_unseen(learned(sample_of(960, 1)));
  CHECK(many < 0.7 * few);
  CHECK(most < 0.7 * many);
  CHECK(most < 0.1);
}

TEST_CASE("the mirror image of a moment has the mirror image of its correction") {
  const KernelCorrection correction = learned(sample_of(200, 2, 0.1));
  REQUIRE(correction.is_fitted());
  for (const Mirrored& one : sample_of(20, 3).features) {
    const Mirrored image{one.even, -one.odd};
    const Mirrored seen = correction.at(one), mirrored = correction.at(image);
    CHECK((seen.even - mirrored.even).norm() < 1e-12);
    CHECK((seen.odd + mirrored.odd).norm() < 1e-12);
    CHECK((correction.without(2, one).odd + correction.without(2, image).odd).norm() < 1e-12);
  }
}

TEST_CASE("what a part of the training says has no say in the correction without it") {
  KernelSample sample = sample_of(200, 4, 0.05);
  const KernelCorrection before = learned(sample);
  for (std::size_t k = 0; k < sample.parts.size(); ++k) {
    if (sample.parts[k] == 3) sample.values[k].even *= 1.02;  // the choices stay
  }
  const KernelCorrection after = learned(sample);
  REQUIRE(before.is_fitted());
  REQUIRE(after.length() == before.length());
  REQUIRE(after.ridge() == before.ridge());
  for (const Mirrored& one : sample_of(20, 5).features) {
    CHECK(apart(after.without(3, one), before.without(3, one)) < 1e-10);
    CHECK(apart(after.without(2, one), before.without(2, one)) > 1e-6);
    CHECK(apart(after.without(kKernelParts, one), after.at(one)) == 0.0);  // of no part: by all
  }
}

TEST_CASE("where nothing can be learned there is no correction, and far from all training it fades") {
  KernelSample noise = sample_of(100, 5);
  samara::Stream stream(32, 0);
  for (Mirrored& value : noise.values) {
    for (double& v : value.even) v = stream.normal();
    for (double& v : value.odd) v = stream.normal();
  }
  const KernelCorrection none = learned(noise);
  CHECK_FALSE(none.is_fitted());
  CHECK(apart(none.at(noise.features[0]), {Eigen::Vector2d::Zero(), Eigen::VectorXd::Zero(1)}) == 0.0);
  const KernelCorrection some = learned(sample_of(100, 6));
  REQUIRE(some.is_fitted());
  const Mirrored far{Eigen::Vector2d(50.0, 0.0), Eigen::VectorXd::Zero(1)};
  CHECK(some.at(far).even.norm() < 1e-12);
  // One part alone has nothing that it could be tried on.
  KernelSample one = sample_of(50, 7);
  std::ranges::fill(one.parts, std::size_t{0});
  CHECK_FALSE(learned(one).is_fitted());
  CHECK_FALSE(KernelCorrection::fit({}, {}, {}).is_fitted());
}

TEST_CASE("neither the order of moments nor a wild one changes what a kernel learns") {
  KernelSample sample = sample_of(static_cast<int>(KernelCorrection::kChoosing) + 100, 8, 0.05);
  const KernelCorrection before = learned(sample);
  std::ranges::reverse(sample.features);
  std::ranges::reverse(sample.values);
  std::ranges::reverse(sample.parts);
  const KernelCorrection reversed = learned(sample);
  CHECK(reversed.length() == before.length());
  CHECK(reversed.ridge() == before.ridge());
  const KernelSample unseen = sample_of(20, 9);
  for (const Mirrored& one : unseen.features) CHECK(apart(before.at(one), reversed.at(one)) < 1e-9);
  KernelSample wild = sample_of(200, 10, 0.05);
  const double as_is = rms_on_unseen(learned(wild));
  wild.values[7].even[0] = 1e6;
  CHECK(rms_on_unseen(learned(wild)) < 1.5 * as_is);
}

TEST_CASE("more moments than a kernel is solved for exactly teach it more, each part without itself") {
  const KernelSample fewer = sample_of(static_cast<int>(KernelCorrection::kExact) / 2, 12, 0.3);
  const KernelSample more = sample_of(static_cast<int>(KernelCorrection::kExact) * 3 / 2, 12, 0.3);
  const KernelCorrection of_more = learned(more);
  CHECK(rms_on_unseen(of_more) < 0.9 * rms_on_unseen(learned(fewer)));
  // Values of a part that are turned about, few enough not to change what is chosen, change nothing of what is said
  // without it.
  KernelSample turned = more;
  int left = 5;
  for (std::size_t k = 0; k < turned.parts.size() && left > 0; ++k) {
    if (turned.parts[k] != 0) continue;
    turned.values[k].even *= -1.0;
    turned.values[k].odd *= -1.0;
    --left;
  }
  const KernelCorrection of_turned = learned(turned);
  REQUIRE(of_turned.length() == of_more.length());
  REQUIRE(of_turned.ridge() == of_more.ridge());
  double with_it = 0.0;
  for (std::size_t k = 0; k < 20; ++k) {
    CHECK(apart(of_turned.without(0, more.features[k]), of_more.without(0, more.features[k])) < 1e-6);
    with_it = std::max(with_it, apart(of_turned.at(more.features[k]), of_more.at(more.features[k])));
  }
  CHECK(with_it > 1e-4);
}

TEST_CASE("a kernel refuses moments that do not match") {
  KernelSample sample = sample_of(10, 11);
  sample.parts.pop_back();
  CHECK_THROWS_AS(learned(sample), samara::ArgumentError);
  sample.parts.push_back(0);
  sample.values[3].odd = Eigen::Vector2d::Zero();
  CHECK_THROWS_WITH(learned(sample), Catch::Contains("1 even") || Catch::Contains("2 odd"));
  sample.values[3].odd = Eigen::VectorXd::Constant(1, std::numeric_limits<double>::quiet_NaN());
  CHECK_THROWS_WITH(learned(sample), Catch::Contains("not finite"));
}

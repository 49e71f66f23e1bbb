// Winds as text: every key is read into what it means.
#include "samara/codebooks/model/wind_file.h"

#include <fstream>
#include <numbers>

#include <catch2/catch.hpp>

#include "tests/io/temporary_directory.h"

using namespace samara::codebooks;
using namespace samara::models::wind;

namespace {

WindFile read(const std::string& text) {
  const TemporaryDirectory folder;
  std::ofstream(folder.path() / "wind.toml") << text;
  return read_wind(folder.path() / "wind.toml");
}

}  // namespace

TEST_CASE("every key of a wind is read into its place, in SI") {
  const WindFile file = read(R"([mean]
speed = "36 km/h"
height = "20 m"
roughness = "5 cm"
displacement = "40 cm"
towards = "90 deg"
[turbulence]
height = "300 cm"
sigma = "50 cm/s"
length = "7 m"
constants = "k-epsilon"
ratios = [1.0, 0.8, 0.5]
modes = 96
shortest = "4 cm"
longest = "2 km"
frozen = true
[[gusts]]
shape = "step"
velocity = [1, "2 m/s", 3]
start = "500 ms"
duration = "2 s"
[[gusts]]
shape = "extreme_operating"
velocity = [0, 0, 4]
duration = 1
travel = ["5 m/s", 0, 0]
[series]
spectrum = "iec"
sigma = "120 cm/s"
)");
  const ProfileOptions& mean = file.wind.profile.options();
  CHECK(mean.kind == ProfileKind::logarithmic);
  CHECK(mean.speed == Approx(10.0));
  CHECK(mean.height == 20.0);
  CHECK(mean.roughness == Approx(0.05));
  CHECK(mean.displacement == Approx(0.4));
  CHECK(file.wind.towards == Approx(std::numbers::pi / 2.0));
  REQUIRE(file.wind.turbulence);
  const TurbulenceOptions& o = *file.wind.turbulence;
  CHECK(o.height == Approx(3.0));
  CHECK(o.sigma == Approx(0.5));
  CHECK(o.length == Approx(7.0));
  CHECK(o.constants == EnergyConstants::k_epsilon);
  CHECK(o.ratios == Eigen::Vector3d(1.0, 0.8, 0.5));
  CHECK(o.modes == 96);
  CHECK(o.shortest == Approx(0.04));
  CHECK(o.longest == Approx(2000.0));
  CHECK(o.frozen);
  REQUIRE(file.wind.gusts.size() == 2);
  // After its rise a step stays; the other one begins with a dip, and later where it travels to.
  const auto at = [&](std::size_t n, double t, double x) {
    return file.wind.gusts[n].sample(t, Eigen::Vector3d(x, 0.0, 0.0)).velocity;
  };
  CHECK(at(0, 0.5, 9.0).isZero(0.0));
  CHECK((at(0, 1.5, 9.0) - Eigen::Vector3d(0.5, 1.0, 1.5)).norm() < 1e-12);
  CHECK((at(0, 2.5, 9.0) - Eigen::Vector3d(1.0, 2.0, 3.0)).norm() < 1e-12);
  CHECK(at(1, 1.9, 10.0).isZero(0.0));
  CHECK(at(1, 2.2, 10.0).z() < -0.1);
  CHECK(file.wind.gusts[1].duration() == 1.0);
  REQUIRE(file.series);
  CHECK(file.series->spectrum == SeriesSpectrum::iec);
  CHECK(file.series->sigma == Approx(1.2));
  CHECK_FALSE(file.seen);
}

TEST_CASE("other kinds of winds, and what is not given, are read for what they are") {
  const WindFile power = read(
      "[mean]\nprofile = \"power\"\nspeed = 5\nexponent = 0.2\n[turbulence]\nsigma = 1\nlength = "
      "\"iec\"\nheight = 30\n");
  CHECK(power.wind.profile.options().kind == ProfileKind::power);
  CHECK(power.wind.profile.options().exponent == 0.2);
  CHECK(power.wind.profile.options().height == 10.0);
  CHECK(power.wind.turbulence->constants == EnergyConstants::kaimal);
  CHECK_FALSE(power.wind.turbulence->frozen);
  // 0.8 of 0.7 times the height.
  CHECK(power.wind.turbulence->length == Approx(16.8));
  const WindFile seen = read(
      "[mean]\nspeed = 5\n[turbulence]\nkind = \"seen\"\nconstants = \"k-epsilon\"\n[series]\nspectrum = "
      "\"kaimal\"\n");
  CHECK(seen.seen == EnergyConstants::k_epsilon);
  CHECK_FALSE(seen.wind.turbulence);
  CHECK(seen.series->spectrum == SeriesSpectrum::kaimal);
  CHECK(seen.wind.gusts.empty());
}

TEST_CASE("a wind that is a text is read as its file is, whose name its errors have") {
  CHECK(parse_wind("[mean]\nspeed = 5\n", "meadow.toml").wind.profile.options().speed == 5.0);
  CHECK_THROWS_WITH(parse_wind("[mean]\nspeed = 5\nroughness = -1\n", "meadow.toml"),
                    Catch::Contains("meadow.toml:3"));
}

#include <numbers>

#include <catch2/catch.hpp>

#include "bodies_in_flow.h"

using namespace samara::models;

namespace {

/// Motion of a card released at 10 degrees about a horizontal axis, from 5 s to 15 s.
struct Statistics {
  double tilt = 0.0;        ///< greatest angle between normal and vertical, either side up [rad]
  double fall = 0.0;        ///< mean speed of fall [m/s]
  double drift = 0.0;       ///< mean horizontal speed [m/s]
  double half_turns = 0.0;  ///< changes of the side that is up, per second
  double reversals = 0.0;   ///< changes of sign of the rate of rotation, per second
};

using Values = std::map<std::string, double>;

Statistics release(const Eigen::Vector3d& axis, double C_D90, double C_T, double C_R,
                   const Values& more = {}) {
  Values values = {{"a", 0.035},   {"b", 0.02},  {"c", 1e-4},  {"density", 1200.0}, {"C_D90", C_D90},
                   {"C_D0", 0.05}, {"C_T", C_T}, {"C_R", C_R}, {"C_w", 2.0}};
  for (const auto& [name, value] : more) values[name] = value;
  BodyState start;
  start.q = Eigen::AngleAxisd(10.0 * std::numbers::pi / 180.0, axis);
  const double begin = 5.0, end = 15.0;
  std::vector<double> times;
  for (double t = begin; t < end; t += 2e-3) times.push_back(t);
  const Eigen::MatrixXd states = motion(find_model("immersed_body"), values, start, times, 1e-8);
  Statistics statistics;
  for (Eigen::Index k = 0; k < states.rows(); ++k) {
    const double up = BodyState(states.row(k)).R()(2, 2);
    statistics.tilt = std::max(statistics.tilt, std::acos(std::abs(up)));
    if (k == 0) continue;
    const double before = BodyState(states.row(k - 1)).R()(2, 2);
    statistics.half_turns += up * before < 0.0 ? 1.0 : 0.0;
    statistics.reversals +=
        BodyState(states.row(k)).w.dot(axis) * BodyState(states.row(k - 1)).w.dot(axis) < 0.0 ? 1.0 : 0.0;
  }
  const double time = times.back() - times.front();
  statistics.half_turns /= time;
  statistics.reversals /= time;
  const Eigen::VectorXd way = states.row(states.rows() - 1) - states.row(0);
  statistics.fall = -way[2] / time;
  statistics.drift = way.head<2>().norm() / time;
  return statistics;
}

constexpr double kDegree = std::numbers::pi / 180.0;
const Eigen::Vector3d kAboutX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kAboutY = Eigen::Vector3d::UnitY();

/// As the sheet has it: damping by each axis alone, and small floors. With the smoother defaults the card of
/// alternating motion, released about y, autorotates instead, and oblique motion is less wide.
const Values kSheet = {{"damping_isotropy", 0.0}, {"speed_floor", 1e-3}, {"rate_floor", 0.05}};

}  // namespace

// Model sheet, section 4.3: the four sets of coefficients of dissertation Figure 5.6, released about x, about
// y and obliquely. Means over ten seconds of
// periodic motion: a few percent of them is one swing more or less, and the smoothing of speeds below 0.02
// m/s.

TEST_CASE("the coefficients of steady descent give small flutter") {
  const Statistics s = release(kAboutX, 1.81, 0.31, 0.31);
  CHECK(s.tilt < 25.0 * kDegree);
  CHECK(s.tilt > 5.0 * kDegree);
  CHECK(s.half_turns == 0.0);
  CHECK(s.fall == Approx(1.26).epsilon(0.02));
}

TEST_CASE("the coefficients of zigzag give regular wide swings") {
  const Statistics s = release(kAboutX, 0.31, 0.91, 0.61);
  CHECK(s.half_turns == 0.0);
  CHECK(s.tilt > 60.0 * kDegree);
  CHECK(s.tilt < 70.0 * kDegree);
  CHECK(s.fall == Approx(3.4).epsilon(0.05));
  CHECK(s.reversals / 2.0 == Approx(15.9).epsilon(0.02));  // there and back
  CHECK(s.drift < 0.05);
}

TEST_CASE("the coefficients of alternating zigzag and tumbling give tumbling with reversals") {
  const Statistics s = release(kAboutX, 0.61, 1.81, 1.21);
  CHECK(s.half_turns == Approx(14.0).epsilon(0.05));
  CHECK(s.reversals / 2.0 == Approx(2.4).epsilon(0.1));  // there and back
}

TEST_CASE("twice the damping turns tumbling into flutter") {
  const Statistics s = release(kAboutX, 0.61, 1.81, 1.21, {{"C_w", 4.0}});
  CHECK(s.half_turns == 0.0);
}

TEST_CASE("the coefficients of autorotation give autorotation that drifts") {
  const Statistics s = release(kAboutX, 0.61, 2.71, 0.91);
  CHECK(s.reversals == 0.0);
  CHECK(s.half_turns == Approx(13.0).epsilon(0.05));
  CHECK(s.drift == Approx(1.27).epsilon(0.05));
  CHECK(s.fall == Approx(0.29).epsilon(0.1));
}

TEST_CASE(
    "released about y, the card of steady descent flutters and that of zigzag swings wider and slower") {
  const Statistics descent = release(kAboutY, 1.81, 0.31, 0.31);
  CHECK(descent.half_turns == 0.0);
  CHECK(descent.tilt < 29.0 * kDegree);
  CHECK(descent.fall == Approx(1.28).epsilon(0.02));
  const Statistics zigzag = release(kAboutY, 0.31, 0.91, 0.61);
  CHECK(zigzag.half_turns == 0.0);
  CHECK(zigzag.tilt > 65.0 * kDegree);
  CHECK(zigzag.tilt < 76.0 * kDegree);
  CHECK(zigzag.reversals / 2.0 == Approx(8.3).epsilon(0.03));  // there and back
}

TEST_CASE("released about y, the cards that tumble about x tumble too, slower") {
  const Statistics both = release(kAboutY, 0.61, 1.81, 1.21, kSheet);
  CHECK(both.half_turns > 4.0);
  CHECK(both.reversals / 2.0 > 0.3);
  CHECK(both.drift < 0.1);
  const Statistics autorotation = release(kAboutY, 0.61, 2.71, 0.91, kSheet);
  CHECK(autorotation.reversals == 0.0);
  CHECK(autorotation.half_turns == Approx(7.0).epsilon(0.05));
}

TEST_CASE("released obliquely, the card of steady descent leaves the plane, tilts more and falls faster") {
  const Statistics s = release({std::cos(0.6), std::sin(0.6), 0.0}, 1.81, 0.31, 0.31, kSheet);
  CHECK(s.half_turns == 0.0);
  CHECK(s.tilt > 24.0 * kDegree);
  CHECK(s.tilt < 46.0 * kDegree);
  CHECK(s.fall == Approx(1.43).epsilon(0.02));
}

TEST_CASE("in water the card of steady descent sinks steadily at 0.099 m/s") {
  // sqrt(2 (m - m_f) g/(rho_f C_D90 A)); the default floor of 0.02 m/s would be felt at this speed.
  const Statistics s =
      release(kAboutX, 1.81, 0.31, 0.31,
              {{"c", 4e-4}, {"density", 2700.0}, {"fluid_density", 1000.0}, {"speed_floor", 1e-3}});
  CHECK(s.fall == Approx(0.099).epsilon(0.01));
  CHECK(s.tilt < 1.0 * kDegree);
}

#include <numbers>

#include <catch2/catch.hpp>

#include "bodies_in_flow.h"

using namespace samara::models;

namespace {

/// Motion of a card released at 10 degrees about x, after the first second: statistics of a planar motion.
struct Statistics {
  double tilt = 0.0;        ///< greatest angle between normal and vertical, either side up [rad]
  double fall = 0.0;        ///< mean speed of fall [m/s]
  double drift = 0.0;       ///< mean horizontal speed [m/s]
  double half_turns = 0.0;  ///< changes of the side that is up, per second
  double reversals = 0.0;   ///< changes of sign of the rate of rotation, per second
};

Statistics release_about_x(double C_D90, double C_T, double C_R, double C_w = 2.0) {
  const std::map<std::string, double> values = {{"a", 0.035},        {"b", 0.02},      {"c", 1e-4},
                                                {"density", 1200.0}, {"C_D90", C_D90}, {"C_D0", 0.05},
                                                {"C_T", C_T},        {"C_R", C_R},     {"C_w", C_w}};
  BodyState start;
  start.q = Eigen::AngleAxisd(10.0 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitX());
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
    statistics.reversals += states(k, 10) * states(k - 1, 10) < 0.0 ? 1.0 : 0.0;
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

}  // namespace

// The four sets of coefficients of dissertation Figure 5.6, released about x. Means over ten seconds of
// periodic motion: a few percent of them is one swing more or less, and the smoothing of speeds below 0.02
// m/s.

TEST_CASE("the coefficients of steady descent give small flutter") {
  const Statistics s = release_about_x(1.81, 0.31, 0.31);
  CHECK(s.tilt < 25.0 * kDegree);
  CHECK(s.tilt > 5.0 * kDegree);
  CHECK(s.half_turns == 0.0);
  CHECK(s.fall == Approx(1.26).epsilon(0.02));
}

TEST_CASE("the coefficients of zigzag give regular wide swings") {
  const Statistics s = release_about_x(0.31, 0.91, 0.61);
  CHECK(s.half_turns == 0.0);
  CHECK(s.tilt > 60.0 * kDegree);
  CHECK(s.tilt < 70.0 * kDegree);
  CHECK(s.fall == Approx(3.4).epsilon(0.05));
  CHECK(s.reversals / 2.0 == Approx(15.9).epsilon(0.02));  // there and back
  CHECK(s.drift < 0.05);
}

TEST_CASE("the coefficients of alternating zigzag and tumbling give tumbling with reversals") {
  const Statistics s = release_about_x(0.61, 1.81, 1.21);
  CHECK(s.half_turns == Approx(14.0).epsilon(0.05));
  CHECK(s.reversals / 2.0 == Approx(2.4).epsilon(0.1));  // there and back
}

TEST_CASE("twice the damping turns tumbling into flutter") {
  const Statistics s = release_about_x(0.61, 1.81, 1.21, 4.0);
  CHECK(s.half_turns == 0.0);
}

TEST_CASE("the coefficients of autorotation give autorotation that drifts") {
  const Statistics s = release_about_x(0.61, 2.71, 0.91);
  CHECK(s.reversals == 0.0);
  CHECK(s.half_turns == Approx(13.0).epsilon(0.05));
  CHECK(s.drift == Approx(1.27).epsilon(0.05));
  CHECK(s.fall == Approx(0.29).epsilon(0.1));
}

// How a thin plate falls, by its inertia ratio I*: fluttering, tumbling, both in turn, or in chaos. One
// table, of a dimensionless model that ships with Samara, stepped here by the classical Runge-Kutta method.
//
//   example_planar_regimes              # I* from 0.5 to 4
//   example_planar_regimes 1.1 1.4 2    # these alone
//
// A fall starts at theta = 0.4, almost at rest. Its first 500 units of time are left to settle; the next 1500
// are measured. The Lyapunov exponent is the mean rate at which a neighbour, pulled back to a distance of
// 1e-7 after every unit of time, runs away (G. Benettin et al., Meccanica 15 (1980) 9-20); position, on which
// nothing depends, does not count in the distance.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/registry.h"

namespace {

using samara::models::ParametricModel;
using State = Eigen::Matrix<double, 6, 1>;
enum { kVx, kVy, kOmega, kTheta, kX, kY };
constexpr int kPerUnit = 200, kSettling = 500, kMeasured = 1500;  // steps; units of time
constexpr double kStep = 1.0 / kPerUnit;
constexpr double kDistance = 1e-7;

struct Fall {
  double vx = 0.0, vy = 0.0;  ///< mean velocity in the world
  double range = 0.0;         ///< of theta, full turns included
  double period = 0.0;        ///< between changes of w from backward to forward; 0: there are none
  double turns = 0.0;         ///< net, per 100 units of time
  double exponent = 0.0;      ///< Lyapunov, per unit of time
};

class Plate {
 public:
  explicit Plate(double inertia_ratio)
      : model_(samara::models::find_model("falling_plate_nd"),
               {{"inertia_ratio", inertia_ratio}, {"beta", 0.0}}, {}),
        workspace_(model_.make_workspace()) {}

  State start() const {
    State x;
    model_.initial({}, {x.data(), 6});
    return x;
  }

  State stepped(const State& x) {
    const State k1 = rate(x);
    const State k2 = rate(x + kStep / 2 * k1);
    const State k3 = rate(x + kStep / 2 * k2);
    const State k4 = rate(x + kStep * k3);
    return x + kStep / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }

 private:
  State rate(const State& x) {
    State dxdt;
    model_.rhs(0.0, {x.data(), 6}, {}, {dxdt.data(), 6}, workspace_);
    return dxdt;
  }
  ParametricModel model_;
  ParametricModel::Workspace workspace_;
};

Fall measured(double inertia_ratio) {
  Plate plate(inertia_ratio);
  State x = plate.start();
  for (int k = 0; k < kSettling * kPerUnit; ++k) x = plate.stepped(x);
  const State begin = x;
  State neighbour = x;
  neighbour[kVx] += kDistance;
  double growth = 0.0, lowest = x[kTheta], highest = x[kTheta];
  std::vector<double> swings;
  for (int k = 1; k <= kMeasured * kPerUnit; ++k) {
    const State next = plate.stepped(x);
    neighbour = plate.stepped(neighbour);
    if (x[kOmega] < 0.0 && next[kOmega] >= 0.0) {
      swings.push_back(kStep * (k - next[kOmega] / (next[kOmega] - x[kOmega])));
    }
    x = next;
    lowest = std::min(lowest, x[kTheta]);
    highest = std::max(highest, x[kTheta]);
    if (k % kPerUnit != 0) continue;
    const double distance = (neighbour - x).head<4>().norm();
    growth += std::log(distance / kDistance);
    neighbour = x + kDistance / distance * (neighbour - x);
  }
  const State way = (x - begin) / kMeasured;
  const double period =
      swings.size() > 1 ? (swings.back() - swings.front()) / static_cast<double>(swings.size() - 1)
                        : 0.0;
  return {way[kX],
          way[kY],
          highest - lowest,
          period,
          100.0 * way[kTheta] / (2.0 * std::numbers::pi),
          growth / kMeasured};
}

const char* motion(const Fall& fall) {
  if (fall.exponent > 0.03) return "chaotic";  // periodic motions: 0, measured to about 0.01
  if (std::abs(fall.turns) > 0.5) return "tumbling";
  return fall.range > 2.0 * std::numbers::pi ? "mixed" : "flutter";
}

double number(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data(), end, value);
  if (problem == std::errc() && rest == end) return value;
  throw std::runtime_error("\"" + text + "\" is no number");
}

}  // namespace

int main(int count, char** texts) try {
  std::vector<double> ratios = {0.5,  0.8, 1.0, 1.1, 1.2, 1.25, 1.3, 1.35, 1.4,
                                1.45, 1.5, 1.6, 1.7, 2.0, 2.5,  3.0, 4.0};
  if (count > 1) ratios.clear();
  for (int k = 1; k < count; ++k) ratios.push_back(number(texts[k]));
  std::printf("   I*  motion      <vx>    <vy>   range  period  turns/100  exponent\n");
  for (const double ratio : ratios) {
    const Fall fall = measured(ratio);
    std::printf("%5.2f  %-8s  %6.3f  %6.3f  %6.2f  %6.2f  %9.2f  %8.3f\n", ratio, motion(fall),
                fall.vx, fall.vy, fall.range, fall.period, fall.turns, fall.exponent);
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "planar_regimes: inertia ratios, positive numbers, were expected: %s\n",
               error.what());
  return 2;
}

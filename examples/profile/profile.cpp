// The profile of a coefficient, with a fit of your own: a cup cools as T(t) = T0 exp(-k t), in 30
// readings with a noise of 0.5 degrees. Watched for a second, k may be anything; for six, it has an
// upper limit; for a minute, it is known.
#include "samara/identification/statistics/profile.h"

#include <cmath>
#include <cstdio>
#include <random>

using namespace samara::identification;

constexpr double kNoise = 0.5, kRate = 1e-3, kStart = 60.0;  // degrees, 1/s, degrees above the room

struct Cooling {
  std::vector<double> t, T;
};

Cooling watch(double seconds) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, kNoise);
  Cooling seen;
  for (int k = 0; k < 30; ++k) {
    seen.t.push_back(seconds * k / 29.0);
    seen.T.push_back(kStart * std::exp(-kRate * seen.t.back()) + noise(random));
  }
  return seen;
}

// With k held, T0 is a linear fit: this is the minimisation over everything else. The cost is 1/2
// sum of squares in units of the noise, so that the dispersion is 1.
std::optional<ProfileSolution> cost_at(const Cooling& seen, double k) {
  double above = 0.0, below = 0.0, cost = 0.0;
  for (std::size_t i = 0; i < seen.t.size(); ++i) {
    above += seen.T[i] * std::exp(-k * seen.t[i]);
    below += std::exp(-2.0 * k * seen.t[i]);
  }
  for (std::size_t i = 0; i < seen.t.size(); ++i)
    cost += 0.5 * std::pow((seen.T[i] - above / below * std::exp(-k * seen.t[i])) / kNoise, 2);
  return ProfileSolution{cost, Eigen::VectorXd::Constant(1, above / below)};
}

int main() {
  for (const double seconds : {1.0, 6.0, 60.0}) {
    const Cooling seen = watch(seconds);
    double best = 1e-6;  // a scan stands for the fit
    for (double k = 2e-6; k < 1e-2; k += 1e-6) {
      if (cost_at(seen, k)->cost < cost_at(seen, best)->cost) best = k;
    }
    const Profile p =
        profile({.name = "k",
                 .best = best,
                 .best_cost = cost_at(seen, best)->cost,
                 .lower = 0.0,
                 .upper = 1e-2},
                {}, [&](double k, const Eigen::VectorXd&) { return cost_at(seen, k); });
    std::printf("%5.0f s: %s, %s\n", seconds, to_string(p.shape).c_str(), describe(p).c_str());
  }
}

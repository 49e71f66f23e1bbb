#include "samara/models/stochastic/ensemble.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <boost/iterator/counting_iterator.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <fmt/format.h>

#include "samara/models/stochastic/ensemble_sums.h"

namespace samara::models {

namespace {

constexpr long kLandingGroup = 32;

/// Linear between the values next to a share of sorted ones.
double quantile_of(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

/// Chance that at most k of n independent values lie below their quantile of a share.
double binomial_below(long k, long n, double share) {
  if (k < 0) return 0.0;
  return k >= n ? 1.0 : boost::math::ibetac(static_cast<double>(k) + 1.0, static_cast<double>(n - k), share);
}

/// Numbers, from 0, of the sorted values between which a quantile lies with 95 %: the tails hold 2.5 % at most each.
/// The second may be n, the first -1: no value of the sample is so far out.
std::pair<long, long> quantile_ranks(long n, double share) {
  // Value j lies above the quantile where at most j values lie below it.
  const boost::counting_iterator<long> begin(0), end(n);
  const auto lower =
      std::partition_point(begin, end, [&](long j) { return binomial_below(j, n, share) <= 0.025; });
  const auto upper =
      std::partition_point(begin, end, [&](long j) { return 1.0 - binomial_below(j, n, share) > 0.025; });
  return {*lower - 1, *upper};
}

}  // namespace

long Ensemble::count(RealisationStatus which) const {
  return std::ranges::count(status, which);
}

LandingStatistics landing_statistics(const Ensemble& ensemble) {
  LandingStatistics result;
  result.landed = static_cast<long>(ensemble.landings.size());
  // Time and place together: entry 0 and entries 1 to 3.
  TimeSums sums(4);
  TimeSums group(4);
  const long together = ensemble.antithetic ? 2 : 1;
  Eigen::Vector4d pair = Eigen::Vector4d::Zero();
  double in_pair = 0.0;
  const std::vector<Landing>& all = ensemble.landings;
  for (std::size_t n = 0; n < all.size(); ++n) {
    const Eigen::Vector4d row(all[n].t, all[n].position.x(), all[n].position.y(), all[n].position.z());
    group.single.add(row);
    pair += row;
    in_pair += 1.0;
    const bool is_last = n + 1 == all.size();
    if (is_last || all[n + 1].realisation / together != all[n].realisation / together) {
      group.independent.add(pair / in_pair);
      pair.setZero();
      in_pair = 0.0;
    }
    if (is_last || all[n + 1].realisation / kLandingGroup != all[n].realisation / kLandingGroup) {
      group.close_group();
      sums.merge(group);
      group = TimeSums(4);
    }
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd mean = all.empty() ? Eigen::VectorXd::Constant(4, nan) : sums.single.mean();
  const Eigen::VectorXd error = sums.independent.error_of_mean();
  const Eigen::MatrixXd covariance_error = sums.groups.error_of_mean().reshaped(4, 4);
  result.t = {mean[0], error[0]};
  result.mean = mean.tail<3>();
  result.mean_error = error.tail<3>();
  result.covariance = sums.single.covariance().bottomRightCorner<3, 3>();
  result.covariance_error = covariance_error.bottomRightCorner<3, 3>();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<double> sorted;
    for (const Landing& landing : all) sorted.push_back(landing.position[axis]);
    std::ranges::sort(sorted);
    const auto at = [&](long rank) {
      return rank >= 0 && rank < result.landed ? sorted[static_cast<std::size_t>(rank)] : nan;
    };
    for (Eigen::Index i = 0; i < 5; ++i) {
      result.quantiles(i, axis) = sorted.empty() ? nan : quantile_of(sorted, kLandingShares[i]);
      const auto [lower, upper] = quantile_ranks(result.landed, kLandingShares[i]);
      result.quantiles_lower(i, axis) = at(lower);
      result.quantiles_upper(i, axis) = at(upper);
    }
  }
  return result;
}

std::string better_step(const Ensemble& cloud, std::string_view option) {
  if (cloud.count(RealisationStatus::not_finite) > 0) return "flights diverged, shorter ones are needed";
  return fmt::format("{}{:.2g} would do", option, 0.1 * cloud.steps.shortest);
}

std::string doubt_of_steps(const Ensemble& cloud, std::string_view option) {
  if (!(cloud.steps.beyond_third > 0.05)) return {};
  return fmt::format(
      "{:.0f} % of the steps of {:.3g} s are longer than 0.3 of the time in which the air changes; {}",
      100.0 * cloud.steps.beyond_third, cloud.step, better_step(cloud, option));
}

}  // namespace samara::models

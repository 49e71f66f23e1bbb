#include "samara/identification/following/noise_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/base/require.h"
#include "samara/identification/following/followed_model.h"
#include "samara/identification/following/followed_motion.h"

namespace samara::identification {

namespace {

/// Frames that come a little early or late are those that were meant.
constexpr double kSameFrame = 1e-6;
/// A forecast that fails, or is off by more, counts as one so unlikely: one of them must not decide.
constexpr double kLeastDensity = -50.0;

/// A number, what is said of it, and whether it is looked for.
struct SearchedNumber {
  double NoiseChoice::*number;
  std::optional<double> GivenNoise::*given;
  bool NoiseSearch::*is_sought;
  double ModelNoise::*noise = nullptr;  ///< that it becomes; null: another number
};
constexpr SearchedNumber kNumbers[] = {
    {&NoiseChoice::noise_factor, &GivenNoise::noise_factor, &NoiseSearch::finds_noise_factor},
    {&NoiseChoice::velocity, &GivenNoise::velocity, &NoiseSearch::finds_velocity, &ModelNoise::velocity},
    {&NoiseChoice::rate, &GivenNoise::rate, &NoiseSearch::finds_rate, &ModelNoise::rate},
    {&NoiseChoice::spread, &GivenNoise::spread, &NoiseSearch::finds_spread},
    {&NoiseChoice::drift, &GivenNoise::drift, &NoiseSearch::finds_drift}};

struct Score {
  double sum = 0.0;
  int frames = 0;
};

/// Logarithm of the density of what was seen, of the outputs that were.
/// @param periods of outputs; 0: none
double log_density(const Forecast& forecast, const Eigen::RowVectorXd& seen,
                   const std::vector<double>& periods) {
  std::vector<Eigen::Index> there;
  for (Eigen::Index o = 0; o < std::ssize(forecast.outputs); ++o) {
    if (!std::isnan(seen[o])) there.push_back(o);
  }
  double density = 0.0;
  for (const ForecastComponent& component : forecast.components) {
    Eigen::MatrixXd covariance(std::ssize(there), std::ssize(there));
    Eigen::VectorXd whitened(std::ssize(there));
    for (Eigen::Index i = 0; i < whitened.size(); ++i) {
      const Eigen::Index o = there[static_cast<std::size_t>(i)];
      whitened[i] = seen[o] - component.mean(0, o);
      const double period = periods[static_cast<std::size_t>(o)];
      if (period > 0.0) whitened[i] = std::remainder(whitened[i], period);
      for (Eigen::Index j = 0; j < whitened.size(); ++j)
        covariance(i, j) = component.covariance[0](o, there[static_cast<std::size_t>(j)]);
    }
    const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
    if (!whitened.allFinite() || llt.info() != Eigen::Success) continue;
    llt.matrixL().solveInPlace(whitened);
    double log_root = 0.0;
    for (Eigen::Index k = 0; k < whitened.size(); ++k)
      log_root += std::log(llt.matrixLLT()(k, k)) + 0.5 * std::log(2.0 * std::numbers::pi);
    density += component.weight * std::exp(-0.5 * whitened.squaredNorm() - log_root);
  }
  return std::max(kLeastDensity, std::log(density));
}

Score score_capture(const std::shared_ptr<const models::Model>& model, const FollowOptions& options,
                    const Capture& capture, const NoiseSearch& search) {
  Follower follower(model, options);
  check_steps(options, capture, search.ahead);
  const Eigen::MatrixXd values = frames_of(follower, model->info(), capture);
  std::vector<double> periods;
  const FollowedModel followed(model, options);
  for (const SeenOutput& output : followed.measured()) periods.push_back(output.period);
  const auto outputs = std::ssize(periods);
  Score score;
  double next_origin = 0.0;
  for (Eigen::Index k = 0; k < values.rows(); ++k) {
    const FollowedFrame frame = add_frame(follower, capture, values, k);
    if (search.ahead <= 0.0) {
      const bool says_nothing = frame.log_likelihood == 0.0;
      if (says_nothing && frame.status != FollowStatus::lost) continue;
      // Lost without a word: the motion broke down before the frame.
      score.sum += says_nothing ? kLeastDensity : std::max(kLeastDensity, frame.log_likelihood);
      ++score.frames;
      continue;
    }
    if (!follower.is_following() || capture.times[k] < next_origin - kSameFrame) continue;
    next_origin = capture.times[k] + search.stride;
    Eigen::Index ahead = k;
    while (ahead < values.rows() && capture.times[ahead] < capture.times[k] + search.ahead - kSameFrame)
      ++ahead;
    if (ahead >= values.rows()) continue;
    const Eigen::RowVectorXd seen = values.row(ahead).head(outputs);
    if (seen.array().isNaN().all()) continue;
    score.sum += log_density(follower.forecast({&capture.times[ahead], 1}), seen, periods);
    ++score.frames;
  }
  return score;
}

}  // namespace

NoiseChoice as_given(const GivenNoise& given) {
  NoiseChoice choice{.velocity = 0.0, .rate = 0.0, .spread = 0.0, .drift = 0.0};
  for (const SearchedNumber& one : kNumbers)
    choice.*one.number = (given.*one.given).value_or(choice.*one.number);
  return choice;
}

NoiseSearch without_given(NoiseSearch search, const GivenNoise& given) {
  for (const SearchedNumber& one : kNumbers) {
    const std::optional<double>& value = given.*one.given;
    if (!value) continue;
    search.start.*one.number = *value;
    search.*one.is_sought = false;
  }
  return search;
}

bool has_noise(const models::ModelInfo& info, double ModelNoise::*noise) {
  return std::ranges::any_of(info.states,
                             [&](const models::StateInfo& state) { return noise_by_unit(state) == noise; });
}

FollowOptions with_noise(FollowOptions options, const NoiseChoice& choice) {
  for (auto& [name, noise] : options.noise) noise *= choice.noise_factor;
  if (options.attitude_noise) *options.attitude_noise *= choice.noise_factor;
  options.model_noise.velocity = choice.velocity;
  options.model_noise.rate = choice.rate;
  for (std::size_t j = 0; j < options.coefficients.size(); ++j) {
    FollowedCoefficient& c = options.coefficients[j];
    if (c.own) continue;
    const double size = c.logarithmic ? 1.0 : std::abs(c.value);
    c.drift = choice.drift * size;
    c.deviation = std::hypot(c.deviation, choice.spread * size);
    const auto at = static_cast<Eigen::Index>(j);
    if (options.coefficient_covariance.size() > 0)
      options.coefficient_covariance(at, at) += std::pow(choice.spread * size, 2);
  }
  return options;
}

NoiseChoice score_of(const std::shared_ptr<const models::Model>& model,
                     std::span<const FollowOptions> options, std::span<const Capture> captures,
                     const NoiseSearch& search, NoiseChoice choice) {
  std::vector<Score> scores(captures.size());
  parallel_for(std::ssize(captures), [&](std::ptrdiff_t k) {
    const auto n = static_cast<std::size_t>(k);
    scores[n] = score_capture(model, with_noise(options[n], choice), captures[n], search);
  });
  Score all;
  for (const Score& score : scores) {
    all.sum += score.sum;
    all.frames += score.frames;
  }
  choice.frames = all.frames;
  choice.score = all.frames > 0 ? all.sum / all.frames : kLeastDensity;
  return choice;
}

NoiseChoice choose_noise(const std::shared_ptr<const models::Model>& model,
                         std::span<const FollowOptions> options, std::span<const Capture> captures,
                         const NoiseSearch& search) {
  require_not_negative(search.ahead, "ahead", "the choice of noise");
  require_not_negative(search.stride, "stride", "the choice of noise");
  if (captures.empty() || options.size() != captures.size()) {
    throw ArgumentError(
        fmt::format("noise was to be chosen on {} captures with options of {}; as many, and one at "
                    "least, were expected",
                    captures.size(), options.size()));
  }
  NoiseChoice start = search.start;
  std::vector<double NoiseChoice::*> sought;
  for (const SearchedNumber& one : kNumbers) {
    if (one.noise != nullptr && !has_noise(model->info(), one.noise)) {
      start.*one.number = 0.0;
    } else if (search.*one.is_sought) {
      sought.push_back(one.number);
    }
  }
  NoiseChoice best = score_of(model, options, captures, search, start);
  int evaluations = 1;
  constexpr double kFactors[] = {4.0, 2.0, 1.4};
  for (int round = 0; round < search.rounds; ++round) {
    const double factor = kFactors[std::min(round, 2)];
    for (double NoiseChoice::*const number : sought) {
      for (const double step : {factor, 1.0 / factor}) {
        bool gained = false;
        // On the same way as long as it gains.
        while (true) {
          NoiseChoice trial = best;
          trial.*number *= step;
          trial = score_of(model, options, captures, search, trial);
          ++evaluations;
          if (!(trial.score > best.score)) break;
          best = trial;
          gained = true;
          constexpr double kFarEnough = 1e6;
          if (best.*number > kFarEnough * start.*number || best.*number * kFarEnough < start.*number) break;
        }
        if (search.progress && !search.progress({"following captures", std::min(0.99, 0.02 * evaluations)})) {
          best.evaluations = evaluations;
          return best;
        }
        if (gained) break;
      }
    }
  }
  best.evaluations = evaluations;
  return best;
}

}  // namespace samara::identification

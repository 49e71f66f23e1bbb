#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/forecasts/autoregression.h"
#include "samara/identification/forecasts/forecast_mixture.h"
#include "samara/identification/forecasts/local_shares.h"
#include "samara/identification/forecasts/novelty.h"

/// Every predictor of a motion at one horizon as a distribution: what it says, and the errors that it showed on
/// training motions.
///
/// Predictors are the model, the plain baselines (baseline_scores.h), the "mixture of baselines" (shares of
/// convex_shares()), the "autoregression" of training motions, and the "mixture" of model, autoregression
/// and baselines, with shares that vary with speed, acceleration and disagreement of predictors where that
/// helps (local_shares.h). All shares and weights come from training moments. Errors of all vary with the
/// speed and the novelty of the motion (novelty.h), those of the mixture with the disagreement of
/// predictors, too. They come from all moments in which a predictor gives a forecast; of the mixture, from those
/// without a model only where its share is below a tenth.
///
/// What training moments taught of a baseline holds for moments in which it is about as sure: where the noise of frames
/// grows more than twice as much on the way (noise_gain()) as in any training moment, since fewer frames were seen or
/// the way is longer, it leaves its share in both mixtures to the others. So does the autoregression where the way is
/// twice as long, or half.
namespace samara::identification {

inline constexpr const char* kMixtureOfBaselines = "mixture of baselines";
inline constexpr const char* kAutoregression = "autoregression";
inline constexpr const char* kMixture = "mixture";

/// Whether it is a plain baseline, or their mixture.
bool is_plain(const std::string& predictor);

/// A moment, and what was asked there.
struct AskedMoment {
  TrainingMoment moment = {};
  double time = 0.0;  ///< s, of the next place, in the times of what was seen
  /// What the model says, fitted without the moment's motion; empty: not asked.
  Eigen::RowVectorXd model = {};
  /// In training: it is less like those that are to be forecast, as of another body that known numbers tell from
  /// theirs, and teaches the autoregression alone.
  bool for_autoregression_only = false;
};

struct SaidForecast {
  std::string predictor;
  Eigen::RowVectorXd mean = {};           ///< NaN: no forecast
  std::vector<NormalMixture> parts = {};  ///< of each component; empty: no forecast, or no errors are known
};

class TrainedForecasts {
 public:
  /// @param moments of one horizon. Those without a model train the autoregression and what is said of
  ///   baselines; those with one everything else
  static TrainedForecasts train(std::span<const AskedMoment> moments, const Components& components);
  /// With an autoregression that these moments, but for their models, have trained.
  static TrainedForecasts train(std::span<const AskedMoment> moments, const Components& components,
                                const Autoregression& autoregression);
  const Autoregression& autoregression() const { return autoregression_; }

  /// In the order: model, baselines, mixture of baselines, autoregression, mixture.
  std::vector<SaidForecast> say(const AskedMoment& asked) const;
  /// The same, with another's word for the autoregression's.
  std::vector<SaidForecast> say(const AskedMoment& asked, const Eigen::RowVectorXd& autoregression) const;

  /// Whether there is a mixture: some training moment had a model, and all others spoke there.
  bool is_mixed() const { return shares_.of_all().size() > 0; }
  /// Whether the mixture has a distribution.
  bool has_band() const { return !errors_.empty() && errors_.back().is_fitted(); }

  /// Of the mixture over all training moments, by predictor: those that are more than 0.
  struct Share {
    std::string predictor;
    double share;
  };
  std::vector<Share> shares() const;

 private:
  /// What mixtures take of one moment: NaN from those that are not as sure as in training.
  std::vector<Eigen::MatrixXd> heard_by_mixtures(const AskedMoment& asked,
                                                 std::vector<Eigen::MatrixXd> said) const;

  Components components_ = {};
  Autoregression autoregression_ = {};
  std::vector<double> gains_ = {};                 ///< the largest noise_gain() of each baseline in training
  double shortest_way_ = 0.0, longest_way_ = 0.0;  ///< s, from the last frame seen to what was asked
  Eigen::VectorXd of_baselines_ = {};              ///< shares in their mixture
  std::vector<std::size_t> mixed_ = {};  ///< of model, baselines, autoregression: those in the mixture
  LocalShares shares_ = {};              ///< of these
  Novelty novelty_ = {};
  std::vector<ErrorDistribution> errors_ = {};  ///< in the order of say()
};

}  // namespace samara::identification

#pragma once

#include <map>
#include <string>
#include <vector>

#include "identification/windows.h"
#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/forecasts/trained_forecasts.h"

/// Forecasts of one split of the motions, held to what came.
namespace samara::benchmarks::prediction {

using samara::identification::AskedMoment;
using samara::identification::Components;
using samara::identification::PredictionScore;

/// The window as a moment of a motion.
/// @param model where the model is then; empty: not asked. What is not finite counts as no forecast
/// @param net_weight m/s^2, as of SeenMotion
AskedMoment moment_of(const identification::Window& window, int cluster, const Eigen::VectorXd& known = {},
                      const Eigen::RowVectorXd& model = {},
                      double net_weight = samara::identification::kStandardG);

/// Of a fit of windows, each `stride`-th from the first on.
identification::Coefficients coefficients_of(const samara::models::TrajectoryFamily& family,
                                             const samara::identification::FitOptions& options,
                                             const std::vector<identification::Window>& windows,
                                             std::size_t stride);

/// Positions in space, the last component up.
inline const Components kInSpace = {.level = {0, 1}};

struct SplitScores {
  std::map<std::string, PredictionScore> of = {};  ///< by predictor
};

/// Moments of the motions that a forecast may know, and of those that it is asked about.
struct Questioned {
  std::vector<AskedMoment> training = {}, unseen = {};
};

/// Every predictor trained on some moments and scored on others, of all parts together; a table on stderr.
SplitScores score_split(const std::string& name, const std::vector<Questioned>& parts);
inline SplitScores score_split(const std::string& name, const std::vector<AskedMoment>& training,
                               const std::vector<AskedMoment>& unseen) {
  return score_split(name, {{training, unseen}});
}

/// Metrics of a case, each from the split in which it is worst: median, rms and crps with the best plain baseline of
/// that split, and the coverage that is farthest from what it should be, with its error, and the mean of all splits.
/// The mixture is ours. Beside it, of the same splits: the mixture of everything but the body, the autoregression, the
/// body alone, and where views are seen the mixture without them.
/// @param suffix of the names of metrics
void report(const std::string& test_case, const std::vector<SplitScores>& splits,
            const std::string& suffix = "");

}  // namespace samara::benchmarks::prediction

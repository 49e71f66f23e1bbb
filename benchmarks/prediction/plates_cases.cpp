/// Square plates that settle in water, 0.4 swings beyond a window of one swing, on eight drops that had no part
/// in the fit of eight others, in three splits drawn with the seeds 1 to 3. A moment is asked about every third
/// frame. All drops that are not asked about teach the autoregression and the baselines. Where they are few,
/// those that the source's index flags teach the autoregression, too. Body and baselines see positions alone,
/// the autoregression silhouettes besides.
///
/// Cleaning takes out frames far from their neighbours on both sides: windows that are predicted are cleaned without
/// what came after them.
#include <algorithm>
#include <span>

#include <fmt/format.h>

#include "bound.h"
#include "cases.h"
#include "identification/settling_plates.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/pgd/tensors/random.h"
#include "scored_split.h"

namespace samara::benchmarks::prediction {

namespace {

using identification::PlateKind;
using identification::Window;
using samara::identification::Capture;
using samara::identification::FitOptions;

constexpr std::size_t kDrops = 8;
constexpr int kSplits = 3;
// Frames from moment to moment: of those that are asked about and of those of the fit; where the body is not asked; and
// there, where drops are few.
constexpr int kAsked = 3, kFitted = 5, kDense = 2, kEvery = 1;

FitOptions options_of_fit() {
  FitOptions options = identification::settling_options();
  options.starts.rounds = 1;
  return options;
}

/// @param cut_drop windows of a drop
template <typename CutDrop>
std::vector<Window> windows_of(const std::vector<Capture>& drops, std::span<const std::size_t> order,
                               const CutDrop& cut_drop) {
  std::vector<Window> windows;
  for (std::size_t k = 0; k < order.size(); ++k) {
    for (Window& window : cut_drop(drops[order[k]])) {
      window.capture.labels["number"] = fmt::format("{}", order[k]);
      windows.push_back(std::move(window));
    }
  }
  return windows;
}

int number_of(const Window& window) {
  return std::stoi(window.capture.labels.at("number"));
}

/// m/s^2, of plates in water.
double net_weight(const PlateKind& kind) {
  return samara::identification::kStandardG * (1.0 - identification::kWater / kind.density);
}

/// @param model as of moment_of()
AskedMoment plate_moment(const Window& window, int cluster, const PlateKind& kind,
                         const Eigen::RowVectorXd& model = {}) {
  AskedMoment moment = moment_of(window, cluster, {}, model, net_weight(kind));
  moment.moment.seen.views = identification::silhouettes_of(window.capture);
  return moment;
}

/// Windows predicted by a fit of every third one of others.
std::vector<AskedMoment> asked(const PlateKind& kind, const std::vector<Window>& others,
                               const std::vector<Window>& left_out) {
  const auto family = identification::plate_family(kind);
  const FitOptions options = options_of_fit();
  const auto predicted = identification::predict_unseen(
      *family, options, coefficients_of(*family, options, others, 3), left_out);
  fmt::print(stderr, "  {} windows predicted in {:.1f} s\n", left_out.size(), predicted.fit.seconds);
  std::vector<AskedMoment> moments;
  for (std::size_t k = 0; k < left_out.size(); ++k)
    moments.push_back(plate_moment(left_out[k], number_of(left_out[k]), kind,
                                   predicted.next.row(static_cast<Eigen::Index>(k))));
  return moments;
}

/// Of drops: the first ones are fitted, those after them asked about.
std::vector<std::size_t> order_of(std::size_t count, int seed) {
  pgd::Random random(static_cast<std::uint64_t>(seed));
  return identification::random_order(count, random);
}

/// Windows of drops with jumps, gaps or doubtful labels, without the jumps: the autoregression learns of them too.
std::vector<AskedMoment> of_flagged(const std::vector<Capture>& flagged, const PlateKind& kind, int first) {
  constexpr double kJump = 0.02;  // m, from frame to frame: what the source's index calls one
  std::vector<AskedMoment> moments;
  for (std::size_t k = 0; k < flagged.size(); ++k) {
    const Eigen::MatrixX3d positions = identification::positions_of(flagged[k]);
    // A window across a gap would teach a later place.
    const double longest =
        (kind.frames - 1 + kind.ahead + 0.5) * samara::identification::median_interval(flagged[k].times);
    for (const Window& window : identification::cut(flagged[k], kind.frames, kind.ahead, kEvery)) {
      const Eigen::MatrixX3d all = positions.middleRows(window.first, kind.frames + kind.ahead);
      const Eigen::MatrixX3d steps = all.bottomRows(all.rows() - 1) - all.topRows(all.rows() - 1);
      if (!(steps.rowwise().norm().maxCoeff() < kJump) || window.next_time > longest) continue;
      AskedMoment moment = plate_moment(window, first + static_cast<int>(k), kind);
      moment.for_autoregression_only = true;
      moments.push_back(std::move(moment));
    }
  }
  return moments;
}

/// Flagged drops teach where clean ones are fewer than this: 19 of PTFE, where folds of the training gain a seventh by
/// them. Those of POM, of which 35 are clean, gain 1 %.
constexpr std::size_t kEnough = 30;

/// Measured drops of one kind of plates.
struct PlateDrops {
  std::vector<Capture> clean = {}, flagged = {};
};

SplitScores one_split(const std::string& test_case, const PlateDrops& of_kind, const PlateKind& kind,
                      int seed) {
  const std::vector<Capture>& drops = of_kind.clean;
  const std::vector<std::size_t> order = order_of(drops.size(), seed);
  const auto cut_every = [&](int stride) {
    return [&kind, stride](const Capture& drop) {
      return identification::cut(drop, kind.frames, kind.ahead, stride);
    };
  };
  const auto as_known = [&](const Capture& drop) {
    return identification::cut_as_known(drop, kind.frames, kind.ahead, kAsked);
  };
  const std::size_t fitted = std::min(kDrops, order.size()), seen = std::min(2 * kDrops, order.size());
  const std::span<const std::size_t> of_fit = std::span(order).first(fitted),
                                     unseen = std::span(order).subspan(fitted, seen - fitted);
  std::vector<std::size_t> halves[2], known(of_fit.begin(), of_fit.end());
  for (std::size_t k = 0; k < fitted; ++k) halves[k % 2].push_back(order[k]);
  known.insert(known.end(), order.begin() + static_cast<std::ptrdiff_t>(seen), order.end());
  std::vector<AskedMoment> training;
  for (const int half : {0, 1}) {
    for (AskedMoment& moment : asked(kind, windows_of(drops, halves[1 - half], cut_every(0)),
                                     windows_of(drops, halves[half], cut_every(kFitted))))
      training.push_back(std::move(moment));
  }
  for (const Window& window : windows_of(drops, known, cut_every(of_kind.flagged.empty() ? kDense : kEvery)))
    training.push_back(plate_moment(window, number_of(window), kind));
  for (AskedMoment& moment : of_flagged(of_kind.flagged, kind, static_cast<int>(drops.size())))
    training.push_back(std::move(moment));
  return score_split(
      fmt::format("{} split {}", test_case, seed), training,
      asked(kind, windows_of(drops, of_fit, cut_every(0)), windows_of(drops, unseen, as_known)));
}

constexpr const char* kBound = "plates_bound";

/// Of the drops of the first split.
void bound_of(const std::string& name, const std::vector<Capture>& drops, const PlateKind& kind) {
  const std::vector<std::size_t> order = order_of(drops.size(), 1);
  const std::span<const std::size_t> of_fit = std::span(order).first(std::min(kDrops, order.size())),
                                     unseen = std::span(order).subspan(of_fit.size());
  const auto windows = [&](std::span<const std::size_t> of, int stride) {
    return windows_of(drops, of.first(std::min(kDrops, of.size())), [&](const Capture& drop) {
      return identification::cut(drop, kind.frames, kind.ahead, stride);
    });
  };
  const auto family = identification::plate_family(kind);
  Bound bound{.family = family.get(), .options = options_of_fit(), .noise = noise_of(drops)};
  bound.coefficients = coefficients_of(*family, bound.options, windows(of_fit, 0), 3);
  bound.moment_of = [&](const Window& window, const Eigen::RowVectorXd& model) {
    return moment_of(window, number_of(window), {}, model, net_weight(kind));
  };
  report_bound(kBound, "_" + name, bound, windows(of_fit, kFitted), windows(unseen, kFitted));
}

struct Material {
  std::string name, test_case, suffix;
};
const std::vector<Material> kMaterials = {{"POM", "plates_pom", "pom"}, {"PTFE", "plates_ptfe", "ptfe"}};

}  // namespace

void plates_cases(const Options& options) {
  for (const auto& [material, test_case, suffix] : kMaterials) {
    const auto folder = identification::measured_set(options, test_case, "settling-plates-water-cardiff");
    if (!folder) continue;
    const PlateKind& kind = identification::plate_kind(material);
    PlateDrops drops = {.clean = identification::plate_drops(*folder, kind)};
    if (drops.clean.size() < kEnough) drops.flagged = identification::flagged_plate_drops(*folder, kind);
    std::vector<SplitScores> splits;
    for (int seed = 1; seed <= (options.quick ? 1 : kSplits); ++seed)
      splits.push_back(one_split(test_case, drops, kind, seed));
    report(test_case, splits);
  }
  const auto folder = identification::measured_set(options, kBound, "settling-plates-water-cardiff");
  for (const auto& [material, test_case, suffix] : kMaterials) {
    const PlateKind& kind = identification::plate_kind(material);
    if (folder) bound_of(suffix, identification::plate_drops(*folder, kind), kind);
  }
}

}  // namespace samara::benchmarks::prediction

/// Sheets of paper in air, from positions alone: 0.1 s beyond a window of 0.2 s, on 20 drops that had no part in
/// the fit of 20 others, in five splits drawn with the seeds 1 to 5. A moment is asked about every fourth frame: of
/// windows that follow each other there are so few that a split's median is a lottery.
///
/// Every number that a forecast needs comes from drops that are not asked about. Those of the fit: the body's
/// coefficients; its errors, by halves of them that predict each other; shares of the mixture. Those and all others of
/// the shape: shares and errors of baselines, and errors of the autoregression, which learns from drops of other shapes
/// too.
#include <fmt/format.h>

#include "bound.h"
#include "cases.h"
#include "identification/falling_paper.h"
#include "scored_split.h"

namespace samara::benchmarks::prediction {

namespace {

using identification::Window;
using samara::identification::Capture;
using samara::identification::FitOptions;

constexpr std::size_t kDrops = 20;
constexpr int kSplits = 5;
constexpr int kFrames = 20;  ///< of a window
// Frames from moment to moment: of those that are asked about and of those of the fit; where the body is not asked, of
// the fit, of other drops of the shape and of other shapes.
constexpr int kAsked = 4, kFitted = 10, kDense = 3, kRest = 8, kOtherShapes = 16;

/// One start and one round: coefficients move less between them than between halves of the drops.
FitOptions options_of_fit() {
  FitOptions options = identification::paper_options();
  options.starts.rounds = 1;
  return options;
}

Eigen::VectorXd known_of(const Window& window) {
  return Eigen::VectorXd::Constant(1, std::stod(window.capture.labels.at("disc_radius")));
}

/// Numbers of the drops, from 0.
class Drops {
 public:
  int number(const Window& window) {
    return numbers_.try_emplace(window.capture.labels.at("traj"), static_cast<int>(numbers_.size()))
        .first->second;
  }

 private:
  std::map<std::string, int> numbers_;
};

/// Windows predicted by a fit of others, of every second one: more of them move its coefficients less than other
/// drops do.
std::vector<AskedMoment> asked(const std::vector<Window>& others, const std::vector<Window>& left_out,
                               Drops& drops) {
  const auto family = identification::paper_family();
  const FitOptions options = options_of_fit();
  const auto predicted = identification::predict_unseen(
      *family, options, coefficients_of(*family, options, others, 2), left_out);
  fmt::print(stderr, "  {} windows predicted in {:.1f} s\n", left_out.size(), predicted.fit.seconds);
  std::vector<AskedMoment> moments;
  for (std::size_t k = 0; k < left_out.size(); ++k) {
    moments.push_back(moment_of(left_out[k], drops.number(left_out[k]), known_of(left_out[k]),
                                predicted.next.row(static_cast<Eigen::Index>(k))));
  }
  return moments;
}

/// What motions of other bodies teach.
std::vector<AskedMoment> other_bodies(const std::vector<std::vector<Capture>>& shapes, std::size_t but,
                                      Drops& drops) {
  std::vector<AskedMoment> moments;
  for (std::size_t shape = 0; shape < shapes.size(); ++shape) {
    if (shape == but) continue;
    for (const Capture& drop : shapes[shape]) {
      for (const Window& window :
           identification::cut(drop, kFrames, identification::kPaperAhead, kOtherShapes)) {
        AskedMoment moment = moment_of(window, drops.number(window), known_of(window));
        moment.for_autoregression_only = true;
        moments.push_back(std::move(moment));
      }
    }
  }
  return moments;
}

SplitScores one_split(const std::string& test_case, const std::vector<std::vector<Capture>>& shapes,
                      std::size_t shape, int seed) {
  const auto split = [&](int stride) {
    return identification::split(shapes[shape], kDrops, kFrames, static_cast<std::uint64_t>(seed), stride);
  };
  const identification::PaperSplit windows = split(0);
  Drops drops;
  const auto half_of = [&](const std::vector<Window>& all, int half) {
    std::vector<Window> of_half;
    for (const Window& window : all) {
      if (drops.number(window) % 2 == half) of_half.push_back(window);
    }
    return of_half;
  };
  for (const Window& window : windows.fitted) drops.number(window);
  const std::vector<Window> more = split(kFitted).fitted;
  std::vector<AskedMoment> training;
  for (const int half : {0, 1}) {
    for (AskedMoment& moment : asked(half_of(windows.fitted, 1 - half), half_of(more, half), drops))
      training.push_back(std::move(moment));
  }
  const std::vector<Window> dense = split(kDense).fitted, rest = split(kRest).rest;
  for (const std::vector<Window>& unasked : {dense, rest}) {
    for (const Window& window : unasked)
      training.push_back(moment_of(window, drops.number(window), known_of(window)));
  }
  for (AskedMoment& moment : other_bodies(shapes, shape, drops)) training.push_back(std::move(moment));
  return score_split(fmt::format("{} split {}", test_case, seed), training,
                     asked(windows.fitted, split(kAsked).unseen, drops));
}

constexpr const char* kBound = "paper_bound";

/// Bodies are the discs that stand for the sheets of a shape, fitted to the windows of the first split. The source has
/// means over five frames.
void bound_of(const std::string& shape, const std::string& plural, const std::filesystem::path& folder) {
  constexpr int kTaught = 10, kMade = 8;  // frames from window to window
  const std::vector<Capture> all = identification::paper_drops(folder, shape);
  const auto split = [&](int stride) { return identification::split(all, kDrops, kFrames, 1, stride); };
  const auto family = identification::paper_family();
  const FitOptions options = options_of_fit();
  Drops drops;
  Bound bound{.family = family.get(), .options = options};
  bound.coefficients = coefficients_of(*family, options, split(0).fitted, 2);
  bound.averaged = options.compared.averaged_frames;
  bound.noise = noise_of(all, bound.averaged);
  bound.moment_of = [&](const Window& window, const Eigen::RowVectorXd& model) {
    return moment_of(window, drops.number(window), known_of(window), model);
  };
  report_bound(kBound, "_" + plural, bound, split(kTaught).fitted, split(kMade).unseen);
}

struct Shape {
  std::string name, plural;
};
const std::vector<Shape> kShapes = {
    {"circle", "discs"}, {"square", "squares"}, {"hexagon", "hexagons"}, {"cross", "crosses"}};

}  // namespace

void paper_cases(const Options& options) {
  std::vector<std::vector<Capture>> drops;
  for (std::size_t shape = 0; shape < kShapes.size(); ++shape) {
    const std::string test_case = "paper_" + kShapes[shape].plural;
    const auto folder = identification::measured_set(options, test_case, "falling-paper-cambridge");
    if (!folder) continue;
    for (std::size_t k = drops.size(); k < kShapes.size(); ++k)
      drops.push_back(identification::paper_drops(*folder, kShapes[k].name));
    std::vector<SplitScores> splits;
    for (int seed = 1; seed <= (options.quick ? 1 : kSplits); ++seed)
      splits.push_back(one_split(test_case, drops, shape, seed));
    report(test_case, splits);
  }
  const auto folder = identification::measured_set(options, kBound, "falling-paper-cambridge");
  for (const auto& [shape, plural] : kShapes) {
    if (folder) bound_of(shape, plural, *folder);
  }
}

}  // namespace samara::benchmarks::prediction

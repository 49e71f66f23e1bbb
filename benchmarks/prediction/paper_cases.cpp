/// Sheets of paper in air, from positions alone: 0.1 s beyond a window of 0.2 s, on 20 drops that had no part in
/// the fit of 20 others, in five splits drawn with the seeds 1 to 5.
///
/// Every number that a forecast needs comes from the drops of the fit: the body's coefficients; its errors, by
/// halves of them that predict each other; weights of the autoregression; shares of the mixture.
#include <array>

#include <fmt/format.h>

#include "cases.h"
#include "identification/falling_paper.h"
#include "samara/base/streams.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"
#include "scored_split.h"

namespace samara::benchmarks::prediction {

namespace {

using identification::Window;
using samara::identification::Capture;
using samara::identification::FitOptions;
using samara::identification::FitResult;

constexpr std::size_t kDrops = 20;
constexpr int kSplits = 5;
constexpr int kFrames = 20;  ///< of a window
constexpr int kDense = 3;    ///< frames between moments of which the body is not asked

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

/// Windows predicted by a fit of every second one of others: more of them move the coefficients less than other
/// drops do.
std::vector<AskedMoment> asked(const std::vector<Window>& others, const std::vector<Window>& left_out,
                               Drops& drops) {
  const auto family = identification::paper_family();
  const FitOptions options = options_of_fit();
  std::vector<Capture> fitted;
  for (std::size_t k = 0; k < others.size(); k += 2) fitted.push_back(others[k].capture);
  const FitResult result = samara::identification::fit(*family, fitted, options);
  const auto predicted =
      identification::predict_unseen(*family, options, identification::values_of(result), left_out);
  fmt::print(stderr, "  {} windows fitted in {:.1f} s, {} predicted in {:.1f} s\n", fitted.size(),
             result.seconds, left_out.size(), predicted.fit.seconds);
  std::vector<AskedMoment> moments;
  for (std::size_t k = 0; k < left_out.size(); ++k) {
    moments.push_back(moment_of(left_out[k], drops.number(left_out[k]), known_of(left_out[k]),
                                predicted.next.row(static_cast<Eigen::Index>(k))));
  }
  return moments;
}

SplitScores one_split(const std::string& test_case, const std::vector<Capture>& all, int seed) {
  const auto number = static_cast<std::uint64_t>(seed);
  const identification::PaperSplit windows = identification::split(all, kDrops, kFrames, number);
  const identification::PaperSplit dense = identification::split(all, kDrops, kFrames, number, kDense);
  Drops drops;
  std::array<std::vector<Window>, 2> halves;
  for (const Window& window : windows.fitted)
    halves[static_cast<std::size_t>(drops.number(window) % 2)].push_back(window);
  std::vector<AskedMoment> training = asked(halves[0], halves[1], drops);
  for (AskedMoment& moment : asked(halves[1], halves[0], drops)) training.push_back(std::move(moment));
  for (const Window& window : dense.fitted)
    training.push_back(moment_of(window, drops.number(window), known_of(window)));
  return score_split(fmt::format("{} split {}", test_case, seed), training,
                     asked(windows.fitted, windows.unseen, drops));
}

constexpr const char* kBound = "paper_bound";

/// What a perfect model could reach: windows of motions that the body made itself, with the source's noise and its
/// mean over five frames, predicted by the same body with the same coefficients. What is left is the start, which
/// positions alone must show. Bodies are the discs that stand for the sheets of a shape, and fall as these began to.
void bound_of(const std::string& shape, const std::string& plural, const std::filesystem::path& folder) {
  constexpr double kJitter = 0.2e-3;  // m, of the source's smoothed frames
  const identification::Coefficients coefficients = {
      {"C_D0", 0.06}, {"C_D90", 5.1}, {"C_R", 0.95}, {"C_T", 0.6}, {"C_w", 1.5}};  // about those of the discs
  const auto family = identification::paper_family();
  const FitOptions body = options_of_fit();
  std::vector<Window> windows =
      identification::split(identification::paper_drops(folder, shape), kDrops, kFrames, 1).unseen;
  const auto states = identification::predict_unseen(*family, body, coefficients, windows);
  const FitOptions held = identification::with_coefficients(body, coefficients);
  std::vector<Window> made;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    Window window = windows[k];
    const Eigen::VectorXd& times = window.capture.times;
    const auto motion = samara::identification::fitted_motion(*family, held, states.fit, k,
                                                              {times.begin(), times.end()}, {"x", "y", "z"});
    window.next = states.next.row(static_cast<Eigen::Index>(k));
    if (!motion || !window.next.allFinite()) continue;
    Stream stream(28, k);
    for (samara::identification::Channel& channel : window.capture.channels) {
      if (channel.unit != "m") continue;
      channel.values = motion->col(channel.quantity[0] - 'x');
      for (double& value : channel.values) value += kJitter * stream.normal();
    }
    made.push_back(std::move(window));
  }
  const std::vector<double> errors = identification::predict_unseen(*family, body, coefficients, made).errors;
  print({kBench, kBound, "median_" + plural, identification::median_of(errors), "m"});
  print({kBench, kBound, "rms_" + plural, identification::rms_of(errors), "m"});
}

struct Shape {
  std::string name, plural;
};
const std::vector<Shape> kShapes = {
    {"circle", "discs"}, {"square", "squares"}, {"hexagon", "hexagons"}, {"cross", "crosses"}};

}  // namespace

void paper_cases(const Options& options) {
  for (const auto& [shape, plural] : kShapes) {
    const std::string test_case = "paper_" + plural;
    const auto folder = identification::measured_set(options, test_case, "falling-paper-cambridge");
    if (!folder) continue;
    const std::vector<Capture> drops = identification::paper_drops(*folder, shape);
    std::vector<SplitScores> splits;
    for (int seed = 1; seed <= (options.quick ? 1 : kSplits); ++seed)
      splits.push_back(one_split(test_case, drops, seed));
    report(test_case, splits);
  }
  const auto folder = identification::measured_set(options, kBound, "falling-paper-cambridge");
  for (const auto& [shape, plural] : kShapes) {
    if (folder) bound_of(shape, plural, *folder);
  }
}

}  // namespace samara::benchmarks::prediction

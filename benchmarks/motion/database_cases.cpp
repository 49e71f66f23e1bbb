// Motions as segments: the graph of planar motions, chains, and a thousand bodies a frame.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iostream>

#include <fmt/format.h>

#include "motion/cases.h"
#include "motion/motion_databases.h"
#include "samara/base/streams.h"
#include "samara/models/integrators/step_kernel.h"
#include "samara/motion/bodies/bodies.h"

namespace samara::benchmarks::motion_cases {

namespace {

void run_graph(const Options& options) {
  constexpr const char* kName = "graph_planar";
  if (!options.wants(kName)) return;
  const motion::MotionDatabase database = planar_motions(600);
  const motion::MotionGraph graph = motion::motion_graph(database);
  for (const motion::ThresholdPoint& point : graph.curve)
    std::cerr << fmt::format("{}: threshold {:.4g}, share {:.3f}, {} edges\n", kName, point.threshold,
                             point.share, point.edges);
  std::cerr << fmt::format("{}: {} segments, threshold {:.3g}\n", kName, database.segment_count(),
                           graph.threshold);
  print({kMotion, kName, "share",
         static_cast<double>(graph.kept) / static_cast<double>(database.segment_count()), "1"});
}

/// p(next | before, last) of four symbols, evenly drawn among all such.
using Tensor = std::array<std::array<std::array<double, 4>, 4>, 4>;

Tensor planted_chain(Stream& stream) {
  Tensor p;
  for (auto& before : p) {
    for (auto& last : before) {
      double sum = 0.0;
      for (double& next : last) sum += next = -std::log(1.0 - stream.uniform());
      for (double& next : last) next /= sum;
    }
  }
  return p;
}

std::vector<std::vector<int>> planted_runs(const Tensor& p, int runs, int length, Stream& stream) {
  std::vector<std::vector<int>> all;
  for (int n = 0; n < runs; ++n) {
    std::vector<int> run = {0, 1};
    while (static_cast<int>(run.size()) < length) {
      const auto& next =
          p[static_cast<std::size_t>(run[run.size() - 2])][static_cast<std::size_t>(run.back())];
      double left = stream.uniform();
      int symbol = 0;
      while (symbol < 3 && (left -= next[static_cast<std::size_t>(symbol)]) >= 0.0) ++symbol;
      run.push_back(symbol);
    }
    all.push_back(std::move(run));
  }
  return all;
}

double likelihood_of(const Tensor& p, const std::vector<std::vector<int>>& runs) {
  double sum = 0.0, count = 0.0;
  for (const auto& run : runs) {
    for (std::size_t k = 2; k < run.size(); ++k) {
      sum += std::log(p[static_cast<std::size_t>(run[k - 2])][static_cast<std::size_t>(run[k - 1])]
                       [static_cast<std::size_t>(run[k])]);
      count += 1.0;
    }
  }
  return sum / count;
}

/// Planted chains of second order: 20,000 events to fit, as many to test.
void run_chains(const Options& options) {
  constexpr const char* kName = "chain";
  if (!options.wants(kName)) return;
  int worst_order = 2;
  double worst_loss = 0.0, first_order = 0.0;
  for (std::uint64_t seed = 101; seed <= 110; ++seed) {
    Stream stream(seed, 0);
    const Tensor p = planted_chain(stream);
    const auto runs = planted_runs(p, 200, 100, stream), fresh = planted_runs(p, 200, 100, stream);
    const motion::OrderChoice choice = motion::select_order(runs, 4);
    if (std::abs(choice.order - 2) > std::abs(worst_order - 2)) worst_order = choice.order;
    const double truth = likelihood_of(p, fresh);
    worst_loss = std::max(
        worst_loss, truth - motion::MarkovChain::fitted(runs, 4, choice.order).log_likelihood(fresh, 2));
    first_order =
        std::max(first_order, truth - motion::MarkovChain::fitted(runs, 4, 1).log_likelihood(fresh, 2));
  }
  std::cerr << fmt::format("{}: a chain of first order loses up to {:.3f} nats an event\n", kName,
                           first_order);
  print({kMotion, kName, "order", static_cast<double>(worst_order), "1"});
  print({kMotion, kName, "loss", worst_loss, "nat"});
}

/// What a plain loop over bodies takes for the same steps, with coefficients that rest and no look at events.
double scalar_frame(const motion::NextPieces& pieces, Eigen::Index count, int steps, double h) {
  const models::ParametricModel model = pieces.database().parametric_model();
  const Eigen::VectorXd q = pieces.database().runs.front().coefficients;
  const std::vector<double> p = model.parameters({q.data(), static_cast<std::size_t>(q.size())});
  const std::size_t states = pieces.database().state_names.size();
  std::vector<double> all;
  for (Eigen::Index n = 0; n < count; ++n) {
    for (const double number : pieces.database().starts.row(n % pieces.database().segment_count()))
      all.push_back(number);
  }
  const models::StepKernel& kernel = *model.model().step_kernels()->scalar;
  return time_of([&] {
    for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
      const double t = 0.0;
      kernel.advance(&t, h, steps, all.data() + n * states, p.data());
    }
  });
}

/// Median time of a frame, with what else there is to say on stderr.
double frame_time(const motion::NextPieces& pieces, Eigen::Index count, int frames,
                  const motion::BodiesOptions& options, double frame) {
  motion::Bodies bodies(pieces, count, options);
  for (Eigen::Index n = 0; n < count; ++n) bodies.release(n, {0.0, 0.0, 0.0}, 0.1 * static_cast<double>(n));
  std::vector<double> positions(static_cast<std::size_t>(3 * count)),
      rotations(static_cast<std::size_t>(4 * count)), times;
  for (int k = 0; k < frames; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    bodies.advance(frame);
    bodies.read_poses(positions, rotations);
    times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  std::ranges::sort(times);
  const motion::BodyCounts& counts = bodies.counts();
  std::cerr << fmt::format(
      "many_1000: {} tries, {} segments, {:.0f} events a frame, 99 % of frames within {:.3g} ms; {:.1f} % of "
      "kinds kept, "
      "{:.1f} % of drawn ones taken; {} bodies not finite\n",
      options.tries, pieces.database().segment_count(), static_cast<double>(counts.events) / frames,
      1e3 * times[times.size() * 99 / 100],
      100.0 * static_cast<double>(counts.kept) / static_cast<double>(std::max(1L, counts.planned)),
      100.0 * static_cast<double>(counts.taken) / static_cast<double>(std::max(1L, counts.drawn)),
      count - bodies.falling());
  return times[times.size() / 2];
}

/// With a database of 5^3 points, and of as many as the source's sweep has, 9^3, from two releases each.
void run_many(const Options& options) {
  constexpr const char* kName = "many_1000";
  if (!options.wants(kName)) return;
  constexpr Eigen::Index kCount = 1000;
  constexpr double kFrame = 1.0 / 60.0;
  constexpr int kSteps = 4;
  const int frames = options.quick ? 60 : 600;
  motion::BodiesOptions chosen = {.step = kFrame / kSteps, .seed = 101};
  const motion::NextPieces pieces(card_motions(options.quick ? 4 : 5, 2.0));
  const double time = frame_time(pieces, kCount, frames, chosen, kFrame);
  print({kMotion, kName, "time", time, "s", "scalar_loop",
         scalar_frame(pieces, kCount, kSteps, kFrame / kSteps) / time});
  print({kMotion, kName, "segments", static_cast<double>(pieces.database().segment_count()), "1"});
  if (options.quick) return;
  const motion::NextPieces more(card_motions(9, 2.0));
  print({kMotion, kName, "time_source", frame_time(more, kCount, frames, chosen, kFrame), "s"});
  print({kMotion, kName, "segments_source", static_cast<double>(more.database().segment_count()), "1"});
  chosen.tries = 4;
  print({kMotion, kName, "time_tried", frame_time(pieces, kCount, frames, chosen, kFrame), "s"});
}

}  // namespace

void run_databases(const Options& options) {
  run_graph(options);
  run_chains(options);
  run_many(options);
}

}  // namespace samara::benchmarks::motion_cases

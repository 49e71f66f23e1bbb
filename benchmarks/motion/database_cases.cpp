// Motions as segments: the graph of planar motions, walks in a closed loop, chains, and a thousand bodies a frame.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <iostream>

#include <fmt/format.h>

#include "motion/cases.h"
#include "samara/base/streams.h"
#include "samara/models/integrators/step_kernel.h"
#include "samara/motion/bodies/bodies.h"

namespace samara::benchmarks::motion_cases {

namespace {

/// The plate at I* 1.3 over three coefficients, from 0.6 rad.
motion::MotionDatabase planar_motions(int runs) {
  const motion::SweepPlan plan = motion::parse_sweep_plan(
      fmt::format(
          "model = \"falling_plate_nd\"\n[fixed]\nbeta = 0\ninertia_ratio = 1.3\n[axes]\n"
          "C_T = {{ from = 0.8, to = 1.4 }}\nC_R = {{ from = 2, to = 4 }}\nA = {{ from = 1, to = 1.8 }}\n"
          "[sample]\ncount = {}\n[releases]\ntilt = [0.6]\n[run]\nuntil = 60\nstep = 0.05\nsettle = 10\n",
          runs),
      "benchmark");
  return motion::build_database(motion::run_sweep(plan).sweep);
}

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

/// Walks of 40 segments: the kind of each is planned at the event before it, from where the walk really is.
void run_walks(const Options& options) {
  constexpr const char* kName = "walk_planar";
  if (!options.wants(kName)) return;
  constexpr int kSegments = 40;
  const motion::NextPieces pieces(planar_motions(600));
  double worst = 1.0;
  // Drawn when all else was frozen: choices were made on seeds 5, 6 and 9.
  for (const std::uint64_t seed : {2201u, 2202u, 2203u, 2204u}) {
    motion::Bodies body(pieces, 1,
                        {.choice = motion::BodiesOptions::Choice::graph, .ramp = 1.0, .seed = seed});
    body.release(0, {0.0, 0.0, 0.0}, 0.0);
    int planned = 0, kept = 0;
    while (planned < kSegments) {
      body.advance(0.05);
      for (const motion::BodyEvent& event : body.events()) {
        if (!event.planned) continue;
        ++planned;
        kept += event.kind == *event.planned;
      }
    }
    std::cerr << fmt::format("{}: seed {}, {} of {} kinds kept\n", kName, seed, kept, planned);
    worst = std::min(worst, static_cast<double>(kept) / planned);
  }
  print({kMotion, kName, "kinds_kept", worst, "1"});
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

void run_many(const Options& options) {
  constexpr const char* kName = "many_1000";
  if (!options.wants(kName)) return;
  constexpr Eigen::Index kCount = 1000;
  constexpr double kFrame = 1.0 / 60.0;
  constexpr int kSteps = 4;
  std::string axes;
  for (const char* name : {"C_D90", "C_T", "C_R"})
    axes += fmt::format("{} = {{ from = 0.31, to = 2.71, count = {} }}\n", name, options.quick ? 4 : 5);
  const motion::SweepPlan plan = motion::parse_sweep_plan(
      "model = \"immersed_body\"\n[fixed]\na = \"3.5 cm\"\nb = \"2 cm\"\nc = \"0.01 cm\"\ndensity = 1200\n"
      "C_D0 = 0.05\nC_w = 2\n[axes]\n" +
          axes +
          "[releases]\ntilt = [\"10 deg\"]\naxis = [\"0 deg\", \"35 deg\"]\n[run]\nuntil = \"2 s\"\nstep = "
          "\"1 ms\"\n"
          "settle = \"0.5 s\"\n",
      "benchmark");
  const motion::NextPieces pieces(motion::build_database(motion::run_sweep(plan).sweep));
  motion::Bodies bodies(pieces, kCount, {.step = kFrame / kSteps, .seed = 101});
  for (Eigen::Index n = 0; n < kCount; ++n) bodies.release(n, {0.0, 0.0, 0.0}, 0.1 * static_cast<double>(n));
  std::vector<double> positions(3 * kCount), rotations(4 * kCount), times;
  std::size_t events = 0;
  for (int frame = 0; frame < (options.quick ? 60 : 600); ++frame) {
    const auto begin = std::chrono::steady_clock::now();
    bodies.advance(kFrame);
    bodies.read_poses(positions, rotations);
    times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    events += bodies.events().size();
  }
  std::ranges::sort(times);
  const double median = times[times.size() / 2];
  std::cerr << fmt::format(
      "{}: {} segments, {:.0f} events a frame, 99 % of frames within {:.3g} ms; {} bodies not finite\n",
      kName, pieces.database().segment_count(),
      static_cast<double>(events) / static_cast<double>(times.size()), 1e3 * times[times.size() * 99 / 100],
      kCount - bodies.falling());
  print({kMotion, kName, "time", median, "s", "scalar_loop",
         scalar_frame(pieces, kCount, kSteps, kFrame / kSteps) / median});
}

}  // namespace

void run_databases(const Options& options) {
  run_graph(options);
  run_walks(options);
  run_chains(options);
  run_many(options);
}

}  // namespace samara::benchmarks::motion_cases

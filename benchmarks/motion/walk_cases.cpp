// Walks in a closed loop: how many planned kinds come about, and what hand would have to push, beside blends.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "motion/cases.h"
#include "motion/joins.h"
#include "motion/motion_databases.h"
#include "samara/base/streams.h"
#include "samara/models/batch/stepper.h"
#include "samara/motion/chains/chain_check.h"

namespace samara::benchmarks::motion_cases {

namespace {

/// One body, step by step.
struct Walk {
  Eigen::VectorXd times;
  Eigen::MatrixXd states;               ///< frames in rows
  std::vector<Eigen::Index> segments;   ///< that were chosen, one after another
  std::vector<Eigen::Index> at_frames;  ///< when
  Eigen::VectorXd first_coefficients;
  motion::BodyCounts counts;
};

/// @param planned segments after which it ends
Walk walk(const motion::NextPieces& pieces, const motion::BodiesOptions& options, int planned) {
  motion::Bodies body(pieces, 1, options);
  body.release(0, {0.0, 0.0, 0.0}, 0.0);
  Walk walk;
  walk.first_coefficients.resize(std::ssize(pieces.database().coefficient_names));
  body.read_coefficients(
      0, {walk.first_coefficients.data(), static_cast<std::size_t>(walk.first_coefficients.size())});
  std::vector<double> state(pieces.database().state_names.size()), states, times;
  const auto record = [&] {
    body.read_state(0, state);
    states.insert(states.end(), state.begin(), state.end());
    times.push_back(body.time(0));
  };
  record();
  while (body.counts().planned < planned) {
    body.advance(options.step);
    if (body.falling() == 0) throw std::runtime_error("a walk is not finite");
    record();
    for (const motion::BodyEvent& event : body.events()) {
      walk.segments.push_back(event.next.segment);
      walk.at_frames.push_back(std::ssize(times) - 1);
    }
  }
  walk.counts = body.counts();
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  walk.times = Eigen::Map<const Eigen::VectorXd>(times.data(), std::ssize(times));
  walk.states = Eigen::Map<const Rows>(states.data(), std::ssize(times), std::ssize(state));
  return walk;
}

void run_planar_walks(const Options& options) {
  constexpr const char* kName = "walk_planar";
  if (!options.wants(kName)) return;
  constexpr int kSegments = 40;
  constexpr double kRamp = 1.0, kStep = 0.02;
  const motion::NextPieces pieces(planar_motions(600), {.ramp = kRamp});
  const Recordings recordings(pieces.database());
  double kept = 1.0, untried = 1.0, box = 0.0, largest = 0.0, ratio = std::numeric_limits<double>::infinity(),
         blend = ratio;
  // Drawn when all else was frozen, once: choices were made on seeds 5, 6, 9 and 2201 to 2204.
  for (const std::uint64_t seed : {2301u, 2302u, 2303u, 2304u}) {
    motion::BodiesOptions chosen = {
        .choice = motion::BodiesOptions::Choice::graph, .step = kStep, .ramp = kRamp, .seed = seed};
    const auto share = [](const Walk& one) {
      return static_cast<double>(one.counts.kept) / static_cast<double>(one.counts.planned);
    };
    untried = std::min(untried, share(walk(pieces, chosen, kSegments)));
    chosen.tries = 8;
    const Walk real = walk(pieces, chosen, kSegments);
    const auto own =
        recordings.ghost(real.times, motion::path_of(recordings.info(), real.times, real.states).poses)
            .force_sizes;
    const PlanarBlend joined = blended_walk(pieces.database(), recordings, real.segments, kRamp, kStep);
    const auto other = recordings.ghost(joined.times, joined.poses).force_sizes;
    std::cerr << fmt::format(
        "{}: seed {}, {} of {} kinds kept, {} without tries; ghost in the box {:.2e} rms, {:.2e} at most; "
        "blended {:.2e}, {:.2e}\n",
        kName, seed, real.counts.kept, real.counts.planned, untried, own.rms, own.max, other.rms, other.max);
    kept = std::min(kept, share(real));
    box = std::max(box, own.rms);
    largest = std::max(largest, own.max);
    blend = std::min(blend, other.rms);
    ratio = std::min(ratio, other.rms / own.rms);
  }
  print({kMotion, kName, "ghost_box", box, "net weight", "blend", ratio});
  print({kMotion, kName, "ghost_max", largest, "net weight"});
  print({kMotion, kName, "ghost_blend", blend, "net weight"});
  print({kMotion, kName, "kinds_kept", kept, "1"});
  print({kMotion, kName, "kinds_kept_untried", untried, "1"});
}

/// Of two hundred bodies at once: planned kinds that come about, drawn ones that are had, and how the kinds are those
/// of the chain: what an event's logarithm of probability falls short of that of its own draws.
void run_crowd(const char* name, const motion::NextPieces& pieces, double time) {
  using Choice = motion::BodiesOptions::Choice;
  const auto share = [](long some, long all) { return static_cast<double>(some) / static_cast<double>(all); };
  const motion::MarkovChain& chain = pieces.chain();
  const auto order = static_cast<std::size_t>(chain.order());
  std::vector<std::vector<int>> own;
  for (std::uint64_t n = 0; n < 200; ++n) {
    Stream stream(2302, n);
    own.push_back(chain.draw_sequence(1000, stream));
  }
  const double entropy = chain.log_likelihood(own, order);
  for (const auto& [choice, tries] :
       {std::pair(Choice::chain, 0), std::pair(Choice::chain, 8), std::pair(Choice::graph, 0)}) {
    motion::Bodies bodies(pieces, 200,
                          {.choice = choice, .ramp = pieces.ramp(), .tries = tries, .seed = 2301});
    for (Eigen::Index n = 0; n < 200; ++n) bodies.release(n, {0.0, 0.0, 0.0}, 0.0);
    std::vector<std::vector<int>> kinds(200);
    for (int k = 0; k < 1000; ++k) {
      bodies.advance(0.001 * time);
      for (const motion::BodyEvent& event : bodies.events())
        kinds[static_cast<std::size_t>(event.body)].push_back(static_cast<int>(event.kind));
    }
    const motion::BodyCounts& counts = bodies.counts();
    const motion::ChainCheck worth = motion::check(chain, kinds);
    const double loss = entropy - worth.log_likelihood;
    std::cerr << fmt::format(
        "{}: by the {}, {} tries: {} events, {} not finite, {:.4f} of kinds kept; {:.3f} of draws had, "
        "{:.3f} "
        "drawn again; {:.3f} nats an event short of the chain's {:.3f}; lengths of runs off by {:.3g}, two "
        "events on by {:.3g} errors\n",
        name, choice == Choice::chain ? "chain" : "graph", tries, counts.events, 200 - bodies.falling(),
        share(counts.kept, counts.planned), share(counts.taken, std::max(1L, counts.drawn)),
        share(counts.redrawn, std::max(1L, counts.drawn)), loss, entropy, worth.chi_square.maxCoeff(),
        worth.two_steps);
    if (choice == Choice::graph) continue;
    print({kMotion, name, tries == 0 ? "kinds_kept_untried" : "kinds_kept",
           share(counts.kept, counts.planned)});
    if (tries > 0) continue;
    print({kMotion, name, "drawn_taken", share(counts.taken, counts.drawn)});
    print({kMotion, name, "drawn_again", share(counts.redrawn, counts.drawn)});
    print({kMotion, name, "chain_loss", loss, "nat"});
  }
}

void run_crowds(const Options& options) {
  if (options.wants("crowd_planar"))
    run_crowd("crowd_planar", motion::NextPieces(planar_motions(600)), 300.0);
  if (!options.wants("crowd_leaf")) return;
  const auto plan =
      motion::read_sweep_plan(std::filesystem::path(SAMARA_EXAMPLES_DIR) / "leaves" / "leaf.toml");
  run_crowd("crowd_leaf", motion::NextPieces(motion::build_database(motion::run_sweep(plan).sweep)), 3.0);
}

/// Whether a walk is what one run of the stepper makes of its ramps: that nothing else ever moved the state.
void run_continuity(const Options& options) {
  constexpr const char* kName = "continuity";
  if (!options.wants(kName)) return;
  double jump = 0.0;
  for (const bool in_space : {false, true}) {
    const double step = in_space ? 1e-3 : 0.02;
    const motion::NextPieces pieces(in_space ? card_motions(4, 1.0) : planar_motions(200));
    const Walk real = walk(pieces, {.step = step, .seed = 2301}, 30);
    const motion::MotionDatabase& database = pieces.database();
    models::Stepper stepper(database.parametric_model(), database.coefficient_names, 1);
    const auto numbers = [](const Eigen::VectorXd& v) {
      return std::span<const double>(v.data(), static_cast<std::size_t>(v.size()));
    };
    stepper.load(0, numbers(real.first_coefficients));
    Eigen::VectorXd state = real.states.row(0);
    stepper.set_state(0, 0.0, numbers(state));
    const Eigen::VectorXd largest = real.states.cwiseAbs().colwise().maxCoeff().transpose();
    std::size_t next = 0;
    for (Eigen::Index k = 1; k < real.times.size(); ++k) {
      stepper.step(step);
      stepper.read(0, {state.data(), static_cast<std::size_t>(state.size())});
      jump = std::max(
          jump, ((state - real.states.row(k).transpose()).cwiseAbs().cwiseQuotient(largest)).maxCoeff());
      if (next == real.at_frames.size() || real.at_frames[next] != k) continue;
      stepper.ramp(0, numbers(pieces.coefficients({.segment = real.segments[next++]})), pieces.ramp());
    }
  }
  print({kMotion, kName, "jump", jump});
}

/// A join of a body in space: what it did, and what a blend would have done.
struct Join {
  double distance = 0.0;  ///< of the state to the beginning of the piece
  Eigen::MatrixXd real, blended;
};

void run_spatial_walks(const Options& options) {
  constexpr const char* kName = "walk_3d";
  if (!options.wants(kName)) return;
  constexpr double kFrame = 1e-3;
  // Ramps of 30 ms bend within windows of eight frames.
  constexpr int kWindow = 4;
  constexpr Eigen::Index kBlend = 60, kBeside = 10, kBodies = 100;
  const motion::NextPieces pieces(card_motions(options.quick ? 4 : 9, 2.0, true));
  const Recordings recordings(pieces.database(), kWindow);
  motion::Bodies bodies(pieces, kBodies, {.step = kFrame / 4.0, .tries = 8, .seed = 2301});
  for (Eigen::Index n = 0; n < kBodies; ++n) bodies.release(n, {0.0, 0.0, 0.0}, 0.1 * static_cast<double>(n));
  const Eigen::Index frames = options.quick ? 500 : 1200, count = std::ssize(pieces.database().state_names);
  struct Found {
    motion::BodyEvent event;
    Eigen::Index frame = 0;
    Eigen::VectorXd coefficients;  ///< until then
  };
  std::vector<Eigen::MatrixXd> states(kBodies, Eigen::MatrixXd(frames, count));
  std::vector<Found> found;
  Eigen::VectorXd state(count);
  for (Eigen::Index k = 0; k < frames; ++k) {
    bodies.advance(kFrame);
    for (Eigen::Index n = 0; n < kBodies; ++n) {
      bodies.read_state(n, {state.data(), static_cast<std::size_t>(count)});
      states[static_cast<std::size_t>(n)].row(k) = state;
    }
    for (const motion::BodyEvent& event : bodies.events()) {
      Found one{.event = event, .frame = k, .coefficients = Eigen::VectorXd(3)};
      bodies.read_coefficients(event.body, {one.coefficients.data(), 3});  // the ramp has just begun
      // What goes on with the same coefficients is no join.
      const bool joins = (pieces.coefficients(event.next) - one.coefficients).norm() > 1e-9;
      if (joins && k >= kBeside && k + kBlend + kBeside < frames) found.push_back(std::move(one));
    }
  }
  // The blends may choose: the nearest third.
  std::ranges::stable_sort(found, {}, [](const Found& one) { return one.event.next.distance; });
  found.resize(std::min<std::size_t>(200, found.size() * 3 / 10));
  std::vector<double> real, blended;
  const auto poses_of = [&](const Eigen::MatrixXd& all) {
    return motion::path_of(recordings.info(), Eigen::VectorXd::Zero(all.rows()), all).poses;
  };
  for (const Found& one : found) {
    const Eigen::MatrixXd& own = states[static_cast<std::size_t>(one.event.body)];
    const Eigen::Index first = one.frame - kBeside, window = kBeside + kBlend + 1 + kBeside;
    const Eigen::VectorXd times =
        kFrame * Eigen::VectorXd::LinSpaced(window, 0.0, static_cast<double>(window - 1));
    real.push_back(recordings.ghost(times, poses_of(own.middleRows(first, window))).force_sizes.max);
    const Eigen::VectorXd after =
        kFrame * Eigen::VectorXd::LinSpaced(kBlend + 1, 0.0, static_cast<double>(kBlend));
    const Eigen::MatrixXd as_before =
        poses_of(recordings.from_state(own.row(one.frame), one.coefficients, after));
    const double late = kFrame * static_cast<double>(one.frame + 1) - one.event.t;
    const Eigen::MatrixXd piece =
        poses_of(recordings.from_start(one.event.next.segment, after.array() + late));
    const Eigen::MatrixXd joined = blended_in_space(as_before, piece, pieces.database().symmetry);
    blended.push_back(recordings.ghost(after, joined).force_sizes.max);
  }
  std::ranges::sort(real);
  std::ranges::sort(blended);
  std::cerr << fmt::format("{}: {} joins; {} of {} kinds kept; blends {:.3g} to {:.3g}\n", kName,
                           found.size(), bodies.counts().kept, bodies.counts().planned, blended.front(),
                           blended.back());
  const double median = real[real.size() / 2];
  print(
      {kMotion, kName, "ghost_median", median, "net weight", "blend", blended[blended.size() / 2] / median});
  print({kMotion, kName, "ghost_90", real[real.size() * 9 / 10], "net weight"});
  print({kMotion, kName, "ghost_blend", blended[blended.size() / 2], "net weight"});
  print({kMotion, kName, "kinds_kept",
         static_cast<double>(bodies.counts().kept) / static_cast<double>(bodies.counts().planned)});
}

}  // namespace

void run_walks(const Options& options) {
  run_planar_walks(options);
  run_continuity(options);
  run_spatial_walks(options);
  run_crowds(options);
}

}  // namespace samara::benchmarks::motion_cases

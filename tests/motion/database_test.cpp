// Databases of motions: segments that are those of their runs, searches, files, the graph and the chain.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/batch/batch.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/chains/chain_check.h"
#include "samara/motion/database/database_file.h"
#include "samara/motion/database/database_report.h"
#include "samara/motion/database/motion_database.h"
#include "samara/motion/database/segment_tree.h"
#include "tests/error_text.h"
#include "tests/io/temporary_directory.h"

using namespace samara::motion;

namespace {

/// Thin plates at I* 1.3 over three coefficients.
std::string plate_plan(int count, const std::string& more = "") {
  return "model = \"falling_plate_nd\"\n[fixed]\nbeta = 0\ninertia_ratio = 1.3\n[axes]\n"
         "C_T = { from = 0.8, to = 1.4 }\nC_R = { from = 2, to = 4 }\nA = { from = 1, to = 1.8 "
         "}\n[sample]\ncount = " +
         std::to_string(count) + "\n[releases]\ntilt = [0.6]\n[run]\nuntil = 60\nstep = 0.05\nsettle = 10\n" +
         more;
}

Sweep plates(int count, const std::string& more = "") {
  return run_sweep(parse_sweep_plan(plate_plan(count, more), "plates.toml")).sweep;
}

std::span<const double> row_span(const Eigen::VectorXd& row) {
  return {row.data(), static_cast<std::size_t>(row.size())};
}

}  // namespace

TEST_CASE("segments of a database are solutions of the model with the coefficients of their runs") {
  const MotionDatabase database = build_database(plates(40, "keep = \"trajectories\"\n"));
  REQUIRE(database.segment_count() > 100);
  REQUIRE(database.coefficient_names == std::vector<std::string>{"C_T", "C_R", "A"});
  CHECK(database.symmetry == BodySymmetry::half_turn);
  const auto& info = samara::models::find_model("falling_plate_nd")->info();
  auto fixed = database.fixed;
  std::vector<std::string> free = database.coefficient_names;
  for (const auto& state : info.states) free.push_back(state.name + "(0)");
  const samara::models::ParametricModel plate(samara::models::find_model("falling_plate_nd"), fixed, free);
  for (Eigen::Index n = 0; n < database.segment_count(); n += 37) {
    const MotionSegment& segment = database.segments[static_cast<std::size_t>(n)];
    Eigen::MatrixXd point(1, 9);
    point << database.runs[static_cast<std::size_t>(segment.run)].coefficients.transpose(),
        database.starts.row(n);
    const std::array times = {0.0, segment.duration};
    const auto run = integrate_batch(plate, point, times, {.step = 0.01});
    const Eigen::VectorXd end = run.states.col(1);
    // Events are found on steps of 0.05, to third order.
    CHECK((end - database.ends.row(n).transpose()).norm() < 5e-3);
    CHECK((end.tail(2) - point.row(0).tail(2).transpose() -
           Eigen::Vector2d(segment.displacement.x(), segment.displacement.z()))
              .norm() < 5e-3);
    if (database.next_of(n) >= 0) CHECK(database.starts.row(n + 1) == database.ends.row(n));
    // The event lies between its frame and the next one.
    const Eigen::Index frame = database.run_first[static_cast<std::size_t>(segment.run)] + segment.first;
    const Eigen::RowVectorXd here = database.frames.row(frame), after = database.frames.row(frame + 1);
    const double share = segment.begin / database.frame_interval - static_cast<double>(segment.first);
    // Between frames a line is off by an eighth of a second difference at most; events are not exact either.
    const double bend = (after - 2.0 * here + database.frames.row(frame - 1)).norm();
    CHECK((here + share * (after - here) - database.starts.row(n)).norm() < 0.2 * bend + 5e-3);
    CHECK(segment.begin - static_cast<double>(segment.first) * database.frame_interval <
          database.frame_interval);
  }
}

TEST_CASE(
    "the segments found nearest are those of all comparisons, symmetric copies included, of any kind or "
    "one") {
  const MotionDatabase database = build_database(plates(40));
  std::vector<Eigen::Index> right_turns;
  for (Eigen::Index n = 0; n < database.segment_count(); ++n) {
    if (database.segments[static_cast<std::size_t>(n)].kind == EventKind::turn_plus) right_turns.push_back(n);
  }
  const SegmentTree tree(database), of_kind(database, right_turns);
  const MovingStates& moving = tree.moving_states();
  const StateMetric metric = database.metric();
  const auto place = [&](const Eigen::VectorXd& state, int copy) {
    Eigen::VectorXd reduced(5);
    moving.reduce(row_span(state), {reduced.data(), 5});
    moving.turn_to_copy(copy, {reduced.data(), 5});
    metric.place({reduced.data(), 5});
    return reduced;
  };
  for (Eigen::Index n = 3; n < database.segment_count(); n += 61) {
    Eigen::VectorXd state = database.ends.row(n);
    state[3] += std::numbers::pi;  // the same plate, turned
    state.head(2) *= -1.0;
    for (const bool any : {true, false}) {
      std::vector<std::pair<double, Eigen::Index>> all;
      for (Eigen::Index other = 0; other < database.segment_count(); ++other) {
        if (!any && database.segments[static_cast<std::size_t>(other)].kind != EventKind::turn_plus) continue;
        const Eigen::VectorXd start = database.starts.row(other);
        all.emplace_back(
            std::min((place(start, 0) - place(state, 0)).norm(), (place(start, 1) - place(state, 0)).norm()),
            other);
      }
      std::ranges::sort(all);
      std::array<NearSegment, 8> found;
      const std::size_t count = (any ? tree : of_kind).nearest(row_span(state), found);
      REQUIRE(count == 8);
      for (std::size_t k = 0; k < count; ++k) CHECK(found[k].distance == Approx(all[k].first).margin(1e-9));
    }
  }
}

TEST_CASE("of an ellipsoid the nearest of four copies count, and none beyond the distance that is given") {
  const MotionDatabase database = build_database(
      run_sweep(parse_sweep_plan("model = \"immersed_body\"\n[fixed]\na = 0.035\nb = 0.02\nc = 1e-4\n"
                                 "density = 1200\nC_D0 = 0.05\nC_w = 2\n[axes]\nC_T = { from = 0.31, to = "
                                 "2.71 }\nC_R = { from = 0.31, to = 2.71 }\n[sample]\ncount = 40\n"
                                 "[releases]\ntilt = [0.17]\naxis = [0.6]\n[run]\nuntil = 2\nstep = 1e-3\n"
                                 "settle = 0.5\n",
                                 "card.toml"))
          .sweep);
  const SegmentTree tree(database);
  const MovingStates& moving = tree.moving_states();
  REQUIRE(moving.copies() == 4);
  const StateMetric metric = database.metric();
  for (Eigen::Index n = 0; n < database.segment_count(); n += 13) {
    const Eigen::VectorXd state = database.ends.row(n);
    std::vector<double> all;
    for (Eigen::Index other = 0; other < database.segment_count(); ++other) {
      const Eigen::VectorXd start = database.starts.row(other);
      double least = std::numeric_limits<double>::infinity();
      for (int copy = 0; copy < 4; ++copy) {
        Eigen::VectorXd here(9), there(9);
        moving.reduce(row_span(state), {here.data(), 9});
        moving.reduce(row_span(start), {there.data(), 9});
        moving.turn_to_copy(copy, {there.data(), 9});
        metric.place({here.data(), 9});
        metric.place({there.data(), 9});
        least = std::min(least, (here - there).norm());
      }
      all.push_back(least);
    }
    std::ranges::sort(all);
    std::array<NearSegment, 6> found;
    REQUIRE(tree.nearest(row_span(state), found) == 6);
    for (std::size_t k = 0; k < found.size(); ++k) CHECK(found[k].distance == Approx(all[k]).margin(1e-9));
    const double within = 0.5 * (all[2] + all[3]);
    CHECK(tree.nearest(tree.places(row_span(state)), found, within) ==
          static_cast<std::size_t>(
              std::ranges::count_if(all, [&](double distance) { return distance < within; })));
  }
}

TEST_CASE(
    "the graph of plates hangs together at the threshold that it chooses, and its components are those of "
    "reachability") {
  const MotionDatabase database = build_database(plates(150));
  const MotionGraph graph = motion_graph(database);
  CHECK(graph.threshold <= 0.4);
  const double share = static_cast<double>(graph.kept) / static_cast<double>(database.segment_count());
  CHECK(share > 0.85);
  CHECK(graph.kept + graph.pruned == database.segment_count());
  // The smallest threshold on the plateau.
  const double most = std::ranges::max(graph.curve, {}, &ThresholdPoint::share).share;
  for (const ThresholdPoint& point : graph.curve)
    CHECK((point.share >= 0.99 * most) == (point.threshold >= graph.threshold));
  const auto nodes = static_cast<std::size_t>(database.segment_count());
  const auto reached_from = [&](std::size_t node) {
    std::vector<char> seen(nodes, 0);
    std::vector<std::size_t> open = {node};
    seen[node] = 1;
    while (!open.empty()) {
      const std::size_t from = open.back();
      open.pop_back();
      for (Eigen::Index k = graph.first_edge[from]; k < graph.first_edge[from + 1]; ++k) {
        const auto to = static_cast<std::size_t>(graph.edges[static_cast<std::size_t>(k)].to);
        if (seen[to] == 0) open.push_back(to);
        seen[to] = 1;
      }
    }
    return seen;
  };
  std::vector<std::vector<char>> reached;
  for (std::size_t n = 0; n < nodes; ++n) reached.push_back(reached_from(n));
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < nodes; ++i) {
    for (std::size_t j = 0; j < nodes; ++j)
      wrong += (graph.component[i] == graph.component[j]) != (reached[i][j] != 0 && reached[j][i] != 0);
  }
  CHECK(wrong == 0);
  for (const GraphEdge& edge : graph.edges) CHECK(edge.distance < graph.threshold);
  // A ring of three, a tail into it, a tail out of it, and a pair: by hand.
  //   0 -> 1 -> 2 -> 0,  3 -> 0,  2 -> 4,  5 <-> 6
  const std::vector<int> components = strong_components({0, 1, 2, 4, 5, 5, 6, 7}, {1, 2, 0, 4, 0, 6, 5});
  CHECK(components[0] == 0);
  CHECK(components[1] == 0);
  CHECK(components[2] == 0);
  CHECK(components[5] == 1);
  CHECK(components[6] == 1);
  CHECK(components[3] != components[4]);
  // A path that is too deep for recursion.
  std::vector<Eigen::Index> first, to;
  for (Eigen::Index n = 0; n < 1000000; ++n) {
    first.push_back(n);
    to.push_back((n + 1) % 1000000);
  }
  first.push_back(1000000);
  CHECK(std::ranges::count(strong_components(first, to), 0) == 1000000);
}

TEST_CASE(
    "the graph of periodic motions does not come apart where runs are longer, and steady falls have no "
    "chain") {
  const auto share = [](const char* until) {
    const std::string plan =
        std::string(
            "model = \"falling_plate_nd\"\n[fixed]\nbeta = 0\ninertia_ratio = 0.8\n[axes]\n"
            "C_R = { from = 2, to = 4 }\nC_T = { from = 0.8, to = 1.4 }\n[sample]\ncount = 36\n"
            "[releases]\ntilt = [0.6]\n[run]\nstep = 0.05\nsettle = 10\nuntil = ") +
        until + "\n";
    const MotionDatabase database = build_database(run_sweep(parse_sweep_plan(plan, "flutter.toml")).sweep);
    const MotionGraph graph = motion_graph(database);
    for (const GraphEdge& edge : graph.edges) {
      const auto run = [&](Eigen::Index n) { return database.segments[static_cast<std::size_t>(n)].run; };
      if (edge.to != database.next_of(edge.from)) CHECK(run(edge.from) != run(edge.to));
    }
    return static_cast<double>(graph.kept) / static_cast<double>(database.segment_count());
  };
  const double some = share("60"), more = share("120");
  CHECK(some > 0.5);
  CHECK(more > 0.9 * some);

  MotionDatabase steady = build_database(plates(2));
  const std::size_t events = steady.kind_sequences().front().size();
  for (MotionSegment& segment : steady.segments) segment.is_steady = segment.run == 0;
  CHECK(events > 0);
  CHECK(steady.kind_sequences().front().empty());
  CHECK_FALSE(steady.kind_sequences().back().empty());
}

TEST_CASE("falls that are all steady have no events to cut them at") {
  const std::string plan =
      "model = \"immersed_body\"\n[fixed]\na = 0.035\nb = 0.02\nc = 1e-4\ndensity = 400\nC_D0 = 0.05\n"
      "C_w = 2\n[axes]\nC_D90 = { from = 0.6, to = 2.7 }\n[sample]\ncount = 2\n[releases]\ntilt = [0]\n"
      "axis = [0.6]\n[run]\nuntil = 2\nstep = 1e-3\nsettle = 0.5\n";
  CHECK(error_text<samara::ArgumentError>([&] {
          build_database(run_sweep(parse_sweep_plan(plan, "steady.toml")).sweep);
        }) == "all falls of the sweep are steady: there are no events to cut them at");
}

TEST_CASE("a fall that lands early has settled at the same share of its time, and chains have its kinds") {
  std::string plan = plate_plan(40, "height = 15\n");
  const std::string run = "until = 60\nstep = 0.05\nsettle = 10\n";
  plan.replace(plan.find(run), run.size(), "until = 200\nstep = 0.05\nsettle = 50\n");
  const Sweep sweep = run_sweep(parse_sweep_plan(plan, "plates.toml")).sweep;
  const MotionDatabase database = build_database(sweep);
  const auto sequences = database.kind_sequences();
  int early = 0, told = 0;
  for (std::size_t n = 0; n < database.runs.size(); ++n) {
    const double end = sweep.reached[database.runs[n].fall];
    CHECK(database.runs[n].settle == Approx(50.0 * std::min(1.0, end / 200.0)));
    if (end >= 50.0) continue;
    ++early;
    told += sequences[n].empty() ? 0 : 1;
  }
  REQUIRE(early > 10);
  CHECK(2 * told > early);
  const TemporaryDirectory folder;
  save(database, motion_graph(database), folder / "landed.h5");
  CHECK(load_database(folder / "landed.h5").kind_sequences() == sequences);
}

TEST_CASE("a database has the symmetry that all of its runs have") {
  // The first of them are discs.
  const std::string plan =
      "model = \"immersed_body\"\n[fixed]\na = 0.03\nb = 0.03\nc = 1e-4\ndensity = 1200\nC_D0 = 0.05\n"
      "C_D90 = 0.61\nC_T = 1.81\nC_R = 1.21\nC_w = 2\n[axes]\nlinear_damping_x = { from = 0, to = 1e-6, "
      "count = 2 }\n[releases]\ntilt = [0.17]\naxis = [0.6]\n[run]\nuntil = 2\nstep = 1e-3\nsettle = 0.5\n";
  const MotionDatabase database = build_database(run_sweep(parse_sweep_plan(plan, "discs.toml")).sweep);
  REQUIRE(database.runs.front().coefficients[0] == 0.0);
  CHECK(database.symmetry == BodySymmetry::ellipsoid);
  const auto symmetry = [](const std::map<std::string, double>& more) {
    std::map<std::string, double> values = {{"a", 0.03}, {"b", 0.03}, {"c", 1e-4}, {"density", 1200.0}};
    values.insert(more.begin(), more.end());
    const samara::models::ParametricModel body(samara::models::find_model("immersed_body"), values, {});
    return MovingStates::of(body.model(), body.parameters({})).symmetry();
  };
  CHECK(symmetry({}) == BodySymmetry::disc);
  CHECK(symmetry({{"M_x", 1e-3}}) == BodySymmetry::ellipsoid);
  CHECK(symmetry({{"J_y", 1e-6}}) == BodySymmetry::ellipsoid);
}

TEST_CASE("steady segments are counted by themselves, not by the sign of a turn that is round-off") {
  MotionDatabase database = build_database(plates(20));
  const MotionGraph graph = motion_graph(database);
  const auto turns = std::ranges::count(database.segments, EventKind::turn_plus, &MotionSegment::kind);
  REQUIRE(turns > 0);
  for (MotionSegment& segment : database.segments) segment.is_steady = false;
  CHECK_THAT(database_text(database, graph, kind_chain(database)), !Catch::Contains("steady"));
  for (MotionSegment& segment : database.segments) segment.is_steady = segment.kind == EventKind::turn_plus;
  CHECK_THAT(database_text(database, graph, kind_chain(database)),
             Catch::Contains(" 0 turn+ " + std::to_string(turns) + " steady\n"));
  CHECK_THAT(
      database_json(database, graph, kind_chain(database)),
      Catch::Contains("\"turn+\": 0") && Catch::Contains("\"steady\": " + std::to_string(turns) + ","));
}

TEST_CASE("a database that is cancelled is none, and asked for again it is the same to the bit") {
  const Sweep sweep = plates(20);
  const MotionDatabase whole = build_database(sweep);
  int reports = 0;
  const DatabaseOptions cancelling{.threads = 1, .progress = [&](const samara::Progress&) {
                                     ++reports;
                                     return false;
                                   }};
  CHECK(error_text<samara::NoResultError>([&] { build_database(sweep, cancelling); }) ==
        "cancelled before the motions were cut into segments");
  CHECK(reports == 1);
  const MotionDatabase again = build_database(sweep, {.threads = 1});
  CHECK(again.starts == whole.starts);
  CHECK(again.ends == whole.ends);
  CHECK(again.metric_weights == whole.metric_weights);
}

TEST_CASE("a database comes back from its file, and what is no database is refused") {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "motions.h5";
  const MotionDatabase database = build_database(plates(20, "keep = \"trajectories\"\n"));
  save(database, motion_graph(database), path);
  const MotionDatabase again = load_database(path);
  CHECK(again.starts == database.starts);
  CHECK(again.ends == database.ends);
  CHECK(again.frames == database.frames);
  CHECK(again.run_first == database.run_first);
  CHECK(again.metric_weights == database.metric_weights);
  CHECK(again.fixed == database.fixed);
  CHECK(again.kind_sequences() == database.kind_sequences());
  CHECK(again.runs[7].coefficients == database.runs[7].coefficients);
  CHECK(again.segments[9].displacement == database.segments[9].displacement);
  CHECK(again.events.mean_square_speed == database.events.mean_square_speed);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  CHECK_FALSE(error_text<samara::InputError>([&] { load_database(path); }).empty());
  MotionDatabase nowhere = database;
  nowhere.settle = std::nan("");
  save(nowhere, motion_graph(database), path);
  CHECK(error_text<samara::InputError>([&] {
          load_database(path);
        }).find("settle is nan, expected a finite number") != std::string::npos);

  const samara::models::ParametricModel other(samara::models::find_model("falling_plate_nd"),
                                              {{"beta", 0.0}, {"inertia_ratio", 1.4}}, {"C_T"});
  CHECK(error_text<samara::ArgumentError>([&] { require_same_body(database, other); }) ==
        "the motions of the database have inertia_ratio = 1.3, the body has 1.4");
  std::string changed = plate_plan(9);
  const std::string ratio = "inertia_ratio = 1.3\n[axes]\n";
  changed.replace(changed.find(ratio), ratio.size(), "[axes]\ninertia_ratio = { from = 1, to = 2 }\n");
  CHECK(error_text<samara::ArgumentError>([&] {
          build_database(run_sweep(parse_sweep_plan(changed, "bodies.toml")).sweep);
        }).find("the sweep changes inertia_ratio, which is no coefficient of falling_plate_nd") == 0);
}

TEST_CASE(
    "the chaotic plate remembers more than one event: a first-order chain fails where a longer one does "
    "not") {
  // Trap: stationary shares are those of any chain of counts. I* 2, from many releases.
  const std::string plan =
      "model = \"falling_plate_nd\"\n[fixed]\nbeta = 0\ninertia_ratio = 2\nC_T = 1.2\n[axes]\n"
      "\"theta(0)\" = { from = 0.1, to = 1.4 }\n[sample]\ncount = "
      "128\n"
      "[run]\nuntil = 300\nstep = 0.05\nsettle = 30\n";
  const MotionDatabase database = build_database(run_sweep(parse_sweep_plan(plan, "chaos.toml")).sweep);
  CHECK(database.coefficient_names.empty());  // all runs have those that are fixed
  const TemporaryDirectory folder;
  save(database, motion_graph(database), folder.path() / "chaos.h5");
  CHECK(load_database(folder.path() / "chaos.h5").starts == database.starts);
  const auto sequences = database.kind_sequences();
  std::vector<std::vector<int>> fit(sequences.begin(), sequences.begin() + 64),
      rest(sequences.begin() + 64, sequences.end());
  const KindChain kinds = kind_chain(database);
  CHECK(kinds.choice.order >= 3);
  const MarkovChain first = MarkovChain::fitted(fit, 4, 1),
                    longer = MarkovChain::fitted(fit, 4, kinds.choice.order);
  CHECK(longer.log_likelihood(rest, 5) - first.log_likelihood(rest, 5) > 0.3);
  samara::Stream stream(1, 0);
  Eigen::VectorXd own = Eigen::VectorXd::Zero(4), seen = own;
  for (const int kind : first.draw_sequence(20000, stream)) own[kind] += 1.0 / 20000.0;
  double events = 0.0;
  for (const auto& run : rest) {
    for (const int kind : run) seen[kind] += 1.0;
    events += static_cast<double>(run.size());
  }
  CHECK((own - seen / events).cwiseAbs().maxCoeff() < 0.03);  // which proves nothing
  CHECK(check(first, rest).two_steps > 3.0 * check(longer, rest).two_steps);
}

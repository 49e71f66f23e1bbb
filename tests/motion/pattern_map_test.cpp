// Maps of patterns: what lies where, refining, clamping, shares over releases.
#include "samara/motion/sweeps/pattern_map.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include <catch2/catch.hpp>

#include "plates_sweep.h"
#include "samara/motion/sweeps/phase_diagram.h"
#include "samara/motion/sweeps/refining.h"
#include "samara/motion/sweeps/sweep_file.h"
#include "tests/io/temporary_directory.h"

using namespace samara::motion;

TEST_CASE("a map says what lies where, how surely, and how far the border is") {
  // A checkerboard would have no regions: the falls of a plate have some.
  const Sweep sweep =
      run_sweep(plates("", "C_R = [1.4, 3.14159]", "C_R = { from = 2.2, to = 3.2, count = 9 }")).sweep;
  const PatternMap map(sweep, 0);
  CHECK(map.left_one_out() > 0.5);
  Eigen::Index points = 0;
  for (const MapRegion& region : map.regions()) points += region.falls;
  CHECK(points == 81);
  CHECK(map.border_share() > 0.0);
  CHECK(map.border_share() < 1.0);
  const Eigen::Vector2d width(1.6, 1.0);
  for (Eigen::Index n = 10; n < 71; n += 6) {
    if (n % 9 == 0 || n % 9 == 8) continue;  // at the edge, farther points are asked
    const Eigen::Vector2d point = sweep.points.row(n);
    const MapAnswer answer = map.at(point);
    double border = 1e9;
    int around = 0;
    for (Eigen::Index m = 0; m < 81; ++m) {
      const double distance = (sweep.points.row(m).transpose() - point).cwiseQuotient(width).norm();
      if (map.pattern(m) != answer.pattern) border = std::min(border, distance);
      // The eight around it, of which seven are asked.
      around += distance < 1.5 / 8.0 && map.pattern(m) == answer.pattern;
    }
    CHECK(answer.distance_to_border == Approx(border).margin(1e-12));
    CHECK(answer.probability <= around / 7.0 + 1e-12);
    CHECK(answer.probability >= 1.0 / 7.0 - 1e-12);
  }
  samara::Stream stream(1, 0);
  for (int k = 0; k < 20; ++k) CHECK(map.at(map.draw(Pattern::zigzag, stream)).probability > 0.4);
  CHECK(error_text<samara::ArgumentError>([&] {
          map.draw(Pattern::helix, stream);
        }).find("helix is 0 of 81 points") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([&] {
          map.at(Eigen::Vector2d(9.0, 2.5));
        }).starts_with(sweep.names[0] + " of the point is 9, expected "));
}

TEST_CASE("of many points those that are asked are drawn, from both ends of every axis") {
  constexpr Eigen::Index kAlong = 1500;
  Sweep sweep;
  sweep.names = {"C_T", "C_R"};
  sweep.lower = Eigen::Vector2d::Zero();
  sweep.upper = Eigen::Vector2d::Ones();
  sweep.axes = {std::vector<double>(kAlong), {0.0, 1.0}};
  sweep.points.resize(2 * kAlong, 2);
  for (Eigen::Index n = 0; n < 2 * kAlong; ++n) {
    const double along = static_cast<double>(n / 2) / (kAlong - 1.0);
    sweep.axes[0][static_cast<std::size_t>(n / 2)] = along;
    sweep.points.row(n) << along, static_cast<double>(n % 2);
    // On one side all are alike, on the other no point tells of those beside it.
    const bool is_zigzag = n % 2 == 0 || samara::Stream(3, static_cast<std::uint64_t>(n)).uniform() < 0.5;
    sweep.labels.push_back({is_zigzag ? Pattern::zigzag : Pattern::chaotic, 0.0, ""});
    sweep.status.push_back(FallStatus::done);
  }
  const double told = PatternMap(sweep).left_one_out();
  CHECK(told > 0.6);
  CHECK(told < 0.9);
  CHECK(drawn_numbers(3, 3) == std::vector<Eigen::Index>{0, 1, 2});
  const std::vector<Eigen::Index> drawn = drawn_numbers(6000, 4000);
  REQUIRE(drawn.size() == 4000);
  CHECK(std::ranges::adjacent_find(drawn, std::greater_equal()) == drawn.end());
  // Half of them of each release of two, to four deviations.
  const auto even = std::ranges::count_if(drawn, [](Eigen::Index n) { return n % 2 == 0; });
  CHECK(std::abs(static_cast<double>(even) - 2000.0) < 4.0 * std::sqrt(1000.0));
}

TEST_CASE("a refined grid runs only what lies between different labels") {
  const SweepPlan plan =
      plates("[refine]\nrounds = 1\n", "C_R = [1.4, 3.14159]", "C_R = { from = 2.2, to = 3.2, count = 9 }");
  Sweep sweep = run_sweep(plan).sweep;
  const Sweep coarse = sweep;
  REQUIRE(refine(plan, {}, sweep));
  CHECK(sweep.points.rows() == 17 * 17);
  CHECK(sweep.fall_count() == 2 * 17 * 17);
  const auto inherited = std::ranges::count(sweep.status, FallStatus::inherited);
  CHECK(inherited > 50);
  // Old points stay as they were, and a fall that was run is the plan's own at its point.
  for (Eigen::Index n = 0; n < coarse.points.rows(); ++n) {
    Eigen::Index same = -1;
    for (Eigen::Index m = 0; m < sweep.points.rows(); ++m) {
      if ((sweep.points.row(m) - coarse.points.row(n)).norm() < 1e-12) same = m;
    }
    REQUIRE(same >= 0);
    CHECK(sweep.labels[static_cast<std::size_t>(2 * same)].pattern ==
          coarse.labels[static_cast<std::size_t>(2 * n)].pattern);
    CHECK(sweep.status[static_cast<std::size_t>(2 * same)] != FallStatus::inherited);
  }
  const Sweep whole = run_sweep(plates("", "count = 9 }\nC_R = [1.4, 3.14159]",
                                       "count = 17 }\nC_R = { from = 2.2, to = 3.2, count = 17 }"))
                          .sweep;
  int compared = 0;
  for (Eigen::Index n = 0; n < whole.fall_count(); ++n) {
    const auto k = static_cast<std::size_t>(n);
    const Eigen::Index point = whole.point_of(n);
    CHECK((whole.points.row(point) - sweep.points.row(point)).norm() < 1e-12);
    if (sweep.status[k] == FallStatus::inherited || whole.points.row(point) != sweep.points.row(point))
      continue;
    ++compared;
    for (std::size_t f = 0; f < kFeatures; ++f)
      CHECK(are_same(sweep.features[k].values[f], whole.features[k].values[f]));
  }
  CHECK(compared > 2 * 81);
  // Only points that were run are asked, of each other: what inherits has its label from them.
  const PatternMap map(sweep, 0);
  CHECK(map.run_count() == 17 * 17 - inherited / 2);
  CHECK(sweep.run_count() == 2 * map.run_count());
  Sweep run_alone = sweep;
  run_alone.axes.clear();
  std::vector<Eigen::Index> points;
  std::vector<PatternLabel> labels;
  std::vector<FallStatus> status;
  for (Eigen::Index n = 0; n < sweep.points.rows(); ++n) {
    const auto first = static_cast<std::size_t>(2 * n);
    if (sweep.status[first] == FallStatus::inherited) continue;
    points.push_back(n);
    labels.insert(labels.end(), {sweep.labels[first], sweep.labels[first + 1]});
    status.insert(status.end(), {sweep.status[first], sweep.status[first + 1]});
  }
  run_alone.points = sweep.points(points, Eigen::all);
  run_alone.labels = labels;
  run_alone.status = status;
  CHECK(map.left_one_out() == PatternMap(run_alone, 0).left_one_out());
  Sweep rounds = coarse;
  const RefiningResult refined = refine_by_plan(plan, {}, rounds);
  REQUIRE(refined.rounds.size() == 2);
  CHECK(refined.seconds > 0.0);
  CHECK(refined.rounds[0].run == 81);
  CHECK(refined.rounds[1].run == map.run_count());
  std::vector<Eigen::Index> first;
  for (Eigen::Index n = 0; n < 17 * 17; ++n) {
    if (n / 17 % 2 == 0 && n % 17 % 2 == 0) first.push_back(n);
  }
  CHECK(refined.rounds[1].agreement ==
        std::min(map.left_one_out(first), PatternMap(sweep, 1).left_one_out(first)));
  const SweepPlan drawn = plates("[sample]\ncount = 100\nseed = 3\n",
                                 "inertia_ratio = { from = 0.8, to = 2.4, count = 9 }\nC_R = [1.4, 3.14159]",
                                 "inertia_ratio = { from = 0.8, to = 2.4 }\nC_R = { from = 1.4, to = 3.2 }");
  Sweep sample = run_sweep(drawn).sweep;
  REQUIRE(refine(drawn, {}, sample));
  CHECK(sample.points.rows() == 120);
  CHECK(sample.fall_count() == 240);
}

TEST_CASE("a refined sweep knows the round of each of its points, and goes on after the last that was kept") {
  const TemporaryDirectory directory;
  const std::filesystem::path file = directory / "rounds.h5", part = directory / "rounds.part";
  const std::string from = "inertia_ratio = { from = 0.8, to = 2.4, count = 9 }\nC_R = [1.4, 3.14159]";
  for (const bool is_grid : {true, false}) {
    const SweepPlan plan =
        is_grid ? plates("[refine]\nrounds = 2\n")
                : plates("[sample]\ncount = 40\nseed = 3\n[refine]\nrounds = 2\n", from,
                         "inertia_ratio = { from = 0.8, to = 2.4 }\nC_R = { from = 1.4, to = 3.2 }");
    const Sweep begun = run_sweep(plan, {.checkpoint = part}).sweep;
    Sweep whole = begun, halted = begun;
    // Without a checkpoint that could be written, too, which is told once.
    int told = 0;
    const SweepOptions unkept = {.checkpoint = directory / std::string(300, 'n'),
                                 .warning = [&](const std::string&) { ++told; }};
    REQUIRE(refine_by_plan(plan, unkept, whole).complete);
    CHECK(told == 1);
    // In the second round it is stopped: what the first has found is kept.
    const auto stop = [&](const samara::Progress&) { return halted.rounds.size() < 2; };
    CHECK_FALSE(refine_by_plan(plan, {.progress = stop, .checkpoint = part}, halted).complete);
    REQUIRE(std::filesystem::exists(part));
    SweepResult taken = run_sweep(plan, {.checkpoint = part});
    CHECK(taken.complete);
    CHECK(taken.sweep.points.rows() == halted.points.rows());
    REQUIRE(taken.sweep.rounds.size() == 2);
    CHECK(taken.sweep.rounds[1].agreement == halted.rounds[1].agreement);
    const RefiningResult rest = refine_by_plan(plan, {.checkpoint = part}, taken.sweep);
    CHECK(rest.complete);
    CHECK(rest.message == "all 2 rounds");
    CHECK(rest.rounds.size() == 3);
    CHECK_FALSE(std::filesystem::exists(part));
    CHECK(taken.sweep.points == whole.points);
    REQUIRE(taken.sweep.fall_count() == whole.fall_count());
    for (std::size_t n = 0; n < whole.labels.size(); ++n)
      CHECK(taken.sweep.labels[n].pattern == whole.labels[n].pattern);
    // Counted by where points lie: of a grid those between old ones are of a later round.
    save(taken.sweep, file);
    const Sweep read = load_sweep(file);
    CHECK(read.round_of_point == whole.round_of_point);
    REQUIRE(read.rounds.size() == 3);
    std::vector<Eigen::Index> counts(3, 0);
    for (Eigen::Index n = 0; n < read.points.rows(); ++n) {
      const int round = read.round_of_point[static_cast<std::size_t>(n)];
      REQUIRE(round >= 0);
      REQUIRE(round < 3);
      ++counts[static_cast<std::size_t>(round)];
      const bool is_first = (begun.points.rowwise() - read.points.row(n)).rowwise().norm().minCoeff() < 1e-12;
      CHECK(is_first == (round == 0));
    }
    Eigen::Index points = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      points += counts[k];
      CHECK(read.rounds[k].points == points);
      CHECK(read.rounds[k].agreement == whole.rounds[k].agreement);
    }
  }
}

TEST_CASE("a refined grid keeps the trajectories of the falls that were run") {
  const SweepPlan plan = plates("interval = 2\nkeep = \"trajectories\"\n[refine]\nrounds = 1\n");
  Sweep sweep = run_sweep(plan).sweep;
  const Sweep coarse = sweep;
  REQUIRE(refine(plan, {}, sweep));
  REQUIRE(sweep.trajectories.size() == sweep.labels.size());
  CHECK(sweep.trajectories.front() == coarse.trajectories.front());
  for (std::size_t n = 0; n < sweep.labels.size(); ++n)
    CHECK(sweep.trajectories[n].allFinite() == (sweep.status[n] != FallStatus::inherited));
}

TEST_CASE("refining ends where a round adds less than the gain to what is told of points left out") {
  const std::string from = "inertia_ratio = { from = 0.8, to = 2.4, count = 9 }\nC_R = [1.4, 3.14159]";
  const std::string to = "inertia_ratio = { from = 0.8, to = 2.4 }\nC_R = { from = 1.4, to = 3.2 }";
  const std::string sample = "[sample]\ncount = 80\nseed = 3\n[refine]\nrounds = 8\n";
  const SweepPlan plan = plates(sample + "gain = 0.02\n", from, to), every = plates(sample, from, to);
  const Sweep begun = run_sweep(plan).sweep;
  Sweep sweep = begun, whole = begun;
  const RefiningResult some = refine_by_plan(plan, {}, sweep), all = refine_by_plan(every, {}, whole);
  CHECK(some.complete);
  REQUIRE(all.rounds.size() == 9);
  REQUIRE(some.rounds.size() >= 2);
  REQUIRE(some.rounds.size() < 9);
  CHECK(some.message.find("less than 2 %") != std::string::npos);
  for (std::size_t k = 0; k < some.rounds.size(); ++k) {
    CHECK(some.rounds[k].agreement == all.rounds[k].agreement);
    const bool is_last = k + 1 == some.rounds.size();
    if (k > 0) CHECK((some.rounds[k].agreement - some.rounds[k - 1].agreement < 0.02) == is_last);
  }
  CHECK(sweep.points.rows() == some.rounds.back().points);
  // Points at borders tell more of the points that were drawn first.
  CHECK(all.rounds.back().agreement > all.rounds.front().agreement);
  Sweep cancelled = begun;
  const RefiningResult none =
      refine_by_plan(every, {.progress = [](const samara::Progress&) { return false; }}, cancelled);
  CHECK_FALSE(none.complete);
  CHECK(cancelled.points.rows() == 80);
  CHECK(
      refusal("settle = 60", "settle = 60\n[refine]\nrounds = 1\ngain = 1").find("more than 0 and below 1") !=
      std::string::npos);
}

TEST_CASE("a point is clamped to the part of a pattern, as near as the map has it") {
  const Sweep sweep =
      run_sweep(plates("", "C_R = [1.4, 3.14159]", "C_R = { from = 2.2, to = 3.2, count = 9 }")).sweep;
  const PatternMap map(sweep, 0);
  samara::Stream stream(5, 0);
  for (int n = 0; n < 20; ++n) {
    const Eigen::Vector2d point(0.8 + 1.6 * stream.uniform(), 2.2 + stream.uniform());
    const Eigen::VectorXd place = map.clamp(Pattern::zigzag, point);
    const auto scale = [](const Eigen::VectorXd& from) { return Eigen::Vector2d(from[0] / 1.6, from[1]); };
    if (map.at(point).pattern == Pattern::zigzag) {
      CHECK((place - point).norm() < 1e-12);
      continue;
    }
    double nearest = 1e9;
    for (Eigen::Index k = 0; k < map.size(); ++k) {
      if (map.pattern(k) == Pattern::zigzag)
        nearest = std::min(nearest, (scale(sweep.points.row(k)) - scale(point)).norm());
    }
    CHECK((scale(place) - scale(point)).norm() <= nearest + 1e-12);
    // Where falls of the pattern stand alone the map calls them by their neighbours' pattern.
    const bool is_fall =
        ((sweep.points.rowwise() - place.transpose()).rowwise().norm().array() < 1e-12).any();
    CHECK((is_fall || map.at(place).pattern == Pattern::zigzag));
  }
  CHECK_THROWS_WITH(map.clamp(Pattern::helix, Eigen::Vector2d(1.0, 3.0)),
                    Catch::Matchers::Contains("helix is 0 of 81"));
  CHECK((map.clamp(map.at(Eigen::Vector2d(0.8, 3.2)).pattern, Eigen::Vector2d(0.1, 9.0)) -
         Eigen::Vector2d(0.8, 3.2))
            .norm() < 1e-12);
}

TEST_CASE("an axis of a single value has no width: points are drawn, clamped and asked on it") {
  const Sweep sweep = run_sweep(plates("", "C_R = [1.4, 3.14159]", "C_R = [3.14159]")).sweep;
  const PatternMap map(sweep, 0);
  samara::Stream stream(2, 0);
  for (int k = 0; k < 10; ++k) CHECK(map.draw(map.pattern(0), stream)[1] == 3.14159);
  CHECK(map.clamp(map.pattern(0), Eigen::Vector2d(0.8, 3.5))[1] == 3.14159);
  CHECK_THROWS_WITH(map.at(Eigen::Vector2d(0.8, 3.5)),
                    Catch::Matchers::Contains("expected 3.14159 to 3.14159"));
  const Eigen::Vector2d beside(0.8, std::nextafter(3.14159, 4.0));
  CHECK_NOTHROW(map.at(beside));
  CHECK_NOTHROW(shares_at(sweep, beside));
}

TEST_CASE("shares of patterns are those of all releases, with intervals that hold what was not seen") {
  Sweep sweep = run_sweep(plates()).sweep;
  const Eigen::MatrixXd shares = release_shares(sweep);
  REQUIRE(shares.rows() == 18);
  CHECK(((shares.rowwise().sum().array() - 1.0).abs() < 1e-14).all());
  const std::vector<int> counts = sweep.counts();
  Eigen::Index most = 0;
  const double largest = shares.colwise().sum().maxCoeff(&most);
  CHECK(largest * 2.0 == counts[static_cast<std::size_t>(most)]);
  // Jeffreys' interval of 0 and 1 of 10: tables of Brown, Cai and DasGupta.
  const Share none = counted_share(0, 10), one = counted_share(1, 10);
  CHECK(none.lower == 0.0);
  CHECK(std::abs(none.upper - 0.217) < 5e-4);
  CHECK(std::abs(one.lower - 0.011) < 5e-4);
  CHECK(std::abs(one.upper - 0.381) < 5e-4);
  CHECK(counted_share(10, 10).upper == 1.0);
  CHECK_THROWS_AS(counted_share(3, 2), samara::ArgumentError);
}

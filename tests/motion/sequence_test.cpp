/// Kinds and patterns that a fall is asked to have, and what they are drawn from.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "plate_plans.h"
#include "samara/base/errors.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/planning/motion_judgement.h"
#include "samara/motion/planning/plan_checks.h"
#include "samara/motion/planning/planner.h"
#include "tests/io/temporary_directory.h"

using namespace samara::motion;

namespace {

/// A file of the tests below, by its path.
std::string path_of(const std::string& name, const std::string& text) {
  static const TemporaryDirectory directory;
  return directory.put(name, text).string();
}

}  // namespace

TEST_CASE("kinds that are drawn from a chain come about, and are counted in the motion itself") {
  MotionPlan plan = sequence_plan(100.0);
  plan.search.beam = 24;
  plan.search.children = 24;
  plan.database = plate_motions();
  plan.sequence = read_text("length = 7\nseed = 3");
  CHECK(read_text("length = 7\nseed = 4").segments.front().kind.has_value());
  const MotionResult motion = plan_motion(plan);
  REQUIRE(motion.is_usable());
  const SequenceOutcome& outcome = *motion.sequence;
  CHECK(outcome.asked == 7);
  CHECK(outcome.had >= 6);  // 7 here; the first kinds are often decided by the release
  CHECK((motion.status == MotionStatus::found) == (outcome.had == outcome.asked));
  // Another finder, in the states that came out.
  const EventList list = events_of(
      MovingStates(plan.model->info(), BodySymmetry::none), plate_motions()->events,
      {motion.times.data(), static_cast<std::size_t>(motion.times.size())}, motion.states.transpose());
  REQUIRE(list.events.size() == outcome.segments.size() + 1);
  int had = 0;
  for (std::size_t k = 0; k < outcome.segments.size(); ++k) {
    CHECK(outcome.segments[k].end == list.events[k + 1].t);
    if (!list.events[k + 1].is_steady) CHECK(outcome.segments[k].got == list.events[k + 1].kind);
    if (k < 7) had += plan.sequence->segments[k].kind == list.events[k + 1].kind ? 1 : 0;
  }
  CHECK(outcome.had == had);
}

TEST_CASE("kinds that cannot be had are no kinds that were dropped: the status and the counts say so") {
  MotionPlan plan = sequence_plan(20.0);
  plan.sequence = read_text("kinds = [\"30 turn-\"]", nullptr);
  const MotionResult motion = plan_motion(plan);
  CHECK(motion.status == MotionStatus::kinds_missed);
  CHECK(motion.sequence->asked == 30);
  CHECK(motion.sequence->had < 10);
  CHECK(motion.sequence->not_reached == 30 - std::ssize(motion.sequence->segments));
  CHECK_THAT(motion.message, Catch::Contains("of 30 kinds as asked") && Catch::Contains("not reached"));
}

TEST_CASE("patterns are told by what the motion shows, stretch by stretch") {
  MotionPlan plan = sequence_plan(120.0);
  plan.database = plate_motions();
  for (const Pattern pattern : {Pattern::zigzag, Pattern::autorotation}) {
    plan.sequence = read_text("patterns = [\"8 " + to_string(pattern) + "\"]");
    CHECK(plan.sequence->is_of_patterns());
    const MotionResult motion = plan_motion(plan);
    REQUIRE(motion.sequence->stretches.size() == 1);
    const SequenceOutcome::Stretch& stretch = motion.sequence->stretches.front();
    CHECK(stretch.got.pattern == pattern);
    CHECK(stretch.end > stretch.begin);
    CHECK(motion.status == MotionStatus::found);
  }
}

TEST_CASE("patterns of a film of places alone are looked for in the places of the fall alone") {
  const auto film = [](const std::string& seen) {
    return path_of("places.json", R"({"schema": "samara-patterns/1", "captures": [{"id": "a", )" + seen +
                                      R"("windows": [{"pattern": "zigzag", "windows": 40}]}]})");
  };
  MotionPlan plan = sequence_plan(120.0);
  plan.database = plate_motions();
  const std::string drawn = "\"\nlength = 4\nseed = 1";
  plan.sequence = read_text("chain = \"" + film("") + drawn);
  CHECK_FALSE(plan.sequence->is_of_places);
  plan.sequence = read_text("chain = \"" + film("\"attitude\": false, ") + drawn);
  CHECK(plan.sequence->is_of_places);
  const MotionResult motion = plan_motion(plan);
  REQUIRE(motion.sequence->stretches.size() == 1);
  // The phrase names what the rule has of places: sway or veers, never flips.
  const std::string& why = motion.sequence->stretches.front().got.why;
  CHECK_THAT(why, !Catch::Contains("flips") && !Catch::Contains("tilt"));
  plan.sequence->is_of_places = false;
  CHECK(plan_motion(plan).sequence->stretches.front().got.why != why);
}

TEST_CASE("stretches are named by the thresholds of the sweep, or of the film that they are drawn from") {
  // By these a plate that turns over zigzags.
  auto motions = std::make_shared<MotionDatabase>(*plate_motions());
  motions->plan_text += "[labels]\nflips_plane = 1000\n";
  MotionPlan plan = sequence_plan(120.0);
  plan.database = motions;
  plan.sequence = read_text("patterns = [\"8 autorotation\"]", motions.get());
  const MotionResult motion = plan_motion(plan);
  REQUIRE(motion.sequence->stretches.size() == 1);
  CHECK(motion.sequence->stretches.front().got.pattern == Pattern::zigzag);
  CHECK(motion.status == MotionStatus::kinds_missed);
  const auto film = [](const std::string& thresholds) {
    return "chain = \"" +
           path_of("named.json", R"({"schema": "samara-patterns/1", "thresholds": {)" + thresholds +
                                     R"(}, "captures": [{"id": "a", "windows": [
          {"pattern": "zigzag", "windows": 40}]}]})") +
           "\"\nlength = 4";
  };
  CHECK(read_text(film("\"flips_plane\": 3"), motions.get()).thresholds.flips_plane == 3.0);
  CHECK_THROWS_WITH(read_text(film("\"flip_plane\": 3"), motions.get()),
                    Catch::Contains("named.json") && Catch::Contains("flips_plane"));
}

TEST_CASE("a fall that is asked to be likely is likelier under the chain than one that is not") {
  MotionPlan plan = sequence_plan(100.0);
  // A chain that swings to and fro, as zigzags do.
  const std::string zigzags =
      path_of("zigzags.json",
              R"({"schema": "samara-chain/1", "symbols": ["swing-", "swing+", "turn-", "turn+"],
          "counts": [[0, 90, 0, 0], [90, 0, 0, 0], [45, 45, 0, 0], [45, 45, 0, 0]]})");
  plan.sequence = read_text("chain = \"" + zigzags + "\"\nweight = 1e-6", nullptr);
  const double careless = plan_motion(plan).sequence->log_likelihood;
  plan.sequence->weight = 20.0;
  const MotionResult likely = plan_motion(plan);
  CHECK(likely.sequence->log_likelihood > careless + 1.0);
  CHECK(likely.sequence->asked == 0);
  CHECK(likely.status == MotionStatus::found);
}

TEST_CASE("chains come from films, from counts and from databases; what is none is refused") {
  const std::string film = path_of("film.JSON",
                                   R"({"schema": "samara-patterns/1", "captures": [{"id": "a", "windows": [
          {"pattern": "zigzag", "windows": 40}, {"pattern": "unresolved"}, {"pattern": "chaotic", "windows": 40}]}]})");
  const MotionSequence drawn = read_text("chain = \"" + film + "\"\nlength = 30\nseed = 2\nevents = 3");
  REQUIRE(drawn.segments.size() == 90);
  int changes = 0;
  for (std::size_t k = 1; k < drawn.segments.size(); ++k) {
    if (drawn.segments[k].pattern == drawn.segments[k - 1].pattern) continue;
    CHECK(k % 3 == 0);
    ++changes;
  }
  CHECK(changes <= 6);  // windows last, as they do in the film
  CHECK(drawn.seed == 2u);
  const std::string counts =
      path_of("counts.json",
              R"({"schema": "samara-chain/1", "symbols": ["turn+", "swing-"], "counts": [[0, 9], [9, 0]]})");
  const MotionSequence alternating = read_text("chain = \"" + counts + "\"\nlength = 12\nseed = 5", nullptr);
  int turns = 0;
  for (const AskedSegment& segment : alternating.segments)
    turns += segment.kind == EventKind::turn_plus ? 1 : 0;
  CHECK(turns > 2);
  CHECK(turns < 10);
  const auto refuses = [](const std::string& text, const std::string& sentence, bool has_database = true) {
    CHECK_THROWS_WITH(read_text(text, has_database ? plate_motions().get() : nullptr),
                      Catch::Contains(sentence));
  };
  refuses("kinds = [\"swing\"]", "expected one of swing-");
  refuses("kinds = [\"0 swing+\"]", "a count of 1 or more");
  refuses("kinds = [\"swing+\"]\npatterns = [\"zigzag\"]", "one of the two");
  refuses("kinds = [\"swing+\"]\nseed = 2", "sequences that are drawn");
  refuses("patterns = [\"helix\"]", "helix is 0 of 100 falls");
  refuses("patterns = [\"zigzag\"]", "expected database", false);
  refuses("length = 3", "expected one of them", false);
  refuses("length = 0", "expected 1 to");
  refuses("weight = 0", "more than 0");
  refuses("events = 2", "expected none here");
  refuses("chain = \"" + film + "\"", "length");
  refuses("chain = \"" + film + "\"\nlength = 60000", "asks for 120000 segments, 2 of each pattern");
  const auto film_of = [](const std::string& first, const std::string& second) {
    return path_of("counted.json",
                   R"({"schema": "samara-patterns/1", "captures": [
          {"id": "a", "windows": [{"pattern": "zigzag", "windows": )" +
                       first + R"(}]}, {"id": "b", "windows": [{"pattern": "chaotic", "windows": )" + second +
                       "}]}]}");
  };
  const auto of_film = [](const std::string& file) { return "chain = \"" + file + "\"\nlength = 2"; };
  for (const char* count : {"0", "1.5", "-2"})
    refuses(of_film(film_of("3", count)), std::string("a window of its captures counts for ") + count +
                                              ", expected whole numbers from 1 on");
  // It is the sum that is too large, not the window with which it is.
  refuses(of_film(film_of("10000000", "1")),
          "windows of its captures count for 10000001 or more in all, expected at most 10000000");
  CHECK(read_text(of_film(film_of("200000", "1"))).segments.size() == 4);
  refuses("chain = \"" + path_of("odd.json", "{}") + "\"\nlength = 2", "is no chain");
  refuses(
      "chain = \"" + path_of("odd.json", R"({"schema": "samara-chain/1", "symbols": 3})") + "\"\nlength = 2",
      "is damaged");
}

TEST_CASE("the dissertation's chain of patterns is drawn from, and ends in zigzag") {
  bool has_ended = false, changes = false;
  for (int seed = 1; seed <= 20; ++seed) {
    const MotionSequence drawn =
        read_text("chain = \"dissertation\"\nlength = 12\nevents = 1\nseed = " + std::to_string(seed));
    bool is_zigzag = false;
    for (std::size_t k = 0; k < 12; ++k) {
      const Pattern pattern = *drawn.segments[k].pattern;
      if (is_zigzag) REQUIRE(pattern == Pattern::zigzag);
      is_zigzag = pattern == Pattern::zigzag;
      changes = changes || (k > 0 && pattern != drawn.segments[k - 1].pattern);
    }
    has_ended = has_ended || is_zigzag;
    CHECK(drawn.origin == "dissertation");
  }
  CHECK(has_ended);
  CHECK(changes);
}

TEST_CASE("a database says before the search what it has no fall for, and no way to") {
  MotionPlan plan = sequence_plan();
  plan.database = plate_motions();
  const auto& runs = plate_motions()->runs;
  const auto some = std::ranges::find(runs, Pattern::zigzag, &MotionRun::pattern);
  REQUIRE(some != runs.end());
  for (std::size_t j = 0; j < plan.box.size(); ++j) {
    plan.box[j].lower = some->coefficients[static_cast<Eigen::Index>(j)] - 1e-4;
    plan.box[j].upper = plan.box[j].lower + 2e-4;
  }
  plan.sequence = read_text("patterns = [\"3 zigzag\"]");
  require_patterns_in_box(plan);
  plan.sequence = read_text("patterns = [\"3 autorotation\"]");
  CHECK_THROWS_WITH(
      require_patterns_in_box(plan),
      Catch::Contains("autorotation is 0 of 1 falls of the database within [box]; the nearest has C_T = "));

  // One fall that moves as no other does is an island.
  auto island = std::make_shared<MotionDatabase>(*plate_motions());
  const Eigen::Index apart = some - runs.begin();
  island->runs[static_cast<std::size_t>(apart)].pattern = Pattern::helix;
  for (Eigen::Index n = 0; n < island->segment_count(); ++n) {
    if (island->segments[static_cast<std::size_t>(n)].run != apart) continue;
    island->starts(n, 0) += 1e3;
    island->ends(n, 0) += 1e3;
  }
  plan.database = island;
  plan.sequence = read_text("patterns = [\"2 zigzag\", \"2 helix\"]", island.get());
  CHECK_THROWS_WITH(require_ways(plan),
                    Catch::Contains("helix after zigzag: from falls of that pattern no way"));
  plan.sequence = read_text("patterns = [\"2 zigzag\", \"2 autorotation\", \"zigzag\"]", island.get());
  require_ways(plan);
  // No segment is a turn backward.
  auto forward = std::make_shared<MotionDatabase>(*plate_motions());
  for (MotionSegment& segment : forward->segments) {
    if (segment.kind == EventKind::turn_minus) segment.kind = EventKind::turn_plus;
  }
  plan.database = forward;
  plan.sequence = read_text("kinds = [\"swing+\", \"swing-\", \"turn-\"]", forward.get());
  CHECK_THROWS_WITH(require_ways(plan), Catch::Contains("turn- after swing-: no segment of that kind leads"));
}

TEST_CASE("a sketch that rises as no fall does, or above the release, is refused") {
  MotionPlan plan = sequence_plan(40.0);
  plan.database = plate_motions();
  const auto timed = [](double rise, double start) {
    Eigen::MatrixX3d points(4, 3);
    points << 0, 0, start, 0, 0, 20, 0, 0, 20 + rise, 0, 0, 0;
    return Sketch(points, Eigen::Vector4d(0.0, 20.0, 21.0, 45.0));
  };
  // By the definition: plates of the database rise, if they do, by less than ten times the velocity scale.
  plan.sketch = timed(10.0, 40.0);
  CHECK_THROWS_WITH(require_rise(plan), Catch::Contains("rises by 10 in unit time from 20 on"));
  plan.sketch = timed(1e-3, 40.0);
  require_rise(plan);
  plan.database.reset();
  plan.sketch = timed(10.0, 40.0);
  require_rise(plan);
  plan.sketch = timed(30.0, 40.0);
  plan.fixed["vx(0)"] = plan.fixed["vy(0)"] = 0.0;
  CHECK_THROWS_WITH(require_rise(plan), Catch::Contains("is at height 50 at 21, above the release at 40"));
  plan.fixed["vy(0)"] = 5.0;
  require_rise(plan);
}

TEST_CASE("a steady stretch cuts what a motion is priced by, as it cuts the sequences of chains") {
  MotionPlan plan = sequence_plan();
  const std::string zigzags = path_of("alternating.json",
                                      R"({"schema": "samara-chain/1", "counts": [[0, 90, 0, 0], [90, 0, 0, 0],
          [45, 45, 0, 0], [45, 45, 0, 0]], "symbols": ["swing-", "swing+", "turn-", "turn+"]})");
  plan.sequence = read_text("chain = \"" + zigzags + "\"", nullptr);
  const PlannedFall fall(plan);
  // Swings every 5 a/U, with none of them from 15 to 35.
  RealisedFall real;
  real.times = Eigen::VectorXd::LinSpaced(3001, 0.0, 60.0);
  const auto& states = plan.model->info().states;
  real.states = Eigen::MatrixXd::Zero(real.times.size(), std::ssize(states));
  const auto column = [&](const char* name) {
    return real.states.col(std::ranges::find(states, name, &samara::models::StateInfo::name) -
                           states.begin());
  };
  for (Eigen::Index k = 0; k < real.times.size(); ++k) {
    const double t = real.times[k], phase = 0.4 * std::numbers::pi * t;
    column("vx")[k] = t > 15.0 && t < 35.0 ? 1.0 : 1.0 + 0.3 * std::sin(phase);
    column("theta")[k] = 0.5 * std::sin(0.5 * phase);
  }
  MotionResult result;
  judge_motion(fall, real, result);
  double sum = 0.0, priced = 0.0;
  int cuts = 0;
  std::vector<int> past;
  const EventList list = events_of_motion(fall, real);
  for (std::size_t k = 1; k < list.events.size(); ++k) {
    const int kind = static_cast<int>(list.events[k].kind);
    if (list.events[k].is_steady) {
      cuts += past.empty() ? 0 : 1;
      past.clear();
      continue;
    }
    sum += std::log(plan.sequence->chain->probability(past, kind));
    priced += 1.0;
    past.push_back(kind);
  }
  REQUIRE(cuts == 1);
  REQUIRE(past.size() > 1);
  CHECK(result.sequence->log_likelihood == Approx(sum / priced));
}

TEST_CASE("a plan names all files that it reads, its model and its chain as well") {
  const TemporaryDirectory folder;
  const auto model = folder.put("sinker.TOML", R"(name = "sinker"
[states]
x = { initial = 0 }
y = { initial = 0 }
theta = { initial = 0 }
vx = { initial = 0 }
vy = { initial = 0 }
w = { initial = 0 }
[parameters]
C_T = { default = 1 }
[rates]
x = "vx"
y = "vy"
theta = "w"
vx = "-C_T*vx"
vy = "-1 - C_T*vy"
w = "-C_T*w"
)");
  const auto chain = folder.put("sinker.json", R"({"schema": "samara-chain/1", "counts": [[0, 9], [9, 0]],
          "symbols": ["turn+", "swing-"]})");
  const MotionPlan plan = parse_motion_plan(
      "model = \"sinker.TOML\"\n[release]\nheight = 20\n[box]\n"
      "C_T = [0.8, 1.4]\n[sequence]\nlength = 3\nchain = \"sinker.json\"\n",
      (folder / "motion.toml").string());
  CHECK(plan.files == std::vector<std::string>{model.string(), chain.string()});
}

TEST_CASE("bodies that do not come down, and databases of others, are refused before the search") {
  const std::string leaf =
      "model = \"immersed_body\"\n[body]\na = 0.035\nb = 0.02\nc = 1e-4\ndensity = 1200\nC_D0 = 0.05\nC_w = "
      "2\n"
      "[release]\nheight = 2\ntilt = 0.2\n[landing]\nx = 0\ny = 0\n[box]\nC_T = [0.6, 1.8]\n";
  CHECK(parse_motion_plan(leaf, "motion.toml").sinks());
  const auto refuses = [&](const std::string& from, const std::string& to, const std::string& sentence) {
    std::string text = leaf;
    CHECK_THROWS_WITH(parse_motion_plan(text.replace(text.find(from), from.size(), to), "motion.toml"),
                      Catch::Contains(sentence));
  };
  refuses("density = 1200", "density = 0.5", "does not begin to sink");
  refuses("tilt = 0.2", "axis = 0.2", "which is missing");
  refuses("[landing]\nx = 0\ny = 0\n", "", "[sequence] too");
  refuses("[landing]",
          "[path]\nfile = \"" + path_of("early.csv", "t,x,y,z\n-2,0,0,2\n-1,0,0,0\n") + "\"\n[landing]",
          "ends at the time -1");
  MotionPlan plan = sequence_plan();
  plan.database = plate_motions();
  plan.fixed["inertia_ratio"] = 1.4;
  plan.sequence = read_text("length = 2");
  CHECK_THROWS_WITH(plan_motion(plan), Catch::Contains("inertia_ratio = 1.3"));
}

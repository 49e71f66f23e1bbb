// Transitions with intervals, and labels of a person beside the rule.
#include <cmath>
#include <fstream>
#include <numbers>
#include <utility>

#include <catch2/catch.hpp>

#include "known_motions.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/motion/patterns/labelled_segments.h"
#include "samara/motion/patterns/transitions.h"
#include "tests/error_text.h"
#include "tests/identification/measured_data.h"
#include "tests/io/temporary_directory.h"

using namespace samara::motion;
using samara::identification::Capture;

namespace {

Capture capture_of(const std::string& id, const MotionRecord& record) {
  Capture capture;
  capture.id = id;
  capture.times = record.times;
  for (int c = 0; c < 3; ++c)
    capture.channels.push_back({std::string(1, "xyz"[c]), "m", record.positions.col(c), {}});
  return capture;
}

std::filesystem::path written(const TemporaryDirectory& folder, const std::string& text) {
  const auto path = folder.path() / "labels.csv";
  std::ofstream(path) << text;
  return path;
}

}  // namespace

TEST_CASE("transitions are counted between neighbours that are resolved, with the intervals of a beta") {
  using P = Pattern;
  const Transitions all = transitions({{P::zigzag, P::chaotic},
                                       {P::zigzag, P::unresolved, P::chaotic, P::zigzag},
                                       {P::zigzag, P::autorotation},
                                       {P::zigzag}});
  const auto at = [](Pattern p) { return static_cast<Eigen::Index>(p); };
  CHECK(all.counts(at(P::zigzag), at(P::chaotic)) == 2);
  CHECK(all.counts(at(P::zigzag), at(P::autorotation)) == 1);
  CHECK(all.counts(at(P::chaotic), at(P::zigzag)) == 1);
  CHECK(all.counts.sum() == 4);
  // Three patterns were seen: (2 + 1/2)/(3 + 1).
  CHECK(all.probability(at(P::zigzag), at(P::chaotic)) == Approx(0.625));
  CHECK(all.probability.row(at(P::zigzag)).array().isNaN().count() == 6);
  CHECK(all.lower(at(P::zigzag), at(P::chaotic)) < 0.2);
  CHECK(all.upper(at(P::zigzag), at(P::chaotic)) > 0.9);
  // Beta(3/2, 1/2) is that of sin(a)^2 with the density sin(a)^2: 2 a - sin(2 a) is pi times its share.
  for (const auto& [bound, share] : {std::pair(all.lower, 0.025), std::pair(all.upper, 0.975)}) {
    const double angle = std::asin(std::sqrt(bound(at(P::chaotic), at(P::zigzag))));
    CHECK((2.0 * angle - std::sin(2.0 * angle)) / std::numbers::pi == Approx(share));
  }
  // Of what never changes nothing is known, and least of all that it is certain.
  CHECK(all.probability.row(at(P::autorotation)).array().isNaN().all());
  CHECK(transitions({{P::zigzag}, {P::spiral}}).upper.array().isNaN().all());
}

TEST_CASE("changes until a pattern comes are those of the chain, and unknown where one never changes") {
  using P = Pattern;
  const auto at = [](Pattern p) { return static_cast<Eigen::Index>(p); };
  const Transitions all =
      transitions({{P::zigzag, P::chaotic, P::zigzag, P::autorotation, P::chaotic, P::zigzag, P::chaotic}});
  // From either, one change and then on from the other, unless it came there: two equations.
  const double go = all.probability(at(P::zigzag), at(P::chaotic)),
               back = all.probability(at(P::chaotic), at(P::zigzag));
  CHECK(all.changes(at(P::zigzag), at(P::autorotation)) == Approx((1.0 + go) / (1.0 - go * back)));
  CHECK(all.changes(at(P::chaotic), at(P::autorotation)) == Approx((1.0 + back) / (1.0 - go * back)));
  CHECK(std::isnan(all.changes(at(P::zigzag), at(P::zigzag))));
  CHECK(transitions({{P::zigzag, P::chaotic}}).changes.array().isNaN().all());
}

TEST_CASE("a person's words are compared with the rule on the same segments") {
  const TemporaryDirectory folder;
  const std::vector<Capture> captures = {capture_of("drops/a", plate({{"inertia_ratio", 0.8}})),
                                         capture_of("drops/b", plate({{"inertia_ratio", 1.35}}))};
  const PatternClasses classes = pattern_classes({"turns=autorotation", "swings=zigzag+steady"});
  const auto segments = read_labelled_segments(
      written(folder,
              "capture,first_frame,last_frame,label\na,200,480,swings\nb,200,480,turns\nb,240,480,swings\n"),
      classes);
  const SegmentAgreement both = compare(segments, captures, classes, 2.0);
  CHECK(both.words == std::vector<std::string>{"swings", "turns", "other"});
  CHECK(both.agreement.confusion == (Eigen::Matrix3i() << 1, 1, 0, 0, 1, 0, 0, 0, 0).finished());
  CHECK(both.labels[0].pattern == Pattern::zigzag);
}

TEST_CASE("labels that do not fit the captures are refused in one sentence") {
  const TemporaryDirectory folder;
  const std::vector<Capture> captures = {capture_of("drops/a", plate({{"inertia_ratio", 0.8}}))};
  const auto refused = [&](const std::string& rows) {
    return error_text<samara::InputError>(
        [&] { read_labelled_segments(written(folder, "capture,first_frame,last_frame,label\n" + rows)); });
  };
  CHECK(refused("a,0,100,zigzga\n").find("did you mean \"zigzag\"") != std::string::npos);
  CHECK(refused("a,0,100,zigzga\n").find("labels.csv:2") != std::string::npos);
  CHECK(refused("a,9,9,zigzag\n").find("ends at frame 9, expected one after 9") != std::string::npos);
  CHECK(refused("a,0.5,9,zigzag\n").find("has the frame 0.5") != std::string::npos);
  CHECK(refused("a,0,1e300,zigzag\n").find("has the frame 1e+300") != std::string::npos);
  CHECK(refused("").find("has no segments") != std::string::npos);
  const auto unfit = [&](const LabelledSegment& segment) {
    return error_text<samara::ArgumentError>([&] { compare({segment}, captures); });
  };
  // Those of few frames, too.
  for (const int last : {5, 100}) {
    CHECK(unfit({"c", 0, last, "zigzag"}).find("labels name the capture \"c\"") == 0);
    CHECK(unfit({"a", 481 - last, 481, "zigzag"}).find("ends at frame 481, expected") != std::string::npos);
  }
  CHECK(unfit({"a", 0, 481, "zigzag"}).find("ends at frame 481, expected at most 480") != std::string::npos);
  const std::vector<Capture> twice = {captures[0], capture_of("other/a", plate({{"inertia_ratio", 1.35}}))};
  CHECK(error_text<samara::ArgumentError>([&] {
          compare({{"a", 0, 100, "zigzag"}}, twice);
        }).find("which may be \"drops/a\" or \"other/a\"") != std::string::npos);
  CHECK(compare({{"other/a", 0, 480, "zigzag"}}, twice).labels.size() == 1);
  std::vector<Capture> namesakes = {twice[0], twice[0]};
  namesakes[0].file = "first.csv", namesakes[1].file = "second.csv";
  CHECK(error_text<samara::ArgumentError>([&] {
          compare({{"drops/a", 0, 100, "zigzag"}}, namesakes);
        }).find("which 2 captures are called (first.csv, second.csv)") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([] { pattern_classes({"1:zigzag"}); }).find("WORD=PATTERN") !=
        std::string::npos);
  const std::string both = "the pattern zigzag is given to \"a\" and to \"b\", expected one word";
  CHECK(error_text<samara::ArgumentError>([] { pattern_classes({"b=zigzag", "a=steady+zigzag"}); }) == both);
  CHECK(error_text<samara::ArgumentError>([&] {
          compare({}, captures, {{"a", {Pattern::zigzag}}, {"b", {Pattern::zigzag}}});
        }) == both);
  std::vector<Capture> many(9, captures[0]);
  for (std::size_t k = 0; k < many.size(); ++k) many[k].id = std::string(5, static_cast<char>('p' + k));
  CHECK(error_text<samara::ArgumentError>([&] {
          compare({{"xxxxy", 0, 100, "zigzag"}}, many);
        }).find("did you mean \"xxxxx\"") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([&] {
          compare({{"far", 0, 100, "zigzag"}}, many);
        }).ends_with("known: ppppp, qqqqq, rrrrr, sssss, ttttt, uuuuu"));
}

TEST_CASE("on measured drops of paper the rule agrees with a person beyond chance") {
  const auto folder = measured_data("falling-paper-cambridge");
  if (folder.empty()) return;
  const TemporaryDirectory sidecars;
  std::vector<Capture> captures;
  for (const std::string shape : {"circle", "square", "hexagon", "cross"}) {
    const auto sidecar = sidecars.path() / (shape + ".toml");
    std::ofstream(sidecar)
        << "group_by = [\"traj\"]\nstart = \"as given\"\n[columns]\nt_s = { quantity = \"t\", unit = "
           "\"s\" }\nx_m = { quantity = \"x\", unit = \"m\" }\ny_m = { quantity = \"y\", unit = "
           "\"m\" }\nz_m = { quantity = \"z\", unit = \"m\" }\n";
    for (Capture& capture : samara::identification::read_captures(folder / (shape + ".csv"), sidecar))
      captures.push_back(std::move(capture));
  }
  CHECK(captures.size() == 223);
  // 1 tumbling, 2 chaotic, 3 steady or periodic.
  const PatternClasses classes =
      pattern_classes({"1=autorotation", "2=chaotic+mixed", "3=steady+zigzag+spiral+helix"});
  const auto segments = read_labelled_segments(folder / "human_labels.csv", classes);
  REQUIRE(segments.size() == 251);
  const SegmentAgreement both = compare(segments, captures, classes, 0.06);
  INFO(both.agreement.confusion);
  CHECK(both.agreement.kappa > 0.3);
}

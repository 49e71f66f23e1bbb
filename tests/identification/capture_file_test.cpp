#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "files.h"

using namespace samara::identification;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("a canonical table is one capture, in SI units, named after its file") {
  const TemporaryDirectory files;
  const auto path = files.put("glide.csv",
                              "# body: card\n"
                              "t[ms],x[cm],theta [deg]\n"
                              "0,0,90\n"
                              "10,2.5,\n"
                              "20,5,45\n");
  const auto captures = read_captures(path);
  REQUIRE(captures.size() == 1);
  const Capture& capture = captures[0];
  CHECK(capture.id == "glide");
  CHECK(capture.file == path.string());
  CHECK(capture.labels.empty());
  CHECK(capture.times == Eigen::Vector3d(0.0, 0.01, 0.02));
  CHECK(capture.channel("x").unit == "m");
  CHECK(capture.channel("x").values == Eigen::Vector3d(0.0, 0.025, 0.05));
  CHECK_FALSE(capture.channel("x").metres_per_pixel);
  CHECK(capture.channel("theta").unit == "1");
  CHECK_THAT(capture.channel("theta").values[0], WithinRel(std::numbers::pi / 2.0, 1e-15));
  CHECK(std::isnan(capture.channel("theta").values[1]));
}

TEST_CASE("cells with NaN or NA are missing values, and a note counts those of each capture") {
  const TemporaryDirectory files;
  files.put("a.csv",
            "drop,t[s],x[m],y[m]\n1,0,0,0\n1,1,nan,NaN\n1,2,2,\n1,3,3,NA\n2,0,0,0\n2,1,1,\n2,2,2,2\n");
  const auto captures = read_captures(files.put("a.toml", "file = \"a.csv\"\ngroup_by = [\"drop\"]\n"));
  REQUIRE(captures.size() == 2);
  CHECK(std::isnan(captures[0].channel("x").values[1]));
  CHECK(captures[0].channel("y").values.array().isNaN().count() == 3);
  CHECK(captures[0].notes == std::vector<std::string>{"3 cells with NaN or NA count as not seen"});
  CHECK(captures[1].notes.empty());
}

TEST_CASE("a capture that stands twice is found by whatever names of its file") {
  const TemporaryDirectory files;
  const std::string table = "t[s],x[m]\n0,0\n1,\n2,5\n3,9\n";
  const auto fall = files.put("fall.csv", table);
  const auto spelled = files.path() / "." / "fall.csv";
  const auto symbolic = files / "symbolic.csv", hard = files / "hard.csv";
  std::filesystem::create_symlink(fall, symbolic);
  std::filesystem::create_hard_link(fall, hard);
  const auto error = [](const std::vector<std::filesystem::path>& paths) {
    std::vector<Capture> captures;
    for (const auto& path : paths)
      for (const Capture& capture : read_captures(path)) captures.push_back(capture);
    return error_of<samara::InputError>([&] { refuse_repeated(captures, "given"); });
  };
  CHECK(error({fall, fall}) == "fall.csv: capture \"fall\" is given twice; each once was expected");
  CHECK(error({fall, spelled})
            .starts_with("./fall.csv: capture \"fall\" is given twice, before as \"fall\" of "));
  CHECK(error({fall, symbolic})
            .starts_with("symbolic.csv: capture \"symbolic\" is given twice, before as \"fall\" of "));
  CHECK(error({hard, fall}).ends_with("/hard.csv, the same file; each once was expected"));
  // A copy is another measurement, as far as anybody can tell; so are other columns by another name of a file.
  CHECK(error({fall, files.put("copy.csv", table)}) == "no exception");
  files.put("hard.toml",
            "[columns]\n\"t[s]\" = { quantity = \"t\", unit = \"s\" }\n\"x[m]\" = { quantity = \"y\", unit = "
            "\"m\" }\n");
  CHECK(error({fall, hard}) == "no exception");
  // Those in memory are of no file.
  const std::vector<Capture> in_memory(2);
  CHECK_NOTHROW(refuse_repeated(in_memory, "given"));
}

TEST_CASE("tabs separate as well as commas") {
  const TemporaryDirectory files;
  const auto captures = read_captures(files.put("a.tsv", "t[s]\tz[m]\n0\t1\n1\t2\n2\t3\n"));
  REQUIRE(captures.size() == 1);
  CHECK(captures[0].channel("z").values == Eigen::Vector3d(1.0, 2.0, 3.0));
}

TEST_CASE("a capture starts at the first frame in which everything is visible, and counts time from there") {
  const TemporaryDirectory files;
  const std::string table = "t[s],x[m],z[m]\n7,,\n8,1,\n9,2,20\n10,,\n11,4,\n12,5,50\n";
  const auto path = files.put("a.csv", table);
  const Capture capture = read_captures(path).front();
  CHECK(capture.times == Eigen::Vector4d(0.0, 1.0, 2.0, 3.0));
  CHECK(capture.channel("x").values[0] == 2.0);
  CHECK(std::isnan(capture.channel("z").values[2]));

  SECTION("unless the sidecar wants times as given") {
    const auto sidecar = files.put("raw.toml", "file = \"a.csv\"\nstart = \"as given\"\n");
    const Capture raw = read_captures(sidecar).front();
    CHECK(raw.frame_count() == 6);
    CHECK(raw.times[0] == 7.0);
    CHECK(std::isnan(raw.channel("x").values[0]));
  }
}

namespace {

const char* const kTracks =
    "drop;cam;frame;y_px\n"
    "a;1;0;\n"
    "a;1;1;100\n"
    "a;2;0;200\n"
    "a;1;2;150\n"
    "a;2;1;210\n"
    "a;1;3;300\n"
    "a;1;4;290\n"
    "a;2;2;240\n"
    "b;1;0;10\n"
    "b;1;1;20\n"
    "b;1;2;30\n";

const char* const kSidecar =
    "file = \"tracks.csv\"\n"
    "delimiter = \";\"\n"
    "group_by = [\"drop\", \"cam\"]\n"
    "frame_rate = \"50 Hz\"\n"
    "[columns]\n"
    "frame = { quantity = \"t\", unit = \"frame\" }\n"
    "y_px = { quantity = \"x\", unit = \"px\" }\n";

}  // namespace

TEST_CASE("a sidecar groups the rows of one file into captures, wherever they stand") {
  const TemporaryDirectory files;
  files.put("tracks.csv", kTracks);
  const auto captures = read_captures(files.put("tracks.toml", kSidecar));
  REQUIRE(captures.size() == 3);
  CHECK(captures[0].id == "a/1");
  CHECK(captures[1].id == "a/2");
  CHECK(captures[2].id == "b/1");
  CHECK(captures[0].labels == std::map<std::string, std::string>{{"cam", "1"}, {"drop", "a"}});
  CHECK(captures[0].times.isApprox(Eigen::Vector4d(0.0, 0.02, 0.04, 0.06)));
  CHECK(captures[0].channel("x").unit == "px");
  CHECK(captures[1].channel("x").values == Eigen::Vector3d(200.0, 210.0, 240.0));
}

TEST_CASE("a scale takes each track from pixels to metres by its own span") {
  const TemporaryDirectory files;
  files.put("tracks.csv", kTracks);
  const std::string scale = "[scale]\nx = { length = \"40 cm\", over = \"largest - first\" }\n";
  const auto captures = read_captures(files.put("tracks.toml", std::string(kSidecar) + scale));
  // Spans of 200, 40 and 20 px for 0.4 m.
  CHECK_THAT(*captures[0].channel("x").metres_per_pixel, WithinRel(2e-3, 1e-14));
  CHECK_THAT(*captures[1].channel("x").metres_per_pixel, WithinRel(1e-2, 1e-14));
  CHECK_THAT(*captures[2].channel("x").metres_per_pixel, WithinRel(2e-2, 1e-14));
  CHECK(captures[0].channel("x").unit == "m");
  CHECK_THAT(captures[0].channel("x").values[2], WithinRel(0.6, 1e-14));
}

TEST_CASE("a scale may be given as a value, negative where pixels count against the axis") {
  const TemporaryDirectory files;
  files.put("tracks.csv", kTracks);
  const std::string scale = "[scale]\nx = { value = \"-0.5 mm/px\" }\n";
  const auto captures = read_captures(files.put("tracks.toml", std::string(kSidecar) + scale));
  CHECK_THAT(captures[2].channel("x").values[0], WithinRel(-5e-3, 1e-14));
}

TEST_CASE("a span may go from the smallest value") {
  const TemporaryDirectory files;
  files.put("dip.csv", "t[s],x[px]\n0,20\n1,10\n2,60\n");
  const auto path = files.put(
      "dip.toml", "file = \"dip.csv\"\n[scale]\nx = { length = \"1 m\", over = \"largest - smallest\" }\n");
  CHECK_THAT(*read_captures(path)[0].channel("x").metres_per_pixel, WithinRel(0.02, 1e-14));
}

TEST_CASE("`where` keeps the rows with the allowed cells") {
  const TemporaryDirectory files;
  files.put("tracks.csv", kTracks);
  const std::string text = kSidecar;
  const std::string head = text.substr(0, text.find("[columns]"));
  const std::string columns = text.substr(text.find("[columns]"));
  const auto listed = read_captures(files.put("one.toml", head + "where = { cam = [\"2\"] }\n" + columns));
  REQUIRE(listed.size() == 1);
  CHECK(listed[0].id == "a/2");
  const auto plain = read_captures(files.put("two.toml", head + "where = { drop = \"a\" }\n" + columns));
  CHECK(plain.size() == 2);
}

TEST_CASE("a table is read through the sidecar of the same stem beside it") {
  const TemporaryDirectory files;
  const auto table = files.put("tracks.csv", kTracks);
  files.put("tracks.toml", kSidecar);
  CHECK(read_captures(table).size() == 3);

  SECTION("which need not name it") {
    const std::string text = kSidecar;
    files.put("tracks.toml", text.substr(text.find('\n') + 1));
    CHECK(read_captures(table).size() == 3);
  }
}

TEST_CASE("a sidecar may leave the columns to a canonical header, labels without units included") {
  const TemporaryDirectory files;
  files.put("a.csv", "run,t[s],x[m]\n1,0,0\n1,1,1\n1,2,2\n2,0,5\n2,1,6\n2,2,7\n");
  const auto captures = read_captures(files.put("a.toml", "file = \"a.csv\"\ngroup_by = [\"run\"]\n"));
  REQUIRE(captures.size() == 2);
  CHECK(captures[1].channel("x").values[0] == 5.0);
}

TEST_CASE("the sidecar of many tables is of the tables among captures, and of no other sidecar") {
  const TemporaryDirectory files;
  const auto table = files.put("a.csv", "s,x\n0,0\n1,1\n2,2\n");
  const std::string columns =
      "[columns]\ns = { quantity = \"t\", unit = \"s\" }\nx = { quantity = \"x\", unit = ";
  const auto shared = files.put("shared.toml", columns + "\"m\" }\n");
  const auto own = files.put("own.toml", "file = \"a.csv\"\n" + columns + "\"cm\" }\n");
  CHECK(read_captures(table, shared)[0].channel("x").values[2] == 2.0);
  CHECK(read_captures(own, shared)[0].channel("x").values[2] == 0.02);
  CHECK(capture_files(own, shared) == capture_files(own));
  CHECK(std::ranges::count(capture_files(table, shared), shared) == 1);
}

TEST_CASE("frame rates are read with and without a unit") {
  const TemporaryDirectory files;
  files.put("a.csv", "t[frame],x[m]\n10,0\n11,1\n12,2\n");
  for (const char* rate : {"25", "\"25 Hz\"", "\"25 1/s\"", "\"25 frame/s\""}) {
    const auto path = files.put("a.toml", std::string("file = \"a.csv\"\nframe_rate = ") + rate + "\n");
    CHECK_THAT(read_captures(path)[0].times[2], WithinAbs(0.08, 1e-15));
  }
}

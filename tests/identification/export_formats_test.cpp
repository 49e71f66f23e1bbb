#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "files.h"

using namespace samara::identification;
using Catch::Matchers::WithinAbs;
using Eigen::Vector3d;

namespace {

std::vector<std::string> quantities(const Capture& capture) {
  std::vector<std::string> names;
  for (const Channel& channel : capture.channels) names.push_back(channel.quantity);
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("a Tracker export is a capture in the unit that the sidecar names") {
  const TemporaryDirectory files;
  files.put("drop.txt",
            "mass_A\n"
            "t\tx\ty\tv_{x}\n"
            "0.000000000E0\t1.245986911E1\t-1.5\t\n"
            "3.2E-2\t1.1E1\t-1.25\t20\n"
            "6.4E-2\t\t-1.0\t30\t\n"
            "9.6E-2\t1.0E1\t-0.5\t\n"
            "\n");
  const auto captures = read_captures(files.put("drop.toml", "file = \"drop.txt\"\nlength_unit = \"cm\"\n"));
  REQUIRE(captures.size() == 1);
  const Capture& drop = captures[0];
  CHECK(drop.id == "drop");
  CHECK(drop.labels.at("body") == "mass_A");
  CHECK(quantities(drop) == Names{"x", "y", "vx"});
  CHECK(drop.channel("x").unit == "m");
  // The first frame in which all is seen is the second.
  CHECK(drop.times.isApprox(Vector3d(0.0, 0.032, 0.064)));
  CHECK(drop.channel("y").values.isApprox(Vector3d(-0.0125, -0.01, -0.005)));
  CHECK(std::isnan(drop.channel("x").values[1]));
  CHECK(drop.channel("vx").values[0] == 0.2);

  CHECK(reading_error(files.put("bare.txt", "mass_A\nt\tx\n0\t1\n")) ==
        "bare.txt:2: a Tracker export names no units; a sidecar with length_unit = \"m\" (or another) was "
        "expected");
}

TEST_CASE("decimal commas of a Tracker export are understood, and errors name its own lines") {
  const TemporaryDirectory files;
  const std::string sidecar = "file = \"ball.csv\"\nlength_unit = \"m\"\n";
  files.put("ball.csv", "Ball 1;;\nt;x;y\n0,0;1,5;-2,5E-1\n0,1;2,5;0\n0,2;3,5;0\n");
  const auto path = files.put("ball.toml", sidecar);
  CHECK(read_captures(path).front().channel("x").values.isApprox(Vector3d(1.5, 2.5, 3.5)));
  CHECK(read_captures(path).front().channel("y").values[0] == -0.25);
  files.put("ball.csv", "Ball 1;;\nt;x;y\n0;1;2\n0.1;wrong;2\n");
  CHECK(reading_error(path) == "ball.csv:4: column \"x\": expected a number, found \"wrong\"");
}

TEST_CASE("a Tracker export of several masses is a capture for each") {
  const TemporaryDirectory files;
  files.put("two.txt",
            "#multi:\n"
            "\tcm A\t\tcm B\t\t\n"
            "t\tx\ty\tx\ty\t\n"
            "0.00\t1\t2\t3\t4\t\n"
            "0.04\t1.5\t2.5\t3.5\t4.5\t\n"
            "0.08\t2\t3\t4\t5\t\n");
  const auto captures = read_captures(files.put("two.toml", "file = \"two.txt\"\nlength_unit = \"m\"\n"));
  REQUIRE(captures.size() == 2);
  CHECK(captures[0].id == "two/cm A");
  CHECK(captures[1].id == "two/cm B");
  CHECK(captures[1].labels.at("body") == "cm B");
  CHECK(quantities(captures[1]) == Names{"x", "y"});
  CHECK(captures[0].channel("y").values == Vector3d(2.0, 2.5, 3.0));
  CHECK(captures[1].channel("x").values == Vector3d(3.0, 3.5, 4.0));
}

namespace {

/// A body at (1, 2, 3) m, y up, turned by 90 degrees about the vertical, that moves up; one marker beside it.
std::string motive_export(const std::string& row_names, const std::string& extra_rows) {
  return "Format Version,1.23,Take Name,card 3,Capture Frame Rate,240.000000,Export Frame Rate,240.000000,"
         "Rotation Type,Quaternion,Length Units,Millimeters,Coordinate Space,Global\n"
         "\n"
         "," +
         (row_names.empty() ? "" : std::string("Type")) +
         ",Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid "
         "Body,Marker,Marker,"
         "Marker\n," +
         (row_names.empty() ? "" : std::string("Name")) +
         ",\"card, red\",\"card, red\",\"card, red\",\"card, red\",\"card, red\",\"card, red\",\"card, red\","
         "\"card, red\",M:1,M:1,M:1\n" +
         extra_rows +
         ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker "
         "Error,Position,Position,"
         "Position\n"
         "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z\n"
         "0,0.000000,0,0.70710678,0,0.70710678,1000,2000,3000,0.1,1,2,3\n"
         "1,0.004167,0,0.70710678,0,0.70710678,1000,2001,3000,0.1,1,2,3\n"
         "2,0.008333,,,,,,,,,1,2,3\n"
         "3,0.012500,0,0.70710678,0,0.70710678,1000,2004,3000,0.1,,,\n";
}

}  // namespace

TEST_CASE("a rigid body of a Motive export has a pose named like the states of a model, z up") {
  const TemporaryDirectory files;
  const bool is_new = GENERATE(false, true);
  const std::string extra = is_new ? ",ID,7,7,7,7,7,7,7,7,8,8,8\n,Parent,,,,,,,,,,,\n" : "";
  const auto captures = read_captures(files.put("take.csv", motive_export(is_new ? "yes" : "", extra)));
  REQUIRE(captures.size() == 1);
  const Capture& card = captures[0];
  CHECK(card.id == "take");
  CHECK(card.labels.at("body") == "card, red");
  CHECK(card.frame_count() == 4);
  CHECK(std::isnan(card.channel("x").values[2]));
  CHECK_THAT(card.channel("x").values[3], WithinAbs(1.0, 1e-12));
  CHECK_THAT(card.channel("y").values[3], WithinAbs(-3.0, 1e-12));
  CHECK_THAT(card.channel("z").values[3], WithinAbs(2.004, 1e-12));
  CHECK(card.channel("qw").unit == "1");
  // The body's own axes stay: its y, which pointed up, still does. R takes (0, 1, 0) to (0, 0, 1).
  const double w = card.channel("qw").values[0];
  const double x = card.channel("qx").values[0];
  const double y = card.channel("qy").values[0];
  const double z = card.channel("qz").values[0];
  CHECK_THAT(2.0 * (y * z + w * x), WithinAbs(1.0, 1e-7));
  CHECK_THAT(w * w + x * x + y * y + z * z, WithinAbs(1.0, 1e-7));
  REQUIRE(card.notes.size() == 1);
  CHECK(card.notes[0] == "Motive's axis y was taken to point up, and became z");
}

TEST_CASE("a sidecar decides what a Motive export leaves open") {
  const TemporaryDirectory files;
  files.put("take.csv", motive_export("", ""));
  SECTION("which axis is up") {
    const Capture card = read_captures(files.put("take.toml", "up = \"z\"\nfile = \"take.csv\"\n")).front();
    CHECK(card.channel("y").values[0] == 2.0);
    CHECK_THAT(card.channel("qy").values[0], WithinAbs(std::sqrt(0.5), 1e-8));
    CHECK(card.notes.empty());
  }
  SECTION("which columns") {
    const Capture marker =
        read_captures(files.put("m.toml",
                                "file = \"take.csv\"\nup = \"z\"\n[columns]\n"
                                "\"Time (Seconds)\" = { quantity = \"t\", unit = \"s\" }\n"
                                "\"M:1.Position.X\" = { quantity = \"x\", unit = \"mm\" }\n"))
            .front();
    CHECK(quantities(marker) == Names{"x"});
    CHECK(marker.channel("x").values[2] == 0.001);
  }
}

TEST_CASE("markers are captures where a Motive export has no rigid body") {
  const TemporaryDirectory files;
  const auto captures = read_captures(files.put(
      "take.csv",
      "Format Version,1.24,Take Name,t,Length Units,Centimeters\n\n"
      ",Type,,Marker,Marker,Marker,Marker,Marker,Marker\n"
      ",Name,,Unlabeled 9,Unlabeled 9,Unlabeled 9,Unlabeled 9,Unlabeled 9,Unlabeled 9\n"
      ",,,Position,Position,Position,Position,Position,Position\n"
      "Frame,Time (Seconds),TimeCode,X,Y,Z,X,Y,Z\n"
      "0,0.00,15:26:46:12,1,2,3,4,5,6\n0,0.01,15:26:46:13,1,2,3,4,5,6\n0,0.02,15:26:46:14,1,2,3,4,5,6\n"));
  REQUIRE(captures.size() == 2);
  CHECK(captures[0].channel("z").values[0] == 0.02);
  CHECK(captures[1].channel("x").values[0] == 0.04);
}

TEST_CASE("a Motive export that cannot be read says why") {
  const TemporaryDirectory files;
  const auto error = [&](const std::string& text) { return reading_error(files.put("a.csv", text)); };
  CHECK(error("Format Version,1.23,Length Units,Meters\n1,2\n") ==
        "a.csv: a Motive export without its header \"Frame,Time (Seconds),...\"");
  CHECK(error("Format Version,1.23\n,,Marker\n,,M\n,,Position\nFrame,Time (Seconds),X\n0,0,1\n") ==
        "a.csv:1: a Motive export without \"Length Units\"; a sidecar with length_unit was expected");
  CHECK(
      error(
          "Format Version,1.23,Length Units,Furlongs\n,,Marker\n,,M\n,,Position\nFrame,Time (Seconds),X\n") ==
      "a.csv:1: lengths are in \"Furlongs\"; Meters, Centimeters or Millimeters were expected");
  CHECK(error("Format Version,1.23,Rotation Type,XYZ,Length Units,Meters\n,,Rigid Body\n,,b\n,,Rotation\n"
              "Frame,Time (Seconds),X\n0,0,1\n") ==
        "a.csv:1: rotations are of the type \"XYZ\"; export them as Quaternion");
}

TEST_CASE("rows of an export that are too short are counted, and told of") {
  const TemporaryDirectory files;
  files.put("drop.txt", "mass_A\nt,x,y\n0,1,2\n0.1,1.1,\n0.2,1.2\n0.3\n0.4,1.5,2\n0.5,1.6,2\n");
  const Capture drop =
      read_captures(files.put("drop.toml", "file = \"drop.txt\"\nlength_unit = \"m\"\n")).front();
  CHECK(drop.notes.back() ==
        "2 of 6 rows of the export are shorter than its header; what they lack counts as not seen");
}

TEST_CASE("a Kinovea table is a capture for each point, with decimal commas or points") {
  const TemporaryDirectory files;
  const std::string sidecar = "file = \"kinovea.csv\"\nlength_unit = \"cm\"\ntime_unit = \"ms\"\n";
  const auto path = files.put("kinovea.toml", sidecar);
  files.put("kinovea.csv",
            "\"Time\";\"ball/0/X\";\"ball/0/Y\";\"arm/a/X\";\"arm/a/Y\"\n"
            "\"0\";\"1,5\";\"10\";;\n"
            "\"40\";\"2,5\";\"9,5\";\"7\";\"8\"\n"
            "\"80\";\"3,5\";\"9\";\"7,25\";\"8,5\"\n"
            "\"120\";;;\"7,5\";\"9\"\n");
  const auto captures = read_captures(path);
  REQUIRE(captures.size() == 2);
  CHECK(captures[0].id == "kinovea/ball");
  CHECK(captures[0].labels.at("body") == "ball");
  CHECK(captures[1].id == "kinovea/arm/a");
  CHECK(captures[0].times[1] == Approx(0.04));
  CHECK(captures[0].channel("x").values[2] == Approx(0.035));
  CHECK(captures[0].channel("y").values[1] == Approx(0.095));
  // Its first frame is the second of the table.
  CHECK(captures[1].times.isApprox(Vector3d(0.0, 0.04, 0.08)));
  CHECK(captures[1].channel("y").values[2] == Approx(0.09));

  files.put("kinovea.csv", "Time,ball/0/X,ball/0/Y\n0,1.5,10\n40,2.5,9.5\n80,wrong,9\n");
  CHECK(reading_error(path) == "kinovea.csv:4: column \"ball/0/X\": expected a number, found \"wrong\"");
  files.put("kinovea.toml", "file = \"kinovea.csv\"\nlength_unit = \"cm\"\n");
  CHECK(reading_error(path) ==
        "kinovea.csv:1: a Kinovea export names no units; a sidecar with length_unit = \"m\" (or another) and "
        "time_unit = \"s\" (or \"ms\") was expected");
}

TEST_CASE("Kinovea's text for gnuplot is a capture for each track, by its name or number") {
  const TemporaryDirectory files;
  const auto path =
      files.put("tracks.toml",
                "file = \"tracks.txt\"\nlength_unit = \"px\"\ntime_unit = \"ms\"\n[scale]\nx = { value = \"1 "
                "mm/px\" }\n");
  files.put(
      "tracks.txt",
      "#Kinovea Trajectory data export\n#T X Y\n\n# ball\n0 866.00 320.00\n20 847,5 321.00\n40 830 322\n\n"
      "# ball\n0 1 2\n20 3 4\n40 5 6\n60 7 8\n\n");
  const auto captures = read_captures(path);
  REQUIRE(captures.size() == 2);
  CHECK(captures[0].id == "tracks/ball");
  CHECK(captures[1].id == "tracks/ball (2)");
  CHECK(captures[0].times[2] == Approx(0.04));
  CHECK(captures[0].channel("x").values[1] == Approx(0.8475));
  CHECK(captures[0].channel("y").unit == "px");
  CHECK(captures[1].times.size() == 4);
  CHECK(captures[1].channel("y").values[3] == 8.0);

  // Earlier versions: timecodes, which need no unit, and no names.
  files.put("tracks.toml", "file = \"tracks.txt\"\nlength_unit = \"m\"\n");
  files.put("tracks.txt",
            "#Kinovea Trajectory data export\n#T X Y\n0:00:00:00 1 2 \n0:00:01:50 2 3 \n1:01:00:03 3 4 \n\n");
  const auto coded = read_captures(path);
  REQUIRE(coded.size() == 1);
  CHECK(coded[0].labels.at("body") == "track 1");
  CHECK(coded[0].times.isApprox(Vector3d(0.0, 1.5, 3660.03)));
  files.put("tracks.toml", "file = \"tracks.txt\"\nlength_unit = \"m\"\ntime_unit = \"ms\"\n");
  CHECK(reading_error(path) ==
        "tracks.txt:3: the times are timecodes, which need no time_unit; none was expected");
  files.put("tracks.toml", "file = \"tracks.txt\"\nlength_unit = \"m\"\n");

  // Films of 100 frames a second and more: thousandths.
  files.put("tracks.txt",
            "#Kinovea Trajectory data export\n#T X Y\n0:00:00:000 1 2\n0:00:00:005 2 3\n0:00:00:400 3 4\n");
  CHECK(read_captures(path).front().times.isApprox(Vector3d(0.0, 0.005, 0.4)));
  for (const std::string part : {"4", "4000"}) {
    files.put("tracks.txt", "#Kinovea Trajectory data export\n#T X Y\n0:00:00:" + part + " 1 2\n");
    CHECK(reading_error(path) == "tracks.txt:3: the time \"0:00:00:" + part +
                                     "\" is no timecode: h:mm:ss: and two digits (hundredths) or three "
                                     "(thousandths) were expected");
  }

  files.put("tracks.txt", "#Kinovea Trajectory data export\n#T X Y\n0:00:00:00 1 2\n0.5 2 3\n");
  CHECK(reading_error(path) == "tracks.txt:4: the time \"0.5\" is no timecode as the first one is");
  files.put("tracks.txt", "#Kinovea Trajectory data export\n#T X Y\n0:00:00:00 1\n");
  CHECK(reading_error(path) == "tracks.txt:3: 2 numbers stand there, expected time, x and y");
  files.put("tracks.txt", "#Kinovea Trajectory data export\n#T X Y\n");
  CHECK_THAT(reading_error(path), Catch::Contains("without a track"));
}

TEST_CASE("a track of Kinovea may have a name that looks like a comparison") {
  const TemporaryDirectory files;
  const auto path =
      files.put("tracks.toml", "file = \"tracks.txt\"\nlength_unit = \"m\"\ntime_unit = \"ms\"\n");
  files.put("tracks.txt", "#Kinovea Trajectory data export\n#T X Y\n\n# <ball\n0 1 2\n20 3 4\n40 5 6\n\n");
  const auto captures = read_captures(path);
  REQUIRE(captures.size() == 1);
  CHECK(captures[0].labels.at("body") == "<ball");
  CHECK(captures[0].times.size() == 3);
}

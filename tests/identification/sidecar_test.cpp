#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "files.h"

using namespace samara::identification;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

Quaterniond attitude(const Capture& capture, Eigen::Index frame) {
  return {capture.channel("qw").values[frame], capture.channel("qx").values[frame],
          capture.channel("qy").values[frame], capture.channel("qz").values[frame]};
}

}  // namespace

TEST_CASE("Euler angles become a quaternion, and the world turns z up") {
  // Roll, pitch, yaw of a craft in axes forward, right, down.
  const TemporaryDirectory files;
  files.put("pose.csv",
            "p1,p2,p3,roll,pitch,yaw\n"
            "1,2,-3,10,20,30\n"
            "1,2,-3,10,20,179\n"
            "1,2,-3,10,20,-178\n");
  const std::string text =
      "file = \"pose.csv\"\nframe_rate = \"60 Hz\"\n"
      "[columns]\n"
      "p1 = { quantity = \"x\", unit = \"m\" }\n"
      "p2 = { quantity = \"y\", unit = \"m\" }\n"
      "p3 = { quantity = \"z\", unit = \"m\" }\n"
      "[attitude]\neuler = [\"yaw\", \"pitch\", \"roll\"]\norder = \"zyx\"\nunit = \"deg\"\n";
  const double deg = std::numbers::pi / 180.0;
  const auto truth = [&](double yaw) {
    return Eigen::AngleAxisd(yaw * deg, Vector3d::UnitZ()) *
           Eigen::AngleAxisd(20.0 * deg, Vector3d::UnitY()) *
           Eigen::AngleAxisd(10.0 * deg, Vector3d::UnitX());
  };
  const Capture as_given = read_captures(files.put("a.toml", text)).front();
  CHECK(as_given.times.isApprox(Vector3d(0.0, 1.0 / 60.0, 2.0 / 60.0)));
  CHECK(as_given.channels.size() == 7);
  CHECK((attitude(as_given, 0).toRotationMatrix() - truth(30.0).toRotationMatrix()).norm() < 1e-14);
  CHECK((attitude(as_given, 2).toRotationMatrix() - truth(-178.0).toRotationMatrix()).norm() < 1e-14);
  // From 179 to -178 degrees the quaternion goes on, though its angles jump.
  CHECK(attitude(as_given, 1).dot(attitude(as_given, 2)) > 0.99);

  const Capture upright = read_captures(files.put("b.toml", "up = \"-z\"\n" + text)).front();
  CHECK(upright.channel("x").values[0] == 1.0);
  CHECK(upright.channel("y").values[0] == -2.0);
  CHECK(upright.channel("z").values[0] == 3.0);
  const Eigen::Matrix3d turn = Vector3d(1.0, -1.0, -1.0).asDiagonal();
  CHECK((attitude(upright, 0).toRotationMatrix() - turn * truth(30.0).toRotationMatrix()).norm() < 1e-14);
}

TEST_CASE("every axis can be up") {
  const TemporaryDirectory files;
  files.put("p.csv", "t[s],x[m],y[m],z[m]\n0,1,2,3\n1,1,,3\n2,1,2,3\n");
  const auto turned = [&](const std::string& up) -> Vector3d {
    const Capture c = read_captures(files.put("p.toml", "file = \"p.csv\"\nup = \"" + up + "\"\n")).front();
    CHECK(std::isnan(c.channel("x").values[1]) + std::isnan(c.channel("y").values[1]) +
              std::isnan(c.channel("z").values[1]) ==
          1);
    return {c.channel("x").values[0], c.channel("y").values[0], c.channel("z").values[0]};
  };
  CHECK(turned("z") == Vector3d(1.0, 2.0, 3.0));
  CHECK(turned("y") == Vector3d(1.0, -3.0, 2.0));
  CHECK(turned("x") == Vector3d(-3.0, 2.0, 1.0));
  CHECK(turned("-z") == Vector3d(1.0, -2.0, -3.0));
  CHECK(turned("-y") == Vector3d(1.0, 3.0, -2.0));
  CHECK(turned("-x") == Vector3d(3.0, 2.0, -1.0));
  files.put("p.csv", "t[s],x[m],z[m]\n0,1,3\n1,1,3\n2,1,3\n");
  CHECK(reading_error(files.put("p.toml", "file = \"p.csv\"\nup = \"y\"\n")) ==
        "p.toml:2: up: capture \"p\" measures some of x, y, z; all or none were expected to turn them");
}

TEST_CASE("many files without a header, with labels from an index") {
  const TemporaryDirectory files;
  files.put("002.csv", "0.000;1\n0.007;2\n0.007;9\n0.014;3\n0.021;4\n");
  files.put("010.csv", "0.000;5\n0.007;6\n0.014;7\n");
  files.put("index.tsv", "flight\tspin\n2\t150\n11\t90\n");
  const auto captures = read_captures(files.put("flights.toml",
                                                "file = \"0*.csv\"\nheader = [\"time\", \"height\"]\n"
                                                "repeated_times = \"keep first\"\n"
                                                "[columns]\n"
                                                "time = { quantity = \"t\", unit = \"s\" }\n"
                                                "height = { quantity = \"z\", unit = \"m\" }\n"
                                                "[labels]\nfile = \"index.tsv\"\ncolumn = \"flight\"\n"));
  REQUIRE(captures.size() == 2);
  CHECK(captures[0].id == "002");
  CHECK(captures[0].channel("z").values == Vector4d(1.0, 2.0, 3.0, 4.0));
  CHECK(captures[0].labels.at("spin") == "150");
  REQUIRE(captures[0].notes.size() == 1);
  CHECK(captures[0].notes[0] == "1 frames dropped whose time is that of the frame before");
  CHECK(captures[1].labels.empty());
  CHECK_THAT(captures[1].notes.at(0), Catch::EndsWith("index.tsv\" has no row for it"));
  CHECK(reading_error(files.put("none.toml", "file = \"1*.csv\"\n")) ==
        "none.toml:1: file: no file matches \"" + (files.path() / "1*.csv").string() + "\"");
}

TEST_CASE("a capture is read from a time until a time") {
  const TemporaryDirectory files;
  files.put("a.csv", "t[s],x[m]\n1,10\n2,20\n3,30\n4,40\n5,50\n6,60\n");
  const Capture part =
      read_captures(files.put("a.toml", "file = \"a.csv\"\nfrom = \"2 s\"\nuntil = \"4500 ms\"\n")).front();
  CHECK(part.times == Vector3d(0.0, 1.0, 2.0));
  CHECK(part.channel("x").values == Vector3d(20.0, 30.0, 40.0));
  CHECK(reading_error(files.put("a.toml", "file = \"a.csv\"\nfrom = \"7 s\"\n")) ==
        "a.csv:2: capture \"a\" has 0 frames with something visible; at least 3 were expected");
}

TEST_CASE("captures are chosen by labels, by their length, and end where they leave an interval") {
  const TemporaryDirectory files;
  std::string table = "drop,t[s],z[m]\n";
  for (int drop = 1; drop <= 3; ++drop) {
    for (int k = 0; k < 4 + drop; ++k) table += fmt::format("{},{},{}\n", drop, 0.1 * k, 1.0 - 0.2 * k);
  }
  files.put("drops.csv", table);
  files.put("index.csv", "drop,jump,kind\n1,0.5,a\n2,1.5,b\n3,1.9,b\n");
  const auto ids = [&](const std::string& lines) {
    std::string found;
    for (const Capture& capture :
         read_captures(files.put("drops.toml", "file = \"drops.csv\"\ngroup_by = [\"drop\"]\n" + lines +
                                                   "[labels]\nfile = \"index.csv\"\ncolumn = \"drop\"\n")))
      found += capture.id;
    return found;
  };
  CHECK(ids("") == "123");
  CHECK(ids("where = { jump = \"< 1.5\" }\n") == "1");
  CHECK(ids("where = { jump = \"> 1\", drop = [\"1\", \"3\"] }\n") == "3");
  CHECK(ids("where = { kind = \"c\" }\n").empty());
  CHECK_THROWS_WITH(ids("where = { jumps = \"< 2\" }\n"), Catch::Contains("has no column \"jumps\""));
}

TEST_CASE("rows that are left out between frames without times of their own are told of") {
  const TemporaryDirectory files;
  files.put("ball.csv", "seen,x[m]\n0,0\n1,1\n1,2\n0,3\n1,4\n0,5\n0,6\n1,7\n0,8\n");
  files.put("timed.csv", "t[s],seen,x[m]\n0,1,1\n1,0,2\n2,1,3\n3,1,4\n");
  files.put("cameras.csv", "cam,seen,x[m]\na,1,0\nb,0,0\na,1,1\nb,0,1\na,1,2\n");
  const auto notes_of = [&](const std::string& table, const std::string& lines) {
    return read_captures(files.put("a.toml", "file = \"" + table + "\"\n" + lines)).front().notes;
  };
  const std::string where = "where = { seen = [\"1\"] }\n", rate = "frame_rate = 10\n";
  // Not those before the first and after the last.
  const std::vector<std::string> notes = notes_of("ball.csv", where + rate);
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Catch::StartsWith("3 rows that `where` leaves out lie between its frames"));
  CHECK(notes_of("ball.csv", "where = { seen = [\"0\", \"1\"] }\n" + rate).empty());
  CHECK(notes_of("timed.csv", where).empty());
  // Rows of other groups are not of its frames.
  CHECK(notes_of("cameras.csv", where + rate + "group_by = [\"cam\"]\n").empty());
}

TEST_CASE("a frame period is a quantity like others, and one of another camera is refused") {
  const TemporaryDirectory files;
  std::string table = "t[s],z[m]\n";
  for (int k = 0; k < 20; ++k) table += fmt::format("{:.3f},{}\n", 6.932e-3 * k, 1.0 - 0.02 * k);
  files.put("ball.csv", table);
  const auto of = [&](const std::string& period) {
    return files.put("ball.toml", "file = \"ball.csv\"\n[clean]\nframe_grid = " + period + "\n");
  };
  for (const char* period : {"\"6.932 ms\"", "0.006932"}) {
    const Capture ball = read_captures(of(period)).front();
    CHECK(ball.times[19] - ball.times[0] == Approx(19 * 6.932e-3).epsilon(1e-12));
  }
  for (const auto& [period, words] : {std::pair{"\"6.932 s\"", "a frame period of 6932 ms was given"},
                                      {"-0.007", "more than 0 was expected"},
                                      {"[1]", "expected a number, or a string with a unit"}})
    CHECK_THAT(reading_error(of(period)), Catch::Contains(words));
}

TEST_CASE("pieces between long gaps belong to one motion") {
  const TemporaryDirectory files;
  std::string table = "t[s],z[m]\n";
  for (int k = 0; k < 40; ++k) {
    if (k < 12 || k > 20) table += fmt::format("{},{}\n", 0.01 * k, 1.0 - 0.02 * k);
  }
  files.put("card.csv", table);
  const auto pieces = read_captures(
      files.put("card.toml", "file = \"card.csv\"\nleast_frames = 10\n[clean]\nlongest_gap = \"35 ms\"\n"));
  REQUIRE(pieces.size() == 2);
  CHECK(pieces[0].frame_count() == 12);
  CHECK(pieces[1].frame_count() == 19);
  CHECK(pieces[0].motion == "card");
  CHECK(pieces[1].motion == "card");
  CHECK(pieces[1].times[0] == Approx(0.21));  // of the whole
  CHECK(read_captures(files.put("card.toml",
                                "file = \"card.csv\"\nleast_frames = 15\n[clean]\nlongest_gap = "
                                "\"35 ms\"\n"))
            .size() == 1);
  // Near the floor at 0.5 m, in frame 26: it ends before.
  const auto above = read_captures(
      files.put("card.toml", "file = \"card.csv\"\n[clean]\ninside = { z = [\"49 cm\", \"2 m\"] }\n"));
  CHECK(above.front().frame_count() == 17);
  CHECK_THAT(above.front().notes.at(0), Catch::Contains("14 frames cut from 0.26 s on, where z leaves"));
  for (const auto& [lines, words] :
       {std::pair{"[clean]\ninside = { z = [\"2 m\", \"1 m\"] }\n", "lower < upper"},
        {"[clean]\ninside = { z = [\"0.99 m\", \"3 m\"] }\n", "at least 3 were expected"},
        {"least_frames = 2\n", "at least 3"},
        {"where = { z = \"< low\" }\n", "compares with no number"}}) {
    CHECK_THAT(reading_error(files.put("card.toml", std::string("file = \"card.csv\"\n") + lines)),
               Catch::Contains("card.toml") && Catch::Contains(words));
  }
}

TEST_CASE("a sidecar can ask for cleaning") {
  const TemporaryDirectory files;
  std::string table = "t[s],x[m],y[m],z[m]\n";
  for (int k = 0; k < 60; ++k) {
    const double t = 0.0069 * k;
    // 3 m/s up and down after the bounce
    const double z = std::abs(3.0 * (t - 0.2)) - 4.905 * t * t + (k == 10 ? 0.5 : 0.0);
    table += fmt::format("{:.3f},{},{},{}\n", t, 4.0 * t, 1e-4 * (k % 3), z);
  }
  files.put("ball.csv", table);
  const Capture ball =
      read_captures(files.put("ball.toml",
                              "file = \"ball.csv\"\n[clean]\nframe_grid = true\n"
                              "before_impact = \"1.2 m/s\"\noutliers = 5\nwindow = \"0.1 s\"\n"))
          .front();
  CHECK(ball.times[ball.frame_count() - 1] < 0.2);
  CHECK(ball.times[ball.frame_count() - 1] > 0.17);
  CHECK(std::abs(ball.times[20] - 20 * 0.0069) < 2e-4);
  CHECK(std::isnan(ball.channel("z").values[10]));
  CHECK(ball.notes.size() >= 3);
  const auto with_grid = [&](const std::string& grid) {
    return files.put("grid.toml", fmt::format("file = \"ball.csv\"\n[clean]\nframe_grid = {}\n", grid));
  };
  const Capture of_period = read_captures(with_grid("\"6.905 ms\"")).front();
  CHECK(of_period.times[20] == Approx(20 * 0.006905));
  CHECK(known_at(of_period, 0.1).times[14] == Approx(14 * 0.006905));
  CHECK_THROWS_WITH(read_captures(with_grid("\"-6.9 ms\"")), Catch::Contains("more than 0 was expected"));
  CHECK_THROWS_WITH(read_captures(with_grid("\"145 Hz\"")), Catch::Contains("frame_grid"));
}

TEST_CASE("keys of a sidecar that make no sense are refused where they stand") {
  const TemporaryDirectory files;
  files.put("a.csv", "t[s],x[m],a\n0,1,2\n1,1,2\n2,2,2\n");
  const auto error = [&](const std::string& text) {
    return reading_error(files.put("a.toml", "file = \"a.csv\"\n" + text));
  };
  CHECK(error("up = \"w\"\n").starts_with("a.toml:2: up: \"w\" is none of its words"));
  CHECK(error("length_unit = \"s\"\n") == "a.toml:2: length_unit: \"s\" is no unit of length, nor px");
  CHECK(error("[clean]\nbefore_impact = \"-1 m/s\"\n") ==
        "a.toml:3: [clean] before_impact: -1; more than 0 was expected");
  CHECK(error("[clean]\nbefore_impact = \"1 m/s\"\n[columns]\nt = {}\n").starts_with("a.toml:5:"));
  CHECK(error("[attitude]\neuler = [\"a\"]\norder = \"zyx\"\nunit = \"deg\"\n") ==
        "a.toml:3: [attitude] euler: 1 columns; three were expected");
  CHECK(error("[attitude]\neuler = [\"a\", \"a\", \"b\"]\norder = \"zzx\"\nunit = \"deg\"\n") ==
        "a.toml:4: [attitude] order: \"zzx\"; three of x, y, z, none twice in a row, were expected");
  CHECK(error("[attitude]\neuler = [\"a\", \"a\", \"b\"]\norder = \"zyx\"\nunit = \"m\"\n") ==
        "a.toml:5: [attitude] unit: is no unit of an angle; \"deg\" or \"rad\" was expected");
}

TEST_CASE("an angle that goes around its circle loses no frame to the search for outliers") {
  const TemporaryDirectory files;
  std::string table = "t[s],theta[deg],side[deg]\n";
  for (int k = 0; k < 60; ++k) {
    // Some noise, or rounding would be all there is to judge by. The sides of a plate look alike.
    const double angle = 12.0 * k + 0.3 * std::sin(37.0 * k) + (k == 40 ? 30.0 : 0.0);
    table += fmt::format("{},{},{}\n", 0.01 * k, std::remainder(angle, 360.0), std::remainder(angle, 180.0));
  }
  files.put("turns.csv", table);
  const std::string text = "file = \"turns.csv\"\n[clean]\noutliers = 5\n";
  const auto missing = [&](const std::string& more, const char* quantity) {
    const Capture capture = read_captures(files.put("turns.toml", text + more)).front();
    return capture.channel(quantity).values.array().isNaN().count();
  };
  CHECK(missing("", "theta") == 1);
  CHECK(missing("periods = { side = \"180 deg\" }\n", "side") == 1);
}

TEST_CASE("options of outliers without outliers, and two rows of labels for a capture, are refused") {
  const TemporaryDirectory files;
  files.put("x.csv", "t[s],x[m]\n0,0\n1,1\n2,4\n");
  CHECK(reading_error(files.put("a.toml", "file = \"x.csv\"\n[clean]\nwindow = \"0.1 s\"\n")) ==
        "a.toml:3: [clean] window: belongs to `outliers`, which is not there");
  files.put("index.csv", "name,mass\nx,1\nx,2\n");
  CHECK_THAT(reading_error(files.put(
                 "b.toml", "file = \"x.csv\"\n[labels]\nfile = \"index.csv\"\ncolumn = \"name\"\n")),
             Catch::Matchers::StartsWith("b.toml:3: [labels] file: ") &&
                 Catch::Matchers::Contains("several rows for name \"x\""));
}

TEST_CASE("the files behind a capture are its tables, its sidecar and its labels") {
  const TemporaryDirectory files;
  for (const char* name : {"a1.csv", "a2.csv"}) files.put(name, "t[s],x[m]\n0,0\n1,1\n2,4\n");
  const auto sidecar =
      files.put("a.toml", "file = \"a?.csv\"\n[labels]\nfile = \"index.csv\"\ncolumn = \"name\"\n");
  std::set<std::string> names;
  for (const auto& file : capture_files(sidecar)) names.insert(file.filename().string());
  CHECK(names == std::set<std::string>{"a.toml", "a1.csv", "a2.csv", "index.csv"});
  // A sidecar beside its table.
  files.put("b.csv", "t[s],x[m]\n0,0\n1,1\n2,4\n");
  files.put("b.toml", "from = \"0 s\"\n");
  const auto beside = capture_files(files.path() / "b.csv");
  CHECK(std::ranges::count(beside, files.path() / "b.toml") == 1);
}

TEST_CASE("a sidecar turns one axis, its velocity with it, and what else it names") {
  const TemporaryDirectory files;
  files.put("drop.csv", "t[s],x[m],z[m],vz[m/s],theta[rad]\n0,1,2,3,0.5\n1,2,4,3,0.6\n2,3,6,3,0.7\n");
  const auto path = files.put("drop.toml", "flip = [\"z\", \"theta\"]\n");
  const Capture drop = read_captures(files.path() / "drop.csv").front();
  CHECK(drop.channel("x").values.isApprox(Vector3d(1.0, 2.0, 3.0)));
  CHECK(drop.channel("z").values.isApprox(Vector3d(-2.0, -4.0, -6.0)));
  CHECK(drop.channel("vz").values.isApprox(Vector3d(-3.0, -3.0, -3.0)));
  CHECK(drop.channel("theta").values.isApprox(Vector3d(-0.5, -0.6, -0.7)));
  const auto refused = [&](const std::string& text) {
    files.put("drop.toml", text);
    return reading_error(files.path() / "drop.csv");
  };
  CHECK_THAT(refused("flip = [\"thet\"]"),
             Catch::Contains("no quantity \"thet\"") && Catch::Contains("theta"));
  CHECK_THAT(refused("flip = [\"z\", \"z\"]"), Catch::Contains("twice"));
  CHECK_THAT(refused("flip = \"t\""), Catch::Contains("time counts forward"));
  files.put("drop.csv", "t[s],z[m],qw[1],qx[1],qy[1],qz[1]\n0,2,1,0,0,0\n1,4,1,0,0,0\n2,6,1,0,0,0\n");
  CHECK_THAT(refused("flip = \"z\""), Catch::Contains("no mirrored world has"));
}

TEST_CASE("a sidecar names the decimal sign, and one without a table says how it is given") {
  const TemporaryDirectory files;
  files.put("drop.csv", "t[s];x[m]\n0;1,5\n0,1;2,5\n0,2;3\n");
  CHECK(
      read_captures(files.path() / "drop.csv").front().channel("x").values.isApprox(Vector3d(1.5, 2.5, 3.0)));
  // Cells of `where` and labels are read by the same sign.
  files.put("heights.csv",
            "t[s];x[m];h\n0;1;2\n0,1;1;1,5\n0,2;1;0,5\n0,3;1;2\n0,4;1;1,5\n0,5;1;1,5\n0,6;1;2\n");
  CHECK(read_captures(files.put("heights.toml", "file = \"heights.csv\"\nwhere = { h = [\"> 1\"] }\n"))
            .front()
            .times.size() == 6);
  const auto by_height = read_captures(files.put(
      "heights.toml", "file = \"heights.csv\"\ngroup_by = [\"h\"]\nwhere = { h = [\"1,5\", \"2\"] }\n"));
  REQUIRE(by_height.size() == 2);
  CHECK(by_height[1].id == "1,5");
  CHECK(by_height[1].labels.at("h") == "1.5");
  files.put("index.csv", "name;mass\ndrop;2,5\n");
  const auto labelled = [&](const std::string& where) {
    return files.put(
        "drop.toml",
        "labels = { file = \"index.csv\", column = \"name\" }\nwhere = { mass = \"" + where + "\" }\n");
  };
  for (const std::string where : {"2,5", "> 2", "< 3"}) {
    labelled(where);
    CHECK(read_captures(files.path() / "drop.csv").front().labels.at("mass") == "2.5");
  }
  std::filesystem::remove(labelled("2,5"));
  const auto sidecar = files.put("other.toml", "decimal = \".\"\n");
  CHECK_THAT(error_of<samara::InputError>([&] { read_captures(files.path() / "drop.csv", sidecar); }),
             Catch::Contains("the decimal sign is a point"));
  CHECK_THAT(reading_error(sidecar), Catch::Contains("names no table") && Catch::Contains("--sidecar"));
}

TEST_CASE("a scale over no length, or a negative one, is refused") {
  const TemporaryDirectory files;
  files.put("drop.csv", "t,x\n0,1\n1,2\n2,3\n");
  for (const std::string length : {"-0.38 m", "0 m"}) {
    files.put("drop.toml",
              "[columns]\nt = { quantity = \"t\", unit = \"s\" }\nx = { quantity = \"x\", unit = \"px\" }\n"
              "[scale]\nx = { length = \"" +
                  length + "\", over = \"largest - first\" }\n");
    CHECK_THAT(reading_error(files.path() / "drop.csv"),
               Catch::StartsWith("drop.toml:5") && Catch::Contains("more than 0 was expected"));
  }
}

TEST_CASE("a unit for exports is refused where columns say theirs, which it would not change") {
  const TemporaryDirectory files;
  files.put("drop.csv", "t[s],x[m]\n0,0\n1,1\n2,4\n");
  for (const std::string key : {"time_unit = \"ms\"", "length_unit = \"mm\""}) {
    files.put("drop.toml", key + "\n");
    CHECK_THAT(reading_error(files.path() / "drop.csv"),
               Catch::StartsWith("drop.toml:1: " + key.substr(0, key.find(' ')) + ": \"m") &&
                   Catch::Contains("\"drop.csv\" is read by its columns"));
    // Other tables of a sidecar may be exports.
    files.put("shared.toml", key + "\n");
    CHECK(read_captures(files.path() / "drop.csv", files.path() / "shared.toml").size() == 1);
  }
  // Of an export whose columns a sidecar names, and of a table that has no header.
  const std::string columns =
      "[columns]\nt = { quantity = \"t\", unit = \"s\" }\nx = { quantity = \"x\", unit = \"cm\" }\n";
  files.put("mass.txt", "mass_A\nt\tx\n0\t1\n1\t2\n2\t3\n");
  files.put("bare.csv", "0;1\n1;2\n2;3\n");
  for (const std::string table :
       {"file = \"mass.txt\"\n", "file = \"bare.csv\"\nheader = [\"t\", \"x\"]\n"}) {
    CHECK(read_captures(files.put("a.toml", table + columns)).front().channel("x").values[2] == 0.03);
    CHECK_THAT(reading_error(files.put("a.toml", table + "length_unit = \"m\"\n" + columns)),
               Catch::Contains(": length_unit: \"m\" is for an export that names no units"));
  }
}

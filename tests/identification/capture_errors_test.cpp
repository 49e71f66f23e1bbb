#include <catch2/catch.hpp>

#include "files.h"

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kRows = "0,0\n1,1\n2,4\n";

/// What reading a canonical table says.
std::string table_error(const std::string& text) {
  const TemporaryDirectory files;
  return reading_error(files.put("a.csv", text));
}

/// What reading a sidecar says. The table has the columns k [frames], y [pixels] and cam.
std::string sidecar_error(const std::string& text,
                          const std::string& table = "k,y,cam\n0,5,1\n1,7,1\n2,9,1\n") {
  const TemporaryDirectory files;
  files.put("a.csv", table);
  return reading_error(files.put("s.toml", text));
}

const std::string kColumns =
    "[columns]\n"
    "k = { quantity = \"t\", unit = \"frame\" }\n"
    "y = { quantity = \"x\", unit = \"px\" }\n";
const std::string kHead = "file = \"a.csv\"\nframe_rate = 60\n";

}  // namespace

TEST_CASE("a header without units is refused in one sentence that says what helps") {
  CHECK(table_error("t[s],x\n" + kRows) ==
        "a.csv:1: column \"x\" has no unit; a header like \"x[m]\" was expected, or a sidecar that says what "
        "the columns "
        "are");
  CHECK_THAT(table_error("t,x\n" + kRows), StartsWith("a.csv:1: column \"t\" has no unit"));
  CHECK_THAT(table_error("t[s],[m]\n" + kRows), Contains("\"[m]\" has no unit"));
}

TEST_CASE("unknown units are named with the nearest known one") {
  CHECK_THAT(table_error("# a comment\nt[s],x[metre]\n" + kRows),
             StartsWith("a.csv:2: column \"x[metre]\": ") && Contains("metre"));
}

TEST_CASE("times must be there, in a unit of time, and increase") {
  CHECK(table_error("x[m],z[m]\n" + kRows) ==
        "a.csv:1: no column holds the time; one with the quantity \"t\" was expected, or a "
        "frame_rate at which rows follow one another");
  CHECK_THAT(table_error("t[m],x[m]\n" + kRows),
             Contains("a.csv:1: column \"t[m]\": time has a unit of dimension m"));
  CHECK_THAT(table_error("t[frame],x[m]\n" + kRows), Contains("`frame_rate` is missing"));
  CHECK_THAT(table_error("t[s],x[m]\n0,0\n2,1\n2,4\n"), StartsWith("a.csv:4: time 2 s follows 2 s"));
  CHECK_THAT(table_error("t[s],x[m]\n0,0\n2,1\n1,4\n"), StartsWith("a.csv:4: time 1 s follows 2 s"));
  CHECK(table_error("t[s],x[m]\n0,0\n,1\n1,4\n") == "a.csv:3: column \"t[s]\": the time is missing");
  CHECK(table_error("t[s],x[m]\n0,0\nNaN,1\n1,4\n") == "a.csv:3: column \"t[s]\": the time is missing");
}

TEST_CASE("cells must be finite numbers") {
  CHECK_THAT(table_error("t[s],x[m]\n0,0\n1,inf\n2,4\n"), StartsWith("a.csv:3: ") && Contains("x[m]"));
  CHECK_THAT(table_error("t[s],x[m]\n0,0\n1,far\n2,4\n"), StartsWith("a.csv:3: ") && Contains("far"));
}

TEST_CASE("a capture needs three frames and a quantity") {
  CHECK_THAT(table_error("t[s],x[m]\n0,\n1,1\n2,4\n3,\n"),
             StartsWith("a.csv:3: capture \"a\" has 2 frames with something visible; at least 3"));
  CHECK_THAT(table_error("t[s],x[m]\n0,\n1,\n"), Contains("has 0 frames"));
  CHECK(table_error("t[s],x[m]\n") == "a.csv:1: there are no rows below the header");
  CHECK(table_error("t[s]\n0\n1\n2\n") == "a.csv:1: no column holds a measured quantity beside the time");
  CHECK_THAT(table_error("t[s],x[m],x[cm]\n0,0,0\n1,1,1\n2,2,2\n"),
             Contains("column \"x[cm]\": quantity \"x\" is already in column \"x[m]\""));
}

TEST_CASE("a file that is not there is named") {
  CHECK_THAT(reading_error("/nowhere/a.csv"), Contains("/nowhere/a.csv"));
  CHECK_THAT(sidecar_error("file = \"b.csv\"\n"), Contains("b.csv"));
  CHECK_THAT(sidecar_error("frame_rate = 60\n"), Contains("file: is missing: the sidecar names no table"));
}

TEST_CASE("a file that is read as a sidecar because of where it lies is said to be") {
  const TemporaryDirectory files;
  const auto table = files.put("card.csv", "t[s],x[m]\n" + kRows);
  files.put("card.toml", "starts = 1\nsegments = \"60 ms\"\n");
  CHECK_THAT(reading_error(table), StartsWith("card.toml:1: starts: unknown key") &&
                                       Contains("the file was read as the sidecar of \"card.csv\""));
}

TEST_CASE("files that a sidecar names and that are not there are its fault") {
  CHECK_THAT(sidecar_error("file = \"nope.csv\"\n"),
             StartsWith("s.toml:1: file: there is no file \"") && Contains("nope.csv\""));
  CHECK_THAT(
      sidecar_error(kHead + kColumns + "[labels]\nfile = \"none.csv\"\ncolumn = \"name\"\n"),
      StartsWith("s.toml:") && Contains("[labels] file: there is no file \"") && Contains("none.csv\""));
}

TEST_CASE("unknown keys of a sidecar are refused with the nearest known one") {
  CHECK_THAT(sidecar_error("file = \"a.csv\"\nframerate = 60\n"),
             StartsWith("s.toml:2: ") && Contains("did you mean \"frame_rate\"?"));
  CHECK_THAT(sidecar_error(kHead + "[columns]\nk = { quantity = \"t\", units = \"s\" }\n"),
             StartsWith("s.toml:4: ") && Contains("did you mean \"unit\"?"));
  CHECK_THAT(sidecar_error(kHead + kColumns + "[scale]\nx = { size = \"1 m\" }\n"), StartsWith("s.toml:7: "));
  CHECK_THAT(sidecar_error(kHead + "start = \"first visibel\"\n" + kColumns),
             StartsWith("s.toml:3: start: ") && Contains("did you mean \"first visible\"?"));
  CHECK_THAT(sidecar_error("delimiter = \"|\"\n" + kHead + kColumns), StartsWith("s.toml:1: delimiter: "));
}

TEST_CASE("columns that the sidecar names must be in the table") {
  CHECK_THAT(
      sidecar_error(kHead +
                    "[columns]\nk = { quantity = \"t\", unit = \"frame\" }\nyy = { quantity = \"x\", unit = "
                    "\"px\" }\n"),
      StartsWith("s.toml:5: [columns] yy: ") && Contains("has no such column; did you mean \"y\"?"));
  CHECK_THAT(sidecar_error(kHead + "group_by = [\"camera\"]\n" + kColumns),
             StartsWith("s.toml:3: group_by: ") && Contains("has no column \"camera\""));
  CHECK_THAT(sidecar_error(kHead + "where = { camm = [\"1\"] }\n" + kColumns),
             StartsWith("s.toml:3: ") && Contains("has no column \"camm\"; did you mean \"cam\"?"));
  CHECK_THAT(sidecar_error(kHead + "where = { cam = [\"3\"] }\n" + kColumns),
             StartsWith("s.toml:3: ") && Contains("no row of") && Contains("has \"3\" there"));
  CHECK_THAT(sidecar_error(kHead + "[columns]\nk = { quantity = \"t\", unit = \"frame\" }\n"),
             StartsWith("s.toml:3: columns: no column holds a measured quantity"));
}

TEST_CASE("the frame rate must be a positive frequency, and be needed") {
  CHECK_THAT(sidecar_error("file = \"a.csv\"\n" + kColumns), Contains("`frame_rate` is missing"));
  CHECK_THAT(sidecar_error("file = \"a.csv\"\nframe_rate = 0\n" + kColumns),
             StartsWith("s.toml:2: frame_rate: "));
  CHECK_THAT(sidecar_error("file = \"a.csv\"\nframe_rate = \"60 m\"\n" + kColumns),
             StartsWith("s.toml:2: frame_rate: "));
  CHECK_THAT(sidecar_error(kHead, "t[s],x[m]\n" + kRows), Contains("time is not in frames"));
}

TEST_CASE("a scale must be possible") {
  const auto scaled = [](const std::string& scale) {
    return sidecar_error(kHead + kColumns + "[scale]\n" + scale + "\n");
  };
  const std::string over = "over = \"largest - first\" }";
  CHECK_THAT(scaled("x = { length = \"38 s\", " + over), StartsWith("s.toml:7: "));
  CHECK_THAT(scaled("x = { length = 0, " + over), Contains("the length is 0"));
  CHECK_THAT(scaled("x = { value = 0 }"), Contains("the scale is 0"));
  CHECK_THAT(scaled("x = { value = \"1 mm\" }"), StartsWith("s.toml:7: "));
  CHECK_THAT(scaled("x = { value = \"1 mm/px\", length = \"1 m\" }"), Contains("one of the two"));
  CHECK_THAT(scaled("x = { length = \"1 m\", over = \"largest\" }"),
             Contains("known: largest - first, largest - smallest"));
  CHECK_THAT(scaled("z = { length = \"1 m\", " + over),
             StartsWith("s.toml:7: [scale] z: no column holds this quantity"));

  CHECK_THAT(
      sidecar_error(kHead + kColumns + "[scale]\nx = { length = \"1 m\", " + over, "k,y\n0,9\n1,8\n2,7\n"),
      StartsWith("s.toml:7: [scale] x: capture \"a\" spans no distance"));
  const std::string metres =
      "[columns]\nk = { quantity = \"t\", unit = \"frame\" }\ny = { quantity = \"x\", unit = \"m\" }\n";
  CHECK_THAT(sidecar_error(kHead + metres + "[scale]\nx = { value = \"1 mm/px\" }\n"),
             Contains("a scale is for px"));
}

TEST_CASE("a sidecar beside a table must not name another") {
  const TemporaryDirectory files;
  const auto table = files.put("a.csv", "t[s],x[m]\n" + kRows);
  files.put("a.toml", "file = \"b.csv\"\n");
  CHECK_THAT(reading_error(table), StartsWith("a.toml:1: file: names \"b.csv\""));
}

#include "samara/io/delimited_table.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "temporary_directory.h"

using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::InputError;
using samara::io::DelimitedTable;

namespace {
DelimitedTable table(const std::string& text, char delimiter = 0) {
  return DelimitedTable::parse(text, "t.csv", {.delimiter = delimiter});
}
std::string table_error(const std::string& text) {
  return error_text<InputError>([&] { table(text); });
}
std::string number_error(const std::string& cell) {
  return error_text<InputError>([&] { table("a;b\n1;2\n3;" + cell + "\n").numbers("b"); });
}
}  // namespace

TEST_CASE("columns are read by name") {
  const DelimitedTable t = table("t[s],x[m],note\n0,1.5,start\n0.01,-2e-3,\n");
  CHECK(t.header() == std::vector<std::string>{"t[s]", "x[m]", "note"});
  CHECK(t.rows() == 2);
  CHECK(t.numbers("x[m]") == Eigen::Vector2d(1.5, -2e-3));
  CHECK(t.texts("note") == std::vector<std::string>{"start", ""});
  CHECK(t.has("note"));
  CHECK_FALSE(t.has("Note"));
}

TEST_CASE("an empty cell is a missing value") {
  const DelimitedTable t = table("a,b\n,1\n2,\n,\n");
  CHECK(t.rows() == 3);
  CHECK(std::isnan(t.numbers("a")[0]));
  CHECK(t.numbers("a")[1] == 2.0);
  CHECK(std::isnan(t.numbers("b")[2]));
}

TEST_CASE("what programs write for no value is missing among numbers, and stays a text") {
  const DelimitedTable t = table("a,b\nNaN,1\nnan,NA\nNAN,\"NaN\"\n");
  CHECK(t.numbers("a").array().isNaN().all());
  CHECK(t.numbers("b")[0] == 1.0);
  CHECK(t.numbers("b").tail(2).array().isNaN().all());
  CHECK(t.texts("b")[1] == "NA");
  CHECK_FALSE(t.is_empty(1, "b"));
  CHECK(table("a,b\n,1\n").is_empty(0, "a"));
  CHECK(std::isnan(table("a;b\n1,5;nan\n").numbers("b")[0]));
  for (const std::string text : {"-nan", "nan(ind)", "na", "N/A", "-", "null"})
    CHECK_THAT(number_error(text), Contains("number, found \"" + text + "\""));
}

TEST_CASE("the delimiter is the one that the header has most of") {
  CHECK(table("a,b\n1,2\n").delimiter() == ',');
  CHECK(table("a\tb\n1\t2\n").delimiter() == '\t');
  CHECK(table("a;b\n1;2\n").delimiter() == ';');
  CHECK(table("\"x, y, z\";b\n1;2\n").header().front() == "x, y, z");
  CHECK(table("a\n1\n").numbers("a")[0] == 1.0);
}

TEST_CASE("a given delimiter is used") {
  CHECK(table("a|b,c\n1|2\n", '|').header() == std::vector<std::string>{"a", "b,c"});
}

TEST_CASE("comments are collected and not rows") {
  const DelimitedTable t = table("# body: mahogany seed\n#note\n# file: a:b\na,b\n1,2\n# body: card\n3,4\n");
  CHECK(t.rows() == 2);
  CHECK(t.comments().size() == 3);
  CHECK(t.comment("body") == "card");
  CHECK(t.comment("file") == "a:b");
  CHECK_FALSE(t.comment("note"));
}

TEST_CASE("cells are quoted as in RFC 4180") {
  const DelimitedTable t = table("a,b\n\"x, \"\"y\"\"\",1\n\"two\nlines\", 2\n\"#\",\"\"\n");
  CHECK(t.texts("a") == std::vector<std::string>{"x, \"y\"", "two\nlines", "#"});
  CHECK(t.numbers("b")[1] == 2.0);
  CHECK(std::isnan(t.numbers("b")[2]));
}

TEST_CASE("blanks around unquoted cells do not count, within quotes they do") {
  const DelimitedTable t = table("a , b\n x ,\" y \" \n");
  CHECK(t.texts("a").front() == "x");
  CHECK(t.texts("b").front() == " y ");
}

TEST_CASE("line ends, a byte order mark and a missing last line end make no difference") {
  for (const std::string text : {"a,b\n1,2\n", "a,b\r\n1,2\r\n",
                                 "\xEF\xBB\xBF"
                                 "a,b\n1,2",
                                 "\n\r\na,b\n\n1,2\r\n\n", "\"a\",b\r\n1,\"2\"\r\n"}) {
    INFO(text);
    CHECK(table(text).rows() == 1);
    CHECK(table(text).numbers("a")[0] == 1.0);
    CHECK(table(text).numbers("b")[0] == 2.0);
  }
}

TEST_CASE("blank lines are skipped, rows of missing values are not") {
  CHECK(table("a\tb\n\t\n\n1\t2\n").rows() == 2);
  CHECK(table("a\n\n\"\"\n").rows() == 1);
}

TEST_CASE("a row knows its line") {
  const DelimitedTable t = table("# c: d\na,b\n\"x\ny\",1\n# more\n2,3\n");
  CHECK(t.line_of_header() == 2);
  CHECK(t.line_of_row(0) == 3);
  CHECK(t.line_of_row(1) == 6);
  CHECK(std::string(t.error(1, "time runs backwards").what()) == "t.csv:6: time runs backwards");
  CHECK_THAT(error_text<ArgumentError>([&] { t.line_of_row(2); }), Contains("row 2 of t.csv does not exist"));
}

TEST_CASE("a header without rows is a table without rows") {
  const DelimitedTable t = table("a,b\n");
  CHECK(t.rows() == 0);
  CHECK(t.numbers("a").size() == 0);
}

TEST_CASE("a text without a header is refused") {
  for (const std::string text : {"", "\n\n", "# a: b\n", "\xEF\xBB\xBF"}) {
    CHECK(table_error(text) == "t.csv: is empty, expected a header with the names of columns");
  }
}

TEST_CASE("a row with another number of cells is refused with its line") {
  CHECK(table_error("a,b\n1,2\n1\n") ==
        "t.csv:3: the row has 1 cells, expected 2 as in the header (the delimiter is \",\")");
  CHECK_THAT(table_error("a\tb\n1\t2\t3\n"), Contains("t.csv:2: the row has 3 cells") && Contains("tab"));
}

TEST_CASE("a table of many columns is read, before the patience of tests is over") {
  constexpr int kColumns = 200'000;  // which took minutes when names were compared in pairs
  std::string text;
  for (int row = 0; row < 20; ++row)
    for (int i = 0; i < kColumns; ++i)
      text += (row == 0 ? "name" : "") + std::to_string(i) + (i + 1 < kColumns ? ',' : '\n');
  CHECK(table(text).rows() == 19);
}

TEST_CASE("names of columns are unique and not empty") {
  CHECK(table_error("# c\na,b,a\n") == "t.csv:2: the column \"a\" stands twice in the header");
  CHECK(table_error("a,,b\n") == "t.csv:1: column 2 has no name");
}

TEST_CASE("quotes must be closed and stand around the whole cell") {
  CHECK(table_error("a,b\n1,\"2\n3,4\n") == "t.csv:2: a quoted cell begins here and is never closed");
  CHECK_THAT(table_error("a,b\n\"1\"x,2\n"), Contains("t.csv:2: text follows the quoted cell \"1\""));
  CHECK_THAT(table_error("a,b\n1\"2,3\n"), Contains("t.csv:2: a quote inside the unquoted cell"));
}

TEST_CASE("text in another encoding or with other line ends is refused") {
  CHECK_THAT(table_error(std::string("a\0,\0b\0\n\0", 8)), Contains("zero byte"));
  CHECK_THAT(table_error("a,b\r1,2\r"), Contains("carriage return"));
}

TEST_CASE("a header or row that is not UTF-8 is refused with its line, and comments are not looked at") {
  CHECK(table_error("# a\nt[s],x[\xb5m]\n0,1\n") ==
        "t.csv:2: the byte 0xb5 behind \"x[\" is not UTF-8; save the table as UTF-8");
  CHECK_THAT(table_error("a;b\n1;\"two\nd\xfcrr\"\n"), Contains("t.csv:3: the byte 0xfc behind \"d\""));
  for (const std::string cell : {"\xff", "\x80", "\xc3", "\xe2\x82", "\xc0\xaf", "\xf8\x80\x80\x80\x80"})
    CHECK_THAT(table_error("a,b\n" + cell + ",2\n"), Contains("t.csv:2: the byte 0x"));
  CHECK(table("# d\xfcrr\na,b\n1,2\n").rows() == 1);
  CHECK(table("x[\xc2\xb5m],\xe2\x82\xac,\xf0\x9f\x8d\x82\n1,2,3\n").header().front() == "x[\xc2\xb5m]");
}

TEST_CASE("a cell that is not a finite number is refused with line and column") {
  CHECK(number_error("x1") == "t.csv:3: column \"b\": expected a number, found \"x1\"");
  CHECK_THAT(number_error("1 mm"), Contains("expected a number, found \"1 mm\""));
  CHECK_THAT(number_error("1.5,2"), Contains("the decimal sign is a point"));
  CHECK_THAT(number_error("0x10"), Contains("expected a number"));
  CHECK_THAT(number_error("+-1"), Contains("expected a number"));
  for (const std::string text : {"inf", "-Infinity", "1e999"}) {
    CHECK_THAT(number_error(text), Contains("t.csv:3") && Contains("finite number, found \"" + text + "\""));
  }
  CHECK(number_error("+1.5e-3") == "no exception");
  CHECK(number_error("1e-310") == "no exception");
}

TEST_CASE("a column that does not exist is refused with the nearest") {
  const DelimitedTable t = table("t[s],x[m]\n");
  CHECK(error_text<InputError>([&] { t.numbers("x[mm]"); }) ==
        "t.csv:1: no column \"x[mm]\"; did you mean \"x[m]\"?");
  CHECK_THAT(error_text<InputError>([&] { t.texts("velocity"); }), Contains("known: t[s], x[m]"));
}

TEST_CASE("a table is read from a file with its path in errors") {
  const TemporaryDirectory directory;
  put_content(directory / "t.csv", "a,b\n1\n");
  CHECK_THAT(error_text<InputError>([&] { DelimitedTable::read(directory / "t.csv"); }),
             Contains("t.csv:2: the row"));
  CHECK_THAT(error_text<InputError>([&] { DelimitedTable::read(directory / "none"); }),
             Contains("does not exist"));
  CHECK_THAT(error_text<InputError>([&] { DelimitedTable::read(directory.path()); }),
             Contains("is a directory"));
}

TEST_CASE("a file without a header takes names from the call") {
  const DelimitedTable t =
      DelimitedTable::parse("# ball\n0;1.5\n0.01;2\n", "t.csv", {.delimiter = 0, .header = {"t", "x"}});
  CHECK(t.delimiter() == ';');
  CHECK(t.rows() == 2);
  CHECK(t.line_of_row(0) == 2);
  CHECK(t.numbers("x") == Eigen::Vector2d(1.5, 2.0));
  CHECK(error_text<InputError>([] {
          DelimitedTable::parse("0;1;2\n", "t.csv", {.delimiter = ';', .header = {"t", "x"}});
        }) == "t.csv:1: the row has 3 cells, expected 2 as in the header (the delimiter is \";\")");
  CHECK(error_text<InputError>([] {
          DelimitedTable::parse("0;1\n", "t.csv", {.delimiter = ';', .header = {"t", "t"}});
        }) == "t.csv: the column \"t\" stands twice in the header");
}

TEST_CASE("decimal commas are understood where the comma parts no cells, and one sign throughout") {
  const DelimitedTable t = table("t;x\n0,5;-1,25\n1;2,5E-1\n2;\n");
  CHECK(t.decimal() == ',');
  CHECK(t.numbers("t").isApprox(Eigen::Vector3d(0.5, 1.0, 2.0)));
  CHECK(t.numbers("x")[0] == -1.25);
  CHECK(t.numbers("x")[1] == 0.25);
  CHECK(std::isnan(t.numbers("x")[2]));
  CHECK(table("a\tb\n1,5\t2\n").numbers("a")[0] == 1.5);
  const auto complaint = [](const std::string& text, const samara::io::DelimitedOptions& options = {}) {
    return error_text<InputError>([&] { DelimitedTable::parse(text, "t.csv", options).numbers("x"); });
  };
  // Where both signs stand, neither is guessed; nor is a comma of thousands.
  CHECK_THAT(complaint("t;x\n0.5;1,25\n"), Contains("t.csv:2") && Contains("the decimal sign is a point"));
  CHECK_THAT(complaint("t;x\n0;1.234,5\n1;2,5\n"),
             Contains("1.234,5") && Contains("decimal sign is a comma"));
  CHECK_THAT(complaint("t;x\n0;1,234,567\n"), Contains("expected a number"));
  // One may be named.
  CHECK_THAT(complaint("t;x\n0;1,25\n", {.decimal = '.'}), Contains("the decimal sign is a point"));
  CHECK_THAT(complaint("t;x\n0;1.25\n", {.decimal = ','}), Contains("the decimal sign is a comma"));
  CHECK(DelimitedTable::parse("t,x\n0,\"1,25\"\n", "t.csv", {.decimal = ','}).numbers("x")[0] == 1.25);
}

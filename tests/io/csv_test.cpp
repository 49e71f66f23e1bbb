#include "samara/io/csv.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "samara/io/delimited_table.h"
#include "samara/io/number_table.h"

using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::io::DelimitedTable;
using samara::io::format_csv;
using samara::io::NumberTable;

namespace {
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
std::string format_error(const std::vector<std::string>& header, const Eigen::MatrixXd& values,
                         const samara::io::CsvComments& comments = {}) {
  return error_text<ArgumentError>([&] { format_csv(header, values, comments); });
}
}  // namespace

TEST_CASE("a table is written row by row with comments above") {
  Eigen::MatrixXd values(2, 2);
  values << 0.0, 0.1, 1e-300, kNan;
  CHECK(format_csv({"t[s]", "x[m]"}, values, {{"body", "card"}}) ==
        "# body: card\nt[s],x[m]\n0,0.1\n1e-300,\n");
}

TEST_CASE("a table of many columns is written, before the patience of tests is over") {
  std::vector<std::string> header;
  for (int i = 0; i < 200'000; ++i) header.push_back("name" + std::to_string(i));
  CHECK_FALSE(format_csv(header, Eigen::MatrixXd::Zero(1, std::ssize(header))).empty());
}

TEST_CASE("every double written as CSV reads back with the same bits") {
  std::mt19937_64 random(7);
  Eigen::MatrixXd values(2000, 3);
  for (double& value : values.reshaped()) {
    do value = std::bit_cast<double>(random());
    while (!std::isfinite(value));
  }
  values.topRows(4).col(0) << -0.0, std::numeric_limits<double>::denorm_min(),
      std::numeric_limits<double>::max(), 1.0 / 3.0;
  const DelimitedTable read = DelimitedTable::parse(format_csv({"a", "b", "c"}, values), "t");
  for (int column = 0; column < 3; ++column) {
    const Eigen::VectorXd back = read.numbers(read.header()[static_cast<std::size_t>(column)]);
    const bool same =
        std::equal(back.begin(), back.end(), values.col(column).begin(), [](double a, double b) {
          return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
        });
    CHECK(same);
  }
}

TEST_CASE("missing values survive, also in a single column") {
  const Eigen::VectorXd values = Eigen::Vector3d(1.0, kNan, 3.0);
  const Eigen::VectorXd back = DelimitedTable::parse(format_csv({"a"}, values), "t").numbers("a");
  REQUIRE(back.size() == 3);
  CHECK(std::isnan(back[1]));
  CHECK(back[2] == 3.0);
}

TEST_CASE("any name survives in the header, and comments do") {
  const std::vector<std::string> header = {"#a", "b,c", "d\"e", " f ", "g\nh", "i;j;k;l;m;n;o;p", "q\tr"};
  const std::string text = format_csv(header, Eigen::MatrixXd::Zero(1, 7), {{"k", "v: w"}});
  const DelimitedTable read = DelimitedTable::parse(text, "t");
  CHECK(read.header() == header);
  CHECK(read.comment("k") == "v: w");
}

TEST_CASE("what a table cannot hold is refused") {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  CHECK_THAT(format_error({"a", "b"}, one), Contains("1 columns") && Contains("got 2"));
  CHECK_THAT(format_error({}, Eigen::MatrixXd(0, 0)), Contains("at least one"));
  CHECK_THAT(format_error({""}, one), Contains("empty"));
  CHECK_THAT(format_error({"a", "a"}, Eigen::MatrixXd::Ones(1, 2)), Contains("\"a\" stands twice"));
  CHECK_THAT(format_error({"a"}, one / 0.0), Contains("row 0 of column \"a\" is infinite"));
  CHECK_THAT(format_error({"a"}, one, {{"k:", "v"}}), Contains("free of colons"));
  CHECK_THAT(format_error({"a"}, one, {{"k", "v\nw"}}), Contains("not one line"));
}

TEST_CASE("a table of plain numbers is read with the bits that were written, whatever its size") {
  std::mt19937_64 random(11);
  Eigen::MatrixXd values(30'000, 3);  // several parts
  for (double& value : values.reshaped()) {
    do value = std::bit_cast<double>(random());
    while (!std::isfinite(value));
  }
  const NumberTable table =
      NumberTable::parse(format_csv({"a", "b[m]", "c(0)"}, values, {{"body", "card"}}), "t");
  CHECK(table.header() == std::vector<std::string>{"a", "b[m]", "c(0)"});
  CHECK(table.values() == values);
}

TEST_CASE("the parts of a table come in the order of its rows, whichever is made first") {
  constexpr Eigen::Index kRows = 20'011;
  std::string text;
  samara::io::stream_csv(
      {"row"}, kRows,
      [](Eigen::Index begin, Eigen::Index end, std::string& part) {
        for (Eigen::Index i = begin; i < end; ++i) part += std::to_string(i) + "\n";
      },
      [&](std::string_view part) { text += part; });
  const NumberTable read = NumberTable::parse(text, "t");
  CHECK(read.header() == std::vector<std::string>{"row"});
  CHECK(read.values() == Eigen::VectorXd::LinSpaced(kRows, 0.0, kRows - 1.0));
  CHECK_THAT(error_text<ArgumentError>([] {
               samara::io::stream_csv({"a", "a"}, 0, {}, [](std::string_view) {});
             }),
             Contains("\"a\" stands twice"));
}

TEST_CASE("the header of a table of numbers is read by itself, whatever its rows hold") {
  const auto head = NumberTable::head("# body: card\n\na;b\n1;x\n", "t");
  CHECK(head.header() == std::vector<std::string>{"a", "b"});
  CHECK(head.line_of_header() == 3);
  CHECK(head.rows() == 0);
}

TEST_CASE("plain numbers of a table are given as they stand in it") {
  const NumberTable table = NumberTable::parse("# c: d\na;b;c\r\n+1.50; 2e0 ;3\r\n4;\t5;-0.60", "t");
  REQUIRE(table.has_cells());
  std::vector<std::string_view> cells(3);
  table.read_cells(0, cells);
  CHECK(cells == std::vector<std::string_view>{"1.50", "2e0", "3"});
  table.read_cells(1, cells);
  CHECK(cells == std::vector<std::string_view>{"4", "5", "-0.60"});
  for (const char* text : {"a,b\n1,\n", "a;b\n1,5;2\n", "a\n\"1\"\n"})
    CHECK_FALSE(NumberTable::parse(text, "t").has_cells());
}

TEST_CASE("a table of numbers takes what any table may hold, and names the line of what is none") {
  const NumberTable table =
      NumberTable::parse("# body: card\r\na;b\r\n+1; 2.5 \r\n\r\n# note\r\n\"3\";\r\n", "t");
  REQUIRE(table.values().rows() == 2);
  CHECK(table.values()(0, 1) == 2.5);
  CHECK(table.values()(1, 0) == 3.0);
  CHECK(std::isnan(table.values()(1, 1)));
  CHECK(std::string(table.error(1, "is wrong").what()) == "t:6: is wrong");
  const auto error = [](const std::string& text) {
    return error_text<samara::InputError>([&] { NumberTable::parse(text, "t"); });
  };
  CHECK_THAT(error("a,b\n1,2\n3,x\n"), Contains("t:3") && Contains("x"));
  CHECK_THAT(error("a,b\n1,2\n3\n"), Contains("t:3"));
  CHECK_THAT(error("a,b\n1,inf\n"), Contains("t:2") && Contains("inf"));
  CHECK(std::isnan(NumberTable::parse("a,b\n1,nan\n", "t").values()(0, 1)));
  CHECK_THAT(error("a,b\n1,2 3\n"), Contains("t:2"));
  CHECK_THAT(error("a,b\n1,+-2\n"), Contains("t:2") && Contains("+-2"));
  CHECK_THAT(error(""), Contains("empty"));
  CHECK(NumberTable::parse("a,b\n", "t").values().rows() == 0);
}

TEST_CASE("a table of numbers finds the header where any table has it") {
  const NumberTable marked = NumberTable::parse("\xEF\xBB\xBF# body: card\na,b\n1,2\n3,4\n", "t");
  CHECK(marked.header() == std::vector<std::string>{"a", "b"});
  CHECK(marked.values().rows() == 2);
  // A comment begins with its sign; a name may have it after a blank.
  const NumberTable named = NumberTable::parse(" #t,x\n1,2\n3,4\n", "t");
  CHECK(named.header() == std::vector<std::string>{"#t", "x"});
  CHECK(named.values().rows() == 2);
}

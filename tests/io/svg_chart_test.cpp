#include "samara/io/svg_chart.h"

#include <cmath>
#include <limits>
#include <string>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using samara::io::svg_charts;
using samara::io::SvgPanel;
using Kind = samara::io::SvgSeries::Kind;

namespace {

int occurrences(const std::string& text, const std::string& part) {
  int found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

SvgPanel panel_of(const Eigen::VectorXd& x, const Eigen::VectorXd& y, Kind kind = Kind::line) {
  return {
      .title = "a", .x_label = "b", .y_label = "c", .series = {{.name = "d", .x = x, .y = y, .kind = kind}}};
}

}  // namespace

TEST_CASE("gaps part a line, and are no points") {
  const double nan = std::nan("");
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(5, 0.0, 4.0);
  Eigen::VectorXd y(5);
  y << 0.0, 1.0, nan, 1.0, 0.0;
  const std::string line = svg_charts("", {panel_of(x, y)}, 1);
  const auto begin = line.find("stroke-width=\"1.8\"");
  const std::string path = line.substr(line.rfind("<path", begin), begin - line.rfind("<path", begin));
  CHECK(occurrences(path, "M") == 2);
  CHECK(occurrences(path, "L") == 2);
  CHECK(occurrences(svg_charts("", {panel_of(x, y, Kind::points)}, 1), "r=\"2.6\"") == 4);
  SvgPanel logarithmic = panel_of(x, Eigen::VectorXd::LinSpaced(5, 0.0, 1.0), Kind::points);
  logarithmic.has_log_y = true;
  CHECK(occurrences(svg_charts("", {logarithmic}, 1), "r=\"2.6\"") == 4);
}

TEST_CASE("what a picture says is text, whatever it holds") {
  SvgPanel panel = panel_of(Eigen::Vector2d(0.0, 1.0), Eigen::Vector2d(0.0, 1.0));
  panel.title = panel.series[0].name = "<script>&\"";
  const std::string picture = svg_charts("<b>\x01", {panel}, 1);
  CHECK(picture.find('\x01') == std::string::npos);  // no XML may hold it
  CHECK(picture.find("<script>") == std::string::npos);
  CHECK(picture.find("&lt;b&gt;") != std::string::npos);
}

TEST_CASE("panels of nothing, and of one value, have axes") {
  for (const double value : {0.0, 3.0, -1e-30, 1e300, 1e308, std::nan("")}) {
    const std::string picture = svg_charts(
        "", {panel_of(Eigen::VectorXd::Constant(2, value), Eigen::VectorXd::Constant(2, value))}, 3);
    CHECK(picture.find("nan") == std::string::npos);
    CHECK(picture.find("inf") == std::string::npos);
  }
  // The range of the axis is no double.
  const Eigen::Vector3d far(0.0, 1e308, -1e308);
  CHECK(svg_charts("", {panel_of(Eigen::Vector3d(0.0, 1.0, 2.0), far)}, 1).find("nan") == std::string::npos);
  // All but the last bit constant, as what is held by a computation.
  for (const double value : {1.0, 9.81, -3e8, 5e-324}) {
    const Eigen::Vector2d nearly(value, std::nextafter(value, 1e9));
    CHECK(svg_charts("", {panel_of(nearly, nearly)}, 1).size() < 10000);
  }
  CHECK_THROWS_AS(svg_charts("", {}, 1), samara::ArgumentError);
  CHECK_THROWS_AS(svg_charts("", {panel_of(Eigen::Vector2d(0, 1), Eigen::Vector3d(0, 1, 2))}, 1),
                  samara::ArgumentError);
}

TEST_CASE("ticks that differ have labels that differ") {
  const std::string picture =
      svg_charts("", {panel_of(Eigen::Vector2d(100.01, 100.05), Eigen::Vector2d(-250000.0, -249998.0))}, 1);
  CHECK(occurrences(picture, ">100<") == 0);
  CHECK(occurrences(picture, ">100.02<") == 1);
  CHECK(occurrences(picture, ">-2.5e+05<") == 0);
  CHECK(occurrences(picture, ">-249999<") == 1);
}

#include "scatter.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace samara::benchmarks::identification {

namespace {

constexpr double kWidth = 460.0, kHeight = 340.0;  ///< of a frame
constexpr double kLeft = 75.0, kTop = 70.0, kBottom = 60.0, kGap = 25.0;

/// Round numbers that hold all values, and the step between ticks.
struct Scale {
  double lower = 0.0, upper = 1.0, step = 0.2;
};

Scale scale_of(const Panel& panel, Eigen::Index axis) {
  double lower = 0.0, upper = 0.0;
  for (const Points& points : panel.series) {
    for (const Eigen::Vector2d& point : points.at) {
      lower = std::min(lower, point[axis]);
      upper = std::max(upper, point[axis]);
    }
  }
  const double rough = std::max(upper - lower, 1e-300) / 6.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0}) step = factor * power >= rough ? factor * power : step;
  return {step * std::floor(lower / step), step * std::ceil(upper / step), step};
}

/// A panel whose frame begins at `left`.
class Drawing {
 public:
  Drawing(const Panel& panel, double left)
      : panel_(panel), left_(left), x_(scale_of(panel, 0)), y_(scale_of(panel, 1)) {}

  std::string operator()() {
    draw_frame();
    if (panel_.with_diagonal) draw_diagonal();
    draw_points();
    return svg_;
  }

 private:
  double right_of(double x) const { return left_ + kWidth * (x - x_.lower) / (x_.upper - x_.lower); }
  double down_to(double y) const { return kTop + kHeight * (y_.upper - y) / (y_.upper - y_.lower); }

  template <class... Parts>
  void add(fmt::format_string<Parts...> text, Parts&&... parts) {
    svg_ += fmt::format(text, std::forward<Parts>(parts)...) + "\n";
  }

  void draw_frame() {
    add(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="none" stroke="#555"/>)", left_,
        kTop, kWidth, kHeight);
    for (double x = x_.lower; x < x_.upper + 0.5 * x_.step; x += x_.step) {
      add(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="middle">{:g}</text>)", right_of(x), kTop + kHeight + 18,
          x);
    }
    for (double y = y_.lower; y < y_.upper + 0.5 * y_.step; y += y_.step) {
      add(R"(<path d="M{:.1f} {:.1f}h{:.1f}" stroke="#ddd"/>)", left_, down_to(y), kWidth);
      add(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="end">{:g}</text>)", left_ - 6, down_to(y) + 4, y);
    }
    add(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="middle">{}</text>)", left_ + 0.5 * kWidth,
        kTop + kHeight + 42, panel_.x_label);
    add(R"svg(<text transform="translate({:.1f} {:.1f}) rotate(-90)" text-anchor="middle">{}</text>)svg",
        left_ - 52, kTop + 0.5 * kHeight, panel_.y_label);
  }

  void draw_diagonal() {
    const double lower = std::max(x_.lower, y_.lower), upper = std::min(x_.upper, y_.upper);
    add(R"(<path d="M{:.1f} {:.1f}L{:.1f} {:.1f}" stroke="#999" stroke-dasharray="5 4"/>)", right_of(lower),
        down_to(lower), right_of(upper), down_to(upper));
  }

  void draw_points() {
    double key = left_;
    for (const Points& points : panel_.series) {
      add(R"(<circle cx="{:.1f}" cy="{:.1f}" r="4" fill="{}"/><text x="{:.1f}" y="{:.1f}">{}</text>)",
          key + 6, kTop - 14, points.color, key + 16, kTop - 10, points.name);
      key += 230.0;
      for (const Eigen::Vector2d& point : points.at) {
        add(R"(<circle cx="{:.1f}" cy="{:.1f}" r="3" fill="{}" fill-opacity="0.7"/>)", right_of(point.x()),
            down_to(point.y()), points.color);
      }
    }
  }

  const Panel& panel_;
  double left_;
  Scale x_, y_;
  std::string svg_;
};

}  // namespace

std::string scatter_svg(const std::string& title, const std::vector<Panel>& panels) {
  const double each = kLeft + kWidth + kGap;
  const double width = each * static_cast<double>(panels.size());
  std::string svg = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="{:.0f}" height="{:.0f}" font-family="sans-serif" font-size="13">
<rect width="100%" height="100%" fill="white"/>
<text x="{:.0f}" y="28" font-size="16">{}</text>
)",
      width, kTop + kHeight + kBottom, kLeft, title);
  for (std::size_t k = 0; k < panels.size(); ++k) {
    svg += Drawing(panels[k], each * static_cast<double>(k) + kLeft)();
  }
  return svg + "</svg>\n";
}

}  // namespace samara::benchmarks::identification

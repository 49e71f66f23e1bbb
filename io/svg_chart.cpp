#include "samara/io/svg_chart.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/text.h"

namespace samara::io {

namespace {

constexpr double kWidth = 400.0, kHeight = 250.0;  ///< of a frame
constexpr double kLeft = 78.0, kRight = 22.0, kBottom = 58.0, kLine = 20.0;
/// Of Okabe and Ito, Color Universal Design (2008), the darker ones first: told apart also by those who see fewer
/// colours.
constexpr std::array kPalette = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000"};

/// Room for the range of an axis and its margins.
bool can_be_drawn(double value) {
  return std::abs(value) <= 1e300;
}

const char* colour_of(const SvgSeries& series) {
  return kPalette[static_cast<std::size_t>(series.colour) % kPalette.size()];
}

/// What an axis shows, and where its ticks are.
struct SvgScale {
  double lower = 0.0, upper = 1.0;
  std::vector<double> ticks = {};
  bool is_log = false;
  int digits = 4;  ///< by which neighbouring ticks differ

  /// 0 at the lower end, 1 at the upper.
  double share(double value) const {
    return is_log ? std::max(0.0, std::log(value / lower) / std::log(upper / lower))
                  : (value - lower) / (upper - lower);
  }
};

SvgScale round_scale(double lower, double upper) {
  const double largest = std::max(std::abs(lower), std::abs(upper));
  // Less than rounding makes of a constant is one.
  if (!(upper - lower > 1e-12 * largest)) {
    const double half = largest < 1e-300 ? 0.5 : 0.05 * largest;
    lower -= half;
    upper += half;
  }
  const double rough = (upper - lower) / 5.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0}) step = factor * power >= rough ? factor * power : step;
  SvgScale scale{.lower = lower, .upper = upper};
  const double first = std::ceil(lower / step - 1e-9);
  for (int k = 0; (first + k) * step <= upper + 1e-9 * step; ++k) scale.ticks.push_back((first + k) * step);
  const auto place_of = [](double value) { return static_cast<int>(std::floor(std::log10(value) + 1e-9)); };
  scale.digits = std::max(4, place_of(std::max(std::abs(lower), std::abs(upper))) - place_of(step) + 1);
  return scale;
}

/// About its middle.
SvgScale widened(const SvgScale& scale, double range) {
  const double middle = 0.5 * scale.lower + 0.5 * scale.upper;
  return round_scale(middle - 0.5 * range, middle + 0.5 * range);
}

SvgScale decades(double lower, double upper) {
  const double first = std::floor(std::log10(lower));
  const double last = std::max(first + 1.0, std::ceil(std::log10(upper)));
  SvgScale scale{.lower = std::pow(10.0, first), .upper = std::pow(10.0, last), .is_log = true};
  const double stride = std::ceil((last - first) / 6.0);
  for (double k = first; k <= last + 0.5; k += stride) scale.ticks.push_back(std::pow(10.0, k));
  return scale;
}

SvgScale scale_of(const SvgPanel& panel, bool of_y) {
  const bool is_log = of_y && panel.has_log_y;
  double lower = INFINITY, upper = -INFINITY;
  const auto take = [&](double value) {
    if (!can_be_drawn(value) || (is_log && value <= 0.0)) return;
    lower = std::min(lower, value);
    upper = std::max(upper, value);
  };
  for (const SvgSeries& series : panel.series)
    for (const double value : of_y ? series.y : series.x) take(value);
  for (const SvgRule& rule : panel.rules)
    if (rule.is_vertical != of_y) take(rule.at);
  if (panel.from_zero && !is_log) take(0.0);
  if (!(upper >= lower)) return is_log ? decades(0.1, 1.0) : round_scale(0.0, 1.0);
  // Eight decades show what is large; what is smaller lies on the lower end.
  if (is_log) return decades(std::max(lower, 1e-8 * upper), upper);
  const double room = of_y ? 0.05 * (upper - lower) : 0.0;
  return round_scale(lower - (panel.from_zero && lower == 0.0 ? 0.0 : room), upper + room);
}

/// Entries of the key, in lines as wide as a frame.
std::vector<std::vector<const SvgSeries*>> key_of(const SvgPanel& panel) {
  std::vector<std::vector<const SvgSeries*>> lines;
  double width = INFINITY;
  for (const SvgSeries& series : panel.series) {
    if (series.name.empty()) continue;
    const double own = 46.0 + 7.0 * static_cast<double>(series.name.size());
    if (width + own > kWidth) {
      lines.emplace_back();
      width = 0.0;
    }
    lines.back().push_back(&series);
    width += own;
  }
  return lines;
}

class PanelDrawing {
 public:
  PanelDrawing(const SvgPanel& panel, double left, double top)
      : panel_(panel), left_(left), top_(top), x_(scale_of(panel, false)), y_(scale_of(panel, true)) {
    if (!panel.has_equal_scales) return;
    const double unit = std::max((x_.upper - x_.lower) / kWidth, (y_.upper - y_.lower) / kHeight);
    x_ = widened(x_, unit * kWidth);
    y_ = widened(y_, unit * kHeight);
  }

  std::string operator()(double head) {
    draw_frame(head);
    draw_key();
    if (panel_.with_diagonal) draw_diagonal();
    for (const SvgRule& rule : panel_.rules) draw_rule(rule);
    for (const SvgSeries& series : panel_.series) draw_series(series);
    return std::move(svg_);
  }

 private:
  double right_of(double x) const { return left_ + kWidth * x_.share(x); }
  double down_to(double y) const { return top_ + kHeight * (1.0 - y_.share(y)); }

  template <class... Parts>
  void add(fmt::format_string<Parts...> text, Parts&&... parts) {
    svg_ += fmt::format(text, std::forward<Parts>(parts)...) + "\n";
  }

  void draw_frame(double head) {
    add(R"(<text x="{:.1f}" y="{:.1f}" font-weight="bold">{}</text>)", left_, top_ - head + 14.0,
        escaped_for_markup(panel_.title));
    for (const double x : x_.ticks) {
      add(R"(<path d="M{:.1f} {:.1f}v5" stroke="#555"/>)", right_of(x), top_ + kHeight);
      add(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="middle">{:.{}g}</text>)", right_of(x),
          top_ + kHeight + 19.0, x + 0.0, x_.digits);
    }
    for (const double y : y_.ticks) {
      add(R"(<path d="M{:.1f} {:.1f}h{:.1f}" stroke="#e2e2e2"/>)", left_, down_to(y), kWidth);
      add(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="end">{:.{}g}</text>)", left_ - 7.0, down_to(y) + 4.0,
          y + 0.0, y_.digits);
    }
    add(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" fill="none" stroke="#555"/>)", left_,
        top_, kWidth, kHeight);
    add(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="middle">{}</text>)", left_ + 0.5 * kWidth,
        top_ + kHeight + 42.0, escaped_for_markup(panel_.x_label));
    add(R"svg(<text transform="translate({:.1f} {:.1f}) rotate(-90)" text-anchor="middle">{}</text>)svg",
        left_ - 58.0, top_ + 0.5 * kHeight, escaped_for_markup(panel_.y_label));
  }

  void draw_key() {
    const auto lines = key_of(panel_);
    double y = top_ - kLine * static_cast<double>(lines.size()) + 12.0;
    for (const auto& line : lines) {
      double x = left_;
      for (const SvgSeries* series : line) {
        if (series->kind == SvgSeries::Kind::points) {
          add(R"(<circle cx="{:.1f}" cy="{:.1f}" r="3.5" fill="{}"/>)", x + 12.0, y - 4.0,
              colour_of(*series));
        } else {
          add(R"(<path d="M{:.1f} {:.1f}h24" stroke="{}" stroke-width="2"{}/>)", x, y - 4.0,
              colour_of(*series), dashes(*series));
        }
        add(R"(<text x="{:.1f}" y="{:.1f}">{}</text>)", x + 30.0, y, escaped_for_markup(series->name));
        x += 46.0 + 7.0 * static_cast<double>(series->name.size());
      }
      y += kLine;
    }
  }

  static const char* dashes(const SvgSeries& series) {
    return series.kind == SvgSeries::Kind::dashes ? " stroke-dasharray=\"6 4\"" : "";
  }

  void draw_diagonal() {
    const double lower = std::max(x_.lower, y_.lower), upper = std::min(x_.upper, y_.upper);
    add(R"(<path d="M{:.1f} {:.1f}L{:.1f} {:.1f}" stroke="#999" stroke-dasharray="5 4"/>)", right_of(lower),
        down_to(lower), right_of(upper), down_to(upper));
  }

  void draw_rule(const SvgRule& rule) {
    if (!can_be_drawn(rule.at)) return;
    if (rule.is_vertical) {
      add(R"(<path d="M{:.1f} {:.1f}v{:.1f}" stroke="#777" stroke-dasharray="3 3"/>)", right_of(rule.at),
          top_, kHeight);
    } else {
      add(R"(<path d="M{:.1f} {:.1f}h{:.1f}" stroke="#777" stroke-dasharray="3 3"/>)", left_,
          down_to(rule.at), kWidth);
    }
  }

  bool is_shown(double x, double y) const {
    return can_be_drawn(x) && can_be_drawn(y) && (!panel_.has_log_y || y > 0.0);
  }

  void draw_series(const SvgSeries& series) {
    std::string path;
    bool is_drawing = false;
    for (Eigen::Index i = 0; i < series.x.size(); ++i) {
      const double x = series.x[i], y = series.y[i];
      if (!is_shown(x, y)) {
        is_drawing = false;
      } else if (series.kind == SvgSeries::Kind::points) {
        add(R"(<circle cx="{:.1f}" cy="{:.1f}" r="2.6" fill="{}" fill-opacity="0.75"/>)", right_of(x),
            down_to(y), colour_of(series));
      } else {
        path += fmt::format("{}{:.1f} {:.1f}", is_drawing ? 'L' : 'M', right_of(x), down_to(y));
        is_drawing = true;
      }
    }
    if (!path.empty())
      add(R"(<path d="{}" fill="none" stroke="{}" stroke-width="1.8" stroke-linejoin="round"{}/>)", path,
          colour_of(series), dashes(series));
  }

  const SvgPanel& panel_;
  double left_, top_;
  SvgScale x_, y_;
  std::string svg_;
};

}  // namespace

std::string svg_charts(const std::string& title, const std::vector<SvgPanel>& panels, int columns) {
  if (panels.empty() || columns < 1)
    throw ArgumentError(
        fmt::format("a picture of {} panels in {} columns was asked for, expected at least one of each",
                    panels.size(), columns));
  std::size_t key_lines = 0;
  for (const SvgPanel& panel : panels) {
    key_lines = std::max(key_lines, key_of(panel).size());
    for (const SvgSeries& series : panel.series) {
      if (series.x.size() != series.y.size())
        throw ArgumentError(fmt::format("series \"{}\" has {} places and {} values, expected as many",
                                        series.name, series.x.size(), series.y.size()));
    }
  }
  const double head = 26.0 + kLine * static_cast<double>(key_lines);  // of a panel: its title and key
  const double title_height = title.empty() ? 8.0 : 40.0;
  const auto count = std::ssize(panels);
  const auto across = std::min<std::ptrdiff_t>(columns, count);
  const auto rows = (count + across - 1) / across;
  const double cell_width = kLeft + kWidth + kRight, cell_height = head + kHeight + kBottom;
  const double width = cell_width * static_cast<double>(across);
  const double height = title_height + cell_height * static_cast<double>(rows);
  std::string svg = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0:.0f}" height="{1:.0f}" viewBox="0 0 {0:.0f} {1:.0f}" font-family="sans-serif" font-size="13">
<rect width="100%" height="100%" fill="white"/>
)",
      width, height);
  if (!title.empty())
    svg += fmt::format("<text x=\"{:.0f}\" y=\"26\" font-size=\"16\">{}</text>\n", 20.0,
                       escaped_for_markup(title));
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const double left = kLeft + cell_width * static_cast<double>(k % across);
    const double top = title_height + head + cell_height * static_cast<double>(k / across);
    svg += PanelDrawing(panels[static_cast<std::size_t>(k)], left, top)(head);
  }
  return svg + "</svg>\n";
}

}  // namespace samara::io

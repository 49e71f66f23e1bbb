#include "cloud_picture.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <vector>

#include <fmt/format.h>

namespace samara::apps {

namespace {

using Outline = std::vector<Eigen::Vector2d>;

constexpr double kPanelWidth = 460.0, kPanelHeight = 400.0, kMargin = 56.0;

/// One diagram with equal scales on both axes.
class Panel {
 public:
  Panel(double left, std::string title, std::string across, std::string up)
      : left_(left), title_(std::move(title)), across_(std::move(across)), up_(std::move(up)) {}

  /// To be called with all that is drawn, before it is.
  void include(const Outline& points) {
    for (const Eigen::Vector2d& point : points) {
      if (!point.allFinite()) continue;
      low_ = low_.cwiseMin(point);
      high_ = high_.cwiseMax(point);
    }
  }

  void frame(std::string& svg) {
    if (!(low_.array() <= high_.array()).all()) {
      fmt::format_to(std::back_inserter(svg),
                     R"(<text x="{:.1f}" y="{:.1f}" text-anchor="middle">nothing to show</text>)",
                     left_ + 0.5 * kPanelWidth, 0.5 * kPanelHeight);
      return;
    }
    const Eigen::Vector2d middle = 0.5 * (low_ + high_);
    const Eigen::Vector2d room(kPanelWidth - 2.0 * kMargin, kPanelHeight - 2.0 * kMargin);
    const Eigen::Vector2d size = (high_ - low_).cwiseMax(1e-6);
    scale_ = (room.array() / size.array()).minCoeff() / 1.08;
    origin_ = {left_ + 0.5 * kPanelWidth - scale_ * middle.x(), 0.5 * kPanelHeight + scale_ * middle.y()};
    const Eigen::Vector2d half = 0.5 / scale_ * room;
    const double tick = tick_of(2.0 * half.maxCoeff());
    auto out = std::back_inserter(svg);
    fmt::format_to(out, R"(<text class="title" x="{:.1f}" y="24" text-anchor="middle">{}</text>)",
                   left_ + 0.5 * kPanelWidth, title_);
    const double x_end = left_ + kPanelWidth - kMargin, y_end = kPanelHeight - kMargin;
    fmt::format_to(out, R"(<rect class="frame" x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}"/>)",
                   left_ + kMargin, kMargin, room.x(), room.y());
    for (const double x : ticks(middle.x() - half.x(), middle.x() + half.x(), tick)) {
      const double at = place({x, 0.0}).x();
      fmt::format_to(
          out,
          R"(<path class="frame" d="M{0:.1f} {1:.1f}v5"/><text x="{0:.1f}" y="{2:.1f}" text-anchor="middle">{3}</text>)",
          at, y_end, y_end + 19.0, label(x, tick));
    }
    for (const double y : ticks(middle.y() - half.y(), middle.y() + half.y(), tick)) {
      const double at = place({0.0, y}).y();
      fmt::format_to(
          out,
          R"(<path class="frame" d="M{0:.1f} {1:.1f}h-5"/><text x="{2:.1f}" y="{3:.1f}" text-anchor="end">{4}</text>)",
          left_ + kMargin, at, left_ + kMargin - 9.0, at + 4.0, label(y, tick));
    }
    fmt::format_to(out, R"(<text x="{:.1f}" y="{:.1f}" text-anchor="end">{}</text>)", x_end, y_end + 38.0,
                   across_);
    fmt::format_to(out, R"(<text x="{:.1f}" y="{:.1f}">{}</text>)", left_ + kMargin - 36.0, kMargin - 10.0,
                   up_);
  }

  /// A line, broken where a point is not finite.
  void line(std::string& svg, const Outline& points, const char* kind) const {
    std::string path;
    bool pen_down = false;
    for (const Eigen::Vector2d& point : points) {
      if (point.allFinite()) {
        const Eigen::Vector2d at = place(point);
        fmt::format_to(std::back_inserter(path), "{}{:.1f} {:.1f}", pen_down ? "L" : "M", at.x(), at.y());
      }
      pen_down = point.allFinite();
    }
    if (!path.empty()) fmt::format_to(std::back_inserter(svg), R"(<path class="{}" d="{}"/>)", kind, path);
  }

  void dots(std::string& svg, const Outline& points) const {
    for (const Eigen::Vector2d& point : points) {
      const Eigen::Vector2d at = place(point);
      fmt::format_to(std::back_inserter(svg), R"(<circle class="dot" cx="{:.1f}" cy="{:.1f}" r="2"/>)",
                     at.x(), at.y());
    }
  }

 private:
  Eigen::Vector2d place(const Eigen::Vector2d& point) const {
    return {origin_.x() + scale_ * point.x(), origin_.y() - scale_ * point.y()};
  }

  /// About six steps of 1, 2 or 5 over a range.
  static double tick_of(double range) {
    const double step = std::pow(10.0, std::floor(std::log10(range / 6.0)));
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (range / (factor * step) <= 8.0) return factor * step;
    }
    return 10.0 * step;
  }
  /// Multiples of `tick` in a range, which may be finer than doubles are there: counted, so that they come to an end.
  static std::vector<double> ticks(double from, double to, double tick) {
    constexpr int kMost = 20;
    std::vector<double> all;
    const double first = std::ceil(from / tick);
    for (int i = 0; i < kMost; ++i) {
      const double at = tick * (first + i);
      if (at > to) break;
      if (all.empty() || at > all.back()) all.push_back(at);
    }
    return all;
  }
  static std::string label(double value, double tick) {
    return fmt::format("{:.4g}", std::abs(value) < 1e-9 * tick ? 0.0 : value);
  }

  double left_;
  std::string title_, across_, up_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high_ = -low_;
  double scale_ = 1.0;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
};

/// An ellipse of one standard deviation.
Outline ellipse(const Eigen::Vector2d& middle, const Eigen::Matrix2d& covariance) {
  // By Cholesky's factor, which maps the circle to it.
  const double a = std::sqrt(covariance(0, 0));
  const double b = a > 0.0 ? covariance(1, 0) / a : 0.0;
  const double c = std::sqrt(std::max(0.0, covariance(1, 1) - b * b));
  Outline points;
  for (int i = 0; i <= 48; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 48.0;
    points.emplace_back(middle +
                        Eigen::Vector2d(a * std::cos(angle), b * std::cos(angle) + c * std::sin(angle)));
  }
  return points;
}

/// What the side view draws.
struct SideView {
  std::vector<Outline> paths;
  Outline mean;
  std::vector<Outline> ellipses;
  Outline ground;
};

SideView side_view(const models::Ensemble& cloud, const models::GustLayout& layout,
                   std::optional<double> ground) {
  SideView view;
  const int across = layout.position().front(), up = layout.position().back();
  double least = 0.0, most = 0.0;
  for (const Eigen::MatrixXd& kept : cloud.kept) {
    Outline path;
    for (Eigen::Index k = 0; k < kept.rows(); ++k) {
      path.emplace_back(kept(k, across), kept(k, up));
      if (std::isfinite(kept(k, across))) {
        least = std::min(least, kept(k, across));
        most = std::max(most, kept(k, across));
      }
    }
    view.paths.push_back(std::move(path));
  }
  std::vector<std::string> place = {"x", "y"};
  if (layout.space() != models::GustLayout::Space::plane) place.emplace_back("z");
  const bool of_place = cloud.states == place;
  const auto last = static_cast<Eigen::Index>(cloud.states.size()) - 1;
  for (Eigen::Index k = 0; of_place && k < cloud.times.size(); ++k) {
    // A mean over the few that still fly is no path of the cloud.
    if (2 * cloud.flying[k] < cloud.realisations()) break;
    view.mean.emplace_back(cloud.mean(k, 0), cloud.mean(k, last));
    if (k > 0 && k % std::max<Eigen::Index>(1, cloud.times.size() / 8) == 0) {
      const Eigen::MatrixXd& all = cloud.covariance[static_cast<std::size_t>(k)];
      Eigen::Matrix2d covariance;
      covariance << all(0, 0), all(0, last), all(last, 0), all(last, last);
      if (covariance.allFinite()) view.ellipses.push_back(ellipse(view.mean.back(), covariance));
    }
  }
  if (ground) view.ground = {{least, *ground}, {most, *ground}};
  return view;
}

}  // namespace

std::string cloud_picture(const models::Ensemble& cloud, const models::GustLayout& layout,
                          std::optional<double> ground) {
  const bool in_plane = layout.space() == models::GustLayout::Space::plane;
  const SideView view = side_view(cloud, layout, ground);
  Outline landings;
  for (const models::Landing& landing : cloud.landings)
    landings.emplace_back(landing.position.x(), landing.position.y());
  const bool has_map = !in_plane && !landings.empty();
  std::string body;
  Panel side(0.0, "from the side", "x in m", in_plane ? "y in m" : "z in m");
  for (const Outline& path : view.paths) side.include(path);
  for (const Outline& outline : view.ellipses) side.include(outline);
  side.include(view.mean);
  side.include(view.ground);
  side.frame(body);
  side.line(body, view.ground, "ground");
  for (const Outline& path : view.paths) side.line(body, path, "path");
  for (const Outline& outline : view.ellipses) side.line(body, outline, "spread");
  side.line(body, view.mean, "mean");
  if (has_map) {
    Panel map(kPanelWidth, "landings from above", "x in m", "y in m");
    const models::LandingStatistics landing = models::landing_statistics(cloud);
    const Outline outline = ellipse(landing.mean.head<2>(), landing.covariance.topLeftCorner<2, 2>());
    map.include(landings);
    map.frame(body);
    map.dots(body, landings);
    if (cloud.landings.size() > 1) map.line(body, outline, "mean");
  }
  return fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0} {1}" width="{0}" height="{1}" role="img">
<title>{2} realisations: paths, mean with one standard deviation{3}</title>
<style>text{{font:12px sans-serif;fill:#222}}
.title{{font-size:14px}}.frame{{fill:none;stroke:#888}}
.path{{fill:none;stroke:#3b7dd8;stroke-opacity:.45}}
.mean{{fill:none;stroke:#b3261e;stroke-width:2}}
.spread{{fill:none;stroke:#b3261e;stroke-dasharray:4 3}}
.ground{{fill:none;stroke:#555;stroke-width:2}}
.dot{{fill:#3b7dd8;fill-opacity:.55}}</style>
<rect width="100%" height="100%" fill="#fff"/>
{4}
</svg>
)",
      has_map ? 2.0 * kPanelWidth : kPanelWidth, kPanelHeight, cloud.realisations(),
      has_map ? ", landing places" : "", body);
}

}  // namespace samara::apps

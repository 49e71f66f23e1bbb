#include "air/cloud_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/io/svg_chart.h"

namespace samara::apps {

namespace {

enum Colour { kLandings = 0, kMean = 1, kPaths = 4 };

/// An ellipse of one standard deviation.
io::SvgSeries ellipse(const Eigen::Vector2d& middle, const Eigen::Matrix2d& covariance, std::string name) {
  // By Cholesky's factor, which maps the circle to it.
  const double a = std::sqrt(covariance(0, 0));
  const double b = a > 0.0 ? covariance(1, 0) / a : 0.0;
  const double c = std::sqrt(std::max(0.0, covariance(1, 1) - b * b));
  const Eigen::ArrayXd angle = Eigen::ArrayXd::LinSpaced(49, 0.0, 2.0 * std::numbers::pi);
  return {.name = std::move(name),
          .x = middle.x() + a * angle.cos(),
          .y = middle.y() + b * angle.cos() + c * angle.sin(),
          .kind = io::SvgSeries::Kind::dashes,
          .colour = kMean};
}

constexpr const char* kSpread = "one standard deviation";

/// The mean path with the spread about it: nothing where the statistics are not those of the place.
std::vector<io::SvgSeries> mean_path(const models::Ensemble& cloud, const models::GustLayout& layout) {
  std::vector<std::string> place = {"x", "y"};
  if (layout.space() != models::GustLayout::Space::plane) place.emplace_back("z");
  std::vector<io::SvgSeries> all;
  if (cloud.states != place) return all;
  const auto last = static_cast<Eigen::Index>(place.size()) - 1;
  Eigen::Index shown = 0;
  // A mean over the few that still fly is no path of the cloud.
  while (shown < cloud.times.size() && 2 * cloud.flying[shown] >= cloud.realisations()) ++shown;
  const Eigen::Index stride = std::max<Eigen::Index>(1, cloud.times.size() / 8);
  for (Eigen::Index k = stride; k < shown; k += stride) {
    const Eigen::MatrixXd& covariance = cloud.covariance[static_cast<std::size_t>(k)];
    const std::array both = {Eigen::Index{0}, last};
    if (!covariance.allFinite()) continue;
    all.push_back(
        ellipse({cloud.mean(k, 0), cloud.mean(k, last)}, covariance(both, both), all.empty() ? kSpread : ""));
  }
  all.push_back({.name = "mean",
                 .x = cloud.mean.col(0).head(shown),
                 .y = cloud.mean.col(last).head(shown),
                 .colour = kMean});
  return all;
}

}  // namespace

std::string cloud_picture(const models::Ensemble& cloud, const models::GustLayout& layout,
                          std::optional<double> ground) {
  const bool in_plane = layout.space() == models::GustLayout::Space::plane;
  std::vector<io::SvgPanel> panels = {{.title = "from the side",
                                       .x_label = "x [m]",
                                       .y_label = in_plane ? "y [m]" : "z [m]",
                                       .series = {},
                                       .has_equal_scales = true}};
  io::SvgPanel& side = panels.front();
  for (const Eigen::MatrixXd& kept : cloud.kept) {
    side.series.push_back({.name = side.series.empty() ? "paths" : "",
                           .x = kept.col(layout.position().front()),
                           .y = kept.col(layout.position().back()),
                           .colour = kPaths});
  }
  for (io::SvgSeries& series : mean_path(cloud, layout)) side.series.push_back(std::move(series));
  if (ground) side.rules.push_back({.at = *ground});
  if (in_plane || cloud.landings.empty())
    return io::svg_charts(fmt::format("{} realisations", cloud.realisations()), panels, 2);
  io::SvgSeries landings{
      .name = {}, .x = {}, .y = {}, .kind = io::SvgSeries::Kind::points, .colour = kLandings};
  landings.x.resize(std::ssize(cloud.landings));
  landings.y.resize(std::ssize(cloud.landings));
  for (Eigen::Index i = 0; i < landings.x.size(); ++i) {
    const models::Landing& landing = cloud.landings[static_cast<std::size_t>(i)];
    landings.x[i] = landing.position.x();
    landings.y[i] = landing.position.y();
  }
  io::SvgPanel map{.title = "landings from above",
                   .x_label = "x [m]",
                   .y_label = "y [m]",
                   .series = {std::move(landings)},
                   .has_equal_scales = true};
  if (cloud.landings.size() > 1) {
    const models::LandingStatistics landing = models::landing_statistics(cloud);
    map.series.push_back(ellipse(landing.mean.head<2>(), landing.covariance.topLeftCorner<2, 2>(), kSpread));
  }
  panels.push_back(std::move(map));
  return io::svg_charts(fmt::format("{} realisations", cloud.realisations()), panels, 2);
}

}  // namespace samara::apps

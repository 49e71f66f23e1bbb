#include "samara/flow/files/flow_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/require.h"

namespace samara::flow {

namespace {

using io::Colour;

constexpr Colour kBody = {110, 110, 110}, kInk = {20, 20, 20}, kPaper = {255, 255, 255},
                 kLine = {245, 245, 245};
constexpr int kBarWidth = 24, kBarGap = 20, kLabelWidth = 130, kMargin = 14, kHeading = 28;

/// Dark blue over green to yellow, even in lightness, also for those who see two colours (after viridis, of S. van der
/// Walt and N. Smith).
Colour colour_of(double share) {
  constexpr std::array<std::array<double, 3>, 9> kStops = {{{68, 1, 84},
                                                            {71, 44, 122},
                                                            {59, 81, 139},
                                                            {44, 113, 142},
                                                            {33, 144, 141},
                                                            {39, 173, 129},
                                                            {92, 200, 99},
                                                            {170, 220, 50},
                                                            {253, 231, 37}}};
  const double place = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kStops.size() - 2);
  Colour colour;
  for (std::size_t part = 0; part < 3; ++part) {
    const double along = place - static_cast<double>(below);
    colour[part] = static_cast<std::uint8_t>(
        std::lround((1.0 - along) * kStops[below][part] + along * kStops[below + 1][part]));
  }
  return colour;
}

CentreField shown_field(const StoredFlow& flow, const std::string& name) {
  if (name != "speed") return flow.field(name);
  CentreField speed{"speed", "U", flow.grid.field()};
  for (const CentreField& field : flow.fields) {
    if (field.name != "u" && field.name != "v" && field.name != "w") continue;
    for (std::size_t c = 0; c < speed.values.size(); ++c)
      speed.values[c] = std::hypot(speed.values[c], field.values[c]);
  }
  return speed;
}

/// One layer of the domain in pixels.
class Canvas {
 public:
  Canvas(const StoredFlow& flow, int scale)
      : flow_(flow),
        scale_(scale),
        layer_(flow.grid.cells[2] / 2),
        image(scale * flow.grid.cells[0] + 2 * kMargin + kBarGap + kBarWidth + kLabelWidth,
              scale * flow.grid.cells[1] + 2 * kMargin + kHeading, kPaper) {}

  bool is_open(int i, int j) const { return flow_.open[cell(i, j)] >= 0.5; }
  std::size_t cell(int i, int j) const { return static_cast<std::size_t>(flow_.grid.at(i, j, layer_)); }

  void fill(const Field& values, double low, double high) {
    for (int j = 0; j < flow_.grid.cells[1]; ++j) {
      for (int i = 0; i < flow_.grid.cells[0]; ++i) {
        const Colour colour = is_open(i, j) ? colour_of((values[cell(i, j)] - low) / (high - low)) : kBody;
        for (int y = 0; y < scale_; ++y) {
          for (int x = 0; x < scale_; ++x)
            image.set(kMargin + i * scale_ + x,
                      kMargin + kHeading + (flow_.grid.cells[1] - 1 - j) * scale_ + y, colour);
        }
      }
    }
  }

  /// Between places in cells from the lower corner.
  void draw(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const double top = kMargin + kHeading + scale_ * flow_.grid.cells[1];
    image.draw_line(kMargin + scale_ * from.x(), top - scale_ * from.y(), kMargin + scale_ * to.x(),
                    top - scale_ * to.y(), kLine);
  }

  void draw_bar(double low, double high, const std::string& unit) {
    const int left = kMargin + scale_ * flow_.grid.cells[0] + kBarGap, top = kMargin + kHeading;
    const int height = scale_ * flow_.grid.cells[1];
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < kBarWidth; ++x) image.set(left + x, top + y, colour_of(1.0 - (y + 0.5) / height));
    }
    constexpr int kTicks = 5;
    for (int tick = 0; tick < kTicks; ++tick) {
      const double share = static_cast<double>(tick) / (kTicks - 1);
      const int y = top + static_cast<int>(std::lround((1.0 - share) * (height - 14)));
      image.write_text(left + kBarWidth + 8, y, fmt::format("{:.3g}", low + share * (high - low)), kInk);
    }
    image.write_text(left, kMargin, unit, kInk);
  }

 private:
  const StoredFlow& flow_;
  int scale_, layer_;

 public:
  io::Picture image;
};

/// Bilinear between centres; places in cells from the lower corner.
Eigen::Vector2d velocity_at(const StoredFlow& flow, const Canvas& canvas, const CentreField& u,
                            const CentreField& v, const Eigen::Vector2d& place) {
  const double x = std::clamp(place.x() - 0.5, 0.0, flow.grid.cells[0] - 1.001);
  const double y = std::clamp(place.y() - 0.5, 0.0, flow.grid.cells[1] - 1.001);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const double a = x - i, b = y - j;
  const auto between = [&](const Field& f) {
    return (1 - b) * ((1 - a) * f[canvas.cell(i, j)] + a * f[canvas.cell(i + 1, j)]) +
           b * ((1 - a) * f[canvas.cell(i, j + 1)] + a * f[canvas.cell(i + 1, j + 1)]);
  };
  return {between(u.values), between(v.values)};
}

void draw_streamline(const StoredFlow& flow, Canvas& canvas, const CentreField& u, const CentreField& v,
                     const Eigen::Vector2d& start, double way) {
  Eigen::Vector2d place = start;
  constexpr double kStep = 0.4;  // cells
  const int most = 8 * (flow.grid.cells[0] + flow.grid.cells[1]);
  for (int step = 0; step < most; ++step) {
    const Eigen::Vector2d first = velocity_at(flow, canvas, u, v, place);
    if (first.norm() < 1e-4) return;
    const Eigen::Vector2d second = velocity_at(flow, canvas, u, v, place + way * kStep * first.normalized());
    if (second.norm() < 1e-4 || (first.normalized() + second.normalized()).norm() < 1e-4) return;
    const Eigen::Vector2d next =
        place + way * kStep * (first.normalized() + second.normalized()).normalized();
    const int i = static_cast<int>(std::floor(next.x())), j = static_cast<int>(std::floor(next.y()));
    if (i < 0 || j < 0 || i >= flow.grid.cells[0] || j >= flow.grid.cells[1] || !canvas.is_open(i, j)) return;
    canvas.draw(place, next);
    place = next;
    // A closed line is drawn once.
    if (step > 20 && (place - start).norm() < 0.6) return;
  }
}

}  // namespace

io::Picture draw_flow(const StoredFlow& flow, const PictureOptions& options) {
  const CentreField shown = shown_field(flow, options.field);
  require(options.pixels_per_cell >= 0 && options.pixels_per_cell <= 64, "pixels_per_cell",
          options.pixels_per_cell, "0 to 64", "draw_flow");
  constexpr int kUsualWidth = 1200;
  const int scale =
      options.pixels_per_cell > 0 ? options.pixels_per_cell : std::max(1, kUsualWidth / flow.grid.cells[0]);
  Canvas canvas(flow, scale);
  double low = INFINITY, high = -INFINITY;
  for (int j = 0; j < flow.grid.cells[1]; ++j) {
    for (int i = 0; i < flow.grid.cells[0]; ++i) {
      if (!canvas.is_open(i, j)) continue;
      low = std::min(low, shown.values[canvas.cell(i, j)]);
      high = std::max(high, shown.values[canvas.cell(i, j)]);
    }
  }
  if (!(high > low)) high = low + 1.0;
  canvas.fill(shown.values, low, high);
  if (options.streamlines) {
    constexpr int kLines = 24;
    const CentreField &u = flow.field("u"), &v = flow.field("v");
    for (int line = 0; line < kLines; ++line)
      draw_streamline(flow, canvas, u, v, {0.5, (line + 0.5) * flow.grid.cells[1] / kLines}, 1.0);
    // The bubble is closed: no line from the inflow enters it.
    const double body_x = -flow.grid.origin.x() / flow.grid.spacing, body_y = 0.5 * flow.grid.cells[1];
    for (const double across : {-0.6, -0.3, 0.3, 0.6}) {
      const Eigen::Vector2d start(body_x + 1.0 / flow.grid.spacing, body_y + across / flow.grid.spacing);
      draw_streamline(flow, canvas, u, v, start, 1.0);
      draw_streamline(flow, canvas, u, v, start, -1.0);
    }
  }
  canvas.draw_bar(low, high, fmt::format("{} [{}]", shown.name, shown.unit));
  const FlowSummary& s = flow.summary;
  // The fields of a codebook come without loads, those of a mean that was not reached without the number.
  std::string loads;
  if (std::isfinite(s.drag)) loads += fmt::format("C_D {:.3f}  ", s.drag);
  if (std::isfinite(s.strouhal)) loads += fmt::format("St {:.3f}  ", s.strouhal);
  canvas.image.write_text(kMargin, kMargin, fmt::format("{}Re {:.3g}  {}", loads, s.reynolds, s.status),
                          kInk);
  return canvas.image;
}

}  // namespace samara::flow

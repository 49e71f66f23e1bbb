#include "samara/motion/planning/sketch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/units.h"
#include "samara/io/delimited_table.h"

namespace samara::motion {

Sketch::Sketch(Eigen::MatrixX3d points, Eigen::VectorXd times)
    : points_(std::move(points)), times_(std::move(times)) {
  const Eigen::Index count = points_.rows();
  if (count < 2) throw ArgumentError(fmt::format("the sketch has {} points, expected two or more", count));
  if (is_timed() && times_.size() != count) {
    throw ArgumentError(
        fmt::format("the sketch has {} times for {} points, expected one each", times_.size(), count));
  }
  for (Eigen::Index k = 0; k < count; ++k) {
    if (!points_.row(k).allFinite() || (is_timed() && !std::isfinite(times_[k])))
      throw ArgumentError(fmt::format("point {} of the sketch is not finite, expected numbers", k));
    if (k == 0) continue;
    if (is_timed() && !(times_[k] > times_[k - 1])) {
      throw ArgumentError(
          fmt::format("the time of point {} of the sketch is {} after {}, expected times that increase", k,
                      times_[k], times_[k - 1]));
    }
    if (!is_timed() && !(points_(k, 2) < points_(k - 1, 2))) {
      throw ArgumentError(
          fmt::format("point {} of the sketch is at height {} after {}: what falls follows a sketch that "
                      "goes down all the way, or "
                      "one with times",
                      k, points_(k, 2), points_(k - 1, 2)));
    }
  }
  keys_ = is_timed() ? times_ : -points_.col(2);
}

Eigen::Index Sketch::next_point(double key) const {
  return std::upper_bound(keys_.data(), keys_.data() + keys_.size(), key) - keys_.data();
}

Eigen::Vector3d Sketch::slope(const Eigen::Vector3d& position) const {
  if (is_timed()) return Eigen::Vector3d::Zero();
  const Eigen::Index next = next_point(-position.z());
  if (next == 0 || next == keys_.size()) return Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d along = points_.row(next) - points_.row(next - 1);
  return along / along.z();
}

Eigen::Vector3d Sketch::target(double t, const Eigen::Vector3d& position, Eigen::Index& near) const {
  const double key = is_timed() ? t : -position.z();
  const bool is_there = near > 0 && near < keys_.size() && keys_[near - 1] <= key && key < keys_[near];
  const Eigen::Index next = is_there ? near : next_point(key);
  near = next;
  Eigen::Vector3d target;
  if (next == 0) {
    target = points_.row(0);
  } else if (next == keys_.size()) {
    target = points_.row(keys_.size() - 1);
  } else {
    const double share = (key - keys_[next - 1]) / (keys_[next] - keys_[next - 1]);
    target = (1.0 - share) * points_.row(next - 1) + share * points_.row(next);
  }
  if (!is_timed()) target.z() = position.z();
  return target;
}

namespace {

template <class Path>
Sketch sampled(const Path& path, const Eigen::Vector3d& from, double bottom) {
  constexpr int kPerPeriod = 64;
  constexpr std::size_t kMostPoints = 100'000;
  const Eigen::Vector3d moved = from - at(path, 0.0).position;
  const double dt = 2.0 * std::numbers::pi / path.angular_frequency / kPerPeriod;
  std::vector<Eigen::Vector3d> points = {from};
  while (points.back().z() > bottom) {
    if (points.size() > kMostPoints)
      throw ArgumentError(
          fmt::format("the path takes more than {} points to height {:.6g}, expected one that "
                      "goes down faster, or turns more slowly",
                      kMostPoints, bottom));
    points.push_back(moved + at(path, dt * static_cast<double>(points.size())).position);
  }
  Eigen::MatrixX3d rows(std::ssize(points), 3);
  for (Eigen::Index k = 0; k < rows.rows(); ++k) rows.row(k) = points[static_cast<std::size_t>(k)];
  return Sketch(rows);
}

}  // namespace

Sketch sketch_of(const models::SideToSidePath& path, const Eigen::Vector3d& from, double bottom) {
  return sampled(path, from, bottom);
}

Sketch sketch_of(const models::RosePath& path, const Eigen::Vector3d& from, double bottom) {
  return sampled(path, from, bottom);
}

namespace {

/// "x" or "x[cm]". @param expected a unit of its dimension  @returns whether there is such a column
bool read_column(const io::DelimitedTable& table, const std::string& name, const std::string& expected,
                 Eigen::Ref<Eigen::VectorXd> values) {
  for (const std::string& header : table.header()) {
    const std::size_t bracket = header.find('[');
    if (header.substr(0, bracket) != name) continue;
    values = table.numbers(header);
    if (bracket == std::string::npos) return true;
    const std::size_t end = header.find(']', bracket);
    const std::string text = header.substr(bracket + 1, end == std::string::npos ? end : end - bracket - 1);
    try {
      if (!same_dimension(text, expected))
        throw ArgumentError(
            fmt::format("the column {} is in {}, expected a unit like {}", name, text, expected));
      const Unit unit = parse_unit(text);
      for (double& value : values) value = unit.to_si(value);
    } catch (const ArgumentError& error) {
      throw InputError(table.file(), table.line_of_header(), error.what());
    }
    return true;
  }
  return false;
}

}  // namespace

Sketch read_sketch(const std::filesystem::path& path, bool planar, const SketchUnits& units) {
  const io::DelimitedTable table = io::DelimitedTable::read(path);
  const auto rows = static_cast<Eigen::Index>(table.rows());
  Eigen::MatrixX3d points = Eigen::MatrixX3d::Zero(rows, 3);
  Eigen::VectorXd times(rows);
  const auto needed = [&](const std::string& name, Eigen::Index column) {
    if (read_column(table, name, units.length, points.col(column))) return;
    throw InputError(
        table.file(), table.line_of_header(),
        fmt::format("has no column {}, expected {}", name,
                    planar ? "x and y (up), and t if it is timed" : "x, y, z, and t if it is timed"));
  };
  needed("x", 0);
  if (planar) {
    needed("y", 2);
  } else {
    needed("y", 1);
    needed("z", 2);
  }
  if (!read_column(table, "t", units.time, times)) times.resize(0);
  for (Eigen::Index k = 0; k < rows; ++k) {
    if (points.row(k).allFinite() && (times.size() == 0 || std::isfinite(times[k]))) continue;
    throw table.error(static_cast<std::size_t>(k), "a cell is empty, expected numbers");
  }
  try {
    return Sketch(points, times);
  } catch (const ArgumentError& error) {
    throw InputError(table.file(), 0, error.what());
  }
}

}  // namespace samara::motion

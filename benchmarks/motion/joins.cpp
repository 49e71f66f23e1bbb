#include "motion/joins.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "samara/models/integrators/integrate.h"

namespace samara::benchmarks::motion_cases {

namespace {

models::ParametricModel released_anyhow(const motion::MotionDatabase& database) {
  std::vector<std::string> free = database.coefficient_names;
  for (const std::string& name : database.state_names) free.push_back(name + "(0)");
  return {database.parametric_model().shared_model(), database.fixed, free};
}

Eigen::Quaterniond attitude_of(const Eigen::MatrixXd& poses, Eigen::Index row) {
  return Eigen::Quaterniond(poses(row, 3), poses(row, 4), poses(row, 5), poses(row, 6)).normalized();
}

}  // namespace

Recordings::Recordings(const motion::MotionDatabase& database, int window)
    : database_(database), model_(released_anyhow(database)) {
  box_.window = window;
  for (Eigen::Index k = 0; k < database.lower.size(); ++k)
    box_.box[database.coefficient_names[static_cast<std::size_t>(k)]] = {database.lower[k],
                                                                         database.upper[k]};
}

Eigen::MatrixXd Recordings::from_state(const Eigen::VectorXd& state, const Eigen::VectorXd& coefficients,
                                       const Eigen::VectorXd& times) const {
  Eigen::VectorXd q(coefficients.size() + state.size());
  q << coefficients, state;
  std::vector<double> asked = {0.0};
  for (const double t : times) {
    if (t > 0.0) asked.push_back(t);
  }
  const models::Trajectory motion = models::integrate(model_, {q.data(), static_cast<std::size_t>(q.size())},
                                                      asked, {.relative_tolerance = 1e-9});
  return motion.states.bottomRows(times.size());
}

Eigen::MatrixXd Recordings::from_start(Eigen::Index segment, const Eigen::VectorXd& times) const {
  const auto run = static_cast<std::size_t>(database_.segments[static_cast<std::size_t>(segment)].run);
  return from_state(database_.starts.row(segment), database_.runs[run].coefficients, times);
}

motion::GhostSeries Recordings::ghost(const Eigen::VectorXd& times, const Eigen::MatrixXd& poses) const {
  std::map<std::string, double> fixed = database_.fixed;
  for (Eigen::Index k = 0; k < database_.lower.size(); ++k)
    fixed[database_.coefficient_names[static_cast<std::size_t>(k)]] =
        0.5 * (database_.lower[k] + database_.upper[k]);
  const models::ParametricModel body(model_.shared_model(), fixed, {});
  return ghost_force(body, {.times = times, .poses = poses}, box_).box->ghost;
}

PlanarBlend blended_walk(const motion::MotionDatabase& database, const Recordings& recordings,
                         const std::vector<Eigen::Index>& segments, double blend, double dt) {
  const auto duration = [&](std::size_t k) {
    return database.segments[static_cast<std::size_t>(segments[k])].duration;
  };
  double end = 0.0;
  for (std::size_t k = 0; k < segments.size(); ++k) end += duration(k);
  const auto frames = static_cast<Eigen::Index>(end / dt);
  PlanarBlend walk{.times = dt * Eigen::VectorXd::LinSpaced(frames, 0.0, static_cast<double>(frames - 1)),
                   .poses = Eigen::MatrixXd::Zero(frames, 3)};
  const auto layout = *motion::StateLayout::of(recordings.info());
  const std::vector<Eigen::Index> columns = {static_cast<Eigen::Index>(layout.position[0]),
                                             static_cast<Eigen::Index>(layout.position[1]),
                                             static_cast<Eigen::Index>(layout.attitude[0])};
  Eigen::RowVector3d offset = Eigen::RowVector3d::Zero(), reached = offset;
  double begin = 0.0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const Eigen::RowVector3d start = database.starts(segments[k], columns);
    if (k > 0) {
      offset = reached - start;
      // The same plate, turned by half turns.
      offset[2] = std::numbers::pi * std::round(offset[2] / std::numbers::pi);
    }
    const double over = k + 1 < segments.size() ? std::min(blend, duration(k + 1)) : 0.0;
    const auto first = static_cast<Eigen::Index>(std::ceil(begin / dt));
    const Eigen::Index last =
        std::min(frames, static_cast<Eigen::Index>(std::floor((begin + duration(k) + over) / dt)) + 1);
    const Eigen::VectorXd times = walk.times.segment(first, last - first).array() - begin;
    const Eigen::MatrixXd states = recordings.from_start(segments[k], times);
    const double in = k > 0 ? std::min(blend, duration(k)) : 0.0;
    for (Eigen::Index n = first; n < last; ++n) {
      const Eigen::RowVector3d pose = states(n - first, columns) + offset;
      const double s = in > 0.0 ? std::clamp(times[n - first] / in, 0.0, 1.0) : 1.0;
      walk.poses.row(n) += s * s * (3.0 - 2.0 * s) * (pose - walk.poses.row(n));
    }
    reached = database.ends(segments[k], columns) + offset;
    begin += duration(k);
  }
  return walk;
}

Eigen::MatrixXd blended_in_space(const Eigen::MatrixXd& first, Eigen::MatrixXd second,
                                 motion::BodySymmetry symmetry) {
  std::vector<Eigen::Quaterniond> copies = {Eigen::Quaterniond::Identity()};
  if (symmetry == motion::BodySymmetry::ellipsoid)
    copies.insert(copies.end(), {{0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0}, {0.0, 0.0, 0.0, 1.0}});
  Eigen::Quaterniond copy = copies.front(), yaw = copy;
  double best = -1.0;
  for (const Eigen::Quaterniond& one : copies) {
    // The turn from the copy to where it is to be, q; about the vertical all of it that can be.
    const Eigen::Quaterniond q = attitude_of(first, 0) * (attitude_of(second, 0) * one).conjugate();
    const double size = std::hypot(q.w(), q.z());
    if (!(size > best)) continue;
    best = size;
    copy = one;
    yaw = Eigen::Quaterniond(q.w() / size, 0.0, 0.0, q.z() / size);
  }
  const Eigen::RowVector3d origin = second.row(0).head<3>();
  Eigen::MatrixXd poses = first;
  Eigen::Quaterniond between = Eigen::Quaterniond::Identity();
  for (Eigen::Index k = 0; k < first.rows(); ++k) {
    const double s = static_cast<double>(k) / static_cast<double>(first.rows() - 1);
    const double share = s * s * s * (10.0 + s * (6.0 * s - 15.0));
    const Eigen::Vector3d way = yaw * (second.row(k).head<3>() - origin).transpose();
    const Eigen::Vector3d place = first.row(0).head<3>().transpose() + way;
    poses.row(k).head<3>() += share * (place.transpose() - first.row(k).head<3>());
    // Of the two ways round, the one that goes on from the frame before: attitudes may part by more than half a turn.
    const Eigen::Quaterniond from = attitude_of(first, k);
    Eigen::Quaterniond to_second = from.conjugate() * (yaw * attitude_of(second, k) * copy);
    if (to_second.dot(between) < 0.0) to_second.coeffs() = -to_second.coeffs();
    between = to_second;
    const double sine = to_second.vec().norm();
    const double half = share * std::atan2(sine, to_second.w());
    Eigen::Quaterniond part(std::cos(half), 0.0, 0.0, 0.0);
    if (sine > 0.0) part.vec() = std::sin(half) / sine * to_second.vec();
    const Eigen::Quaterniond turned = from * part;
    poses.row(k).tail<4>() << turned.w(), turned.x(), turned.y(), turned.z();
  }
  return poses;
}

}  // namespace samara::benchmarks::motion_cases

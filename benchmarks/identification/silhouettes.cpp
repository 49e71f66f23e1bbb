#include "silhouettes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace samara::benchmarks::identification {

using samara::models::FamilyInfo;
using samara::models::TrajectoryFamily;
using samara::models::TrajectorySource;

namespace {

constexpr Eigen::Index kCameras = 2;
/// Of a disc seen edge-on.
constexpr double kEdge = 0.05;

struct Normal {
  Eigen::Vector3d n;
  Eigen::Matrix<double, 3, 4> by_q;
};

/// Of a quaternion of about unit length.
Normal normal_of(const Eigen::Vector4d& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Normal result;
  result.n << 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), w * w - x * x - y * y + z * z;
  result.by_q << 2.0 * y, 2.0 * z, 2.0 * w, 2.0 * x,  //
      -2.0 * x, -2.0 * w, 2.0 * z, 2.0 * y,           //
      2.0 * w, -2.0 * x, -2.0 * y, 2.0 * z;
  return result;
}

/// Outputs of the bodies first, then the silhouettes, in the order asked for.
class SilhouetteSource final : public models::TrajectorySource {
 public:
  /// @param cameras per output asked for: -1, or the number of the camera
  SilhouetteSource(std::unique_ptr<models::TrajectorySource> bodies, Eigen::Index times,
                   std::vector<int> cameras, Eigen::Index coordinates, Eigen::Index radius)
      : bodies_(std::move(bodies)),
        cameras_(std::move(cameras)),
        outputs_(std::ranges::count(cameras_, -1) + 4),
        coordinates_(coordinates),
        radius_(radius) {
    values_.setZero(times, outputs_);
    derivatives_.setZero(times, outputs_ * coordinates);
  }

  samara::models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                             Eigen::MatrixXd* derivatives) override {
    const auto own = static_cast<std::size_t>(coordinates_);
    samara::models::TrajectoryOutcome outcome =
        bodies_->evaluate(q.first(own), values_, derivatives ? &derivatives_ : nullptr);
    if (!outcome) return outcome;
    const auto outputs = static_cast<Eigen::Index>(cameras_.size());
    Eigen::Index column = 0;
    for (Eigen::Index o = 0; o < outputs; ++o) {
      const int camera = cameras_[static_cast<std::size_t>(o)];
      if (camera >= 0) {
        see(q, camera, o, values, derivatives);
        continue;
      }
      values.col(o) = values_.col(column);
      for (Eigen::Index k = 0; derivatives && k < coordinates_; ++k) {
        derivatives->col(o + outputs * k) = derivatives_.col(column + outputs_ * k);
      }
      ++column;
    }
    return outcome;
  }

 private:
  void see(std::span<const double> q, int camera, Eigen::Index o, Eigen::MatrixXd& values,
           Eigen::MatrixXd* derivatives) const {
    const auto outputs = static_cast<Eigen::Index>(cameras_.size());
    const Eigen::Index at_size = coordinates_ + camera;
    const Eigen::Index at_view = coordinates_ + kCameras + camera;
    const double view = q[static_cast<std::size_t>(at_view)];
    const double radius = q[static_cast<std::size_t>(radius_)];
    const double area = q[static_cast<std::size_t>(at_size)] * radius * radius;
    const Eigen::Vector3d d(std::cos(view), std::sin(view), 0.0);
    const Eigen::Vector3d d_view(-std::sin(view), std::cos(view), 0.0);
    for (Eigen::Index row = 0; row < values.rows(); ++row) {
      const Normal normal = normal_of(values_.row(row).tail<4>().transpose());
      const double across = normal.n.dot(d);
      const double seen = std::sqrt(across * across + kEdge * kEdge);
      values(row, o) = area * seen;
      if (!derivatives) continue;
      const double slope = area * across / seen;
      for (Eigen::Index k = 0; k < coordinates_; ++k) {
        const Eigen::Vector4d q_rate =
            derivatives_.row(row).segment<4>(outputs_ - 4 + outputs_ * k).transpose();
        (*derivatives)(row, o + outputs * k) = slope * d.dot(normal.by_q * q_rate);
      }
      for (Eigen::Index other = coordinates_; other < coordinates_ + 2 * kCameras; ++other) {
        (*derivatives)(row, o + outputs * other) = other == at_size   ? radius * radius * seen
                                                   : other == at_view ? slope * normal.n.dot(d_view)
                                                                      : 0.0;
      }
    }
  }

  std::unique_ptr<models::TrajectorySource> bodies_;
  std::vector<int> cameras_;
  Eigen::Index outputs_, coordinates_, radius_;
  Eigen::MatrixXd values_, derivatives_;
};

class SilhouetteFamily final : public models::TrajectoryFamily {
 public:
  explicit SilhouetteFamily(std::unique_ptr<models::TrajectoryFamily> bodies)
      : bodies_(std::move(bodies)), info_(bodies_->info()) {
    for (const char* name : {"size_1", "size_2"})
      info_.coordinates.push_back({name, "px^2/m^2", false, 1e4, 1e7});
    for (const char* name : {"view_1", "view_2"}) {
      info_.coordinates.push_back({name, "rad", false, -2.0 * std::numbers::pi, 2.0 * std::numbers::pi});
    }
    for (const char* name : {"silhouette_1", "silhouette_2"}) info_.outputs.push_back({name, "px^2"});
  }

  const models::FamilyInfo& info() const override { return info_; }
  const models::ParametricModel* equations() const override { return bodies_->equations(); }

  std::unique_ptr<models::TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs) const override {
    std::vector<int> all(bodies_->info().coordinates.size());
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>(k);
    return at(times, outputs, all);
  }

  std::unique_ptr<models::TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs,
                                               const std::vector<int>& wanted) const override {
    const auto& coordinates = bodies_->info().coordinates;
    const auto count = static_cast<int>(coordinates.size());
    std::vector<int> inner;
    std::ranges::copy_if(wanted, std::back_inserter(inner), [&](int k) { return k < count; });
    std::vector<std::string> needed;
    std::vector<int> cameras;
    for (const std::string& output : outputs) {
      cameras.push_back(output == "silhouette_1" ? 0 : output == "silhouette_2" ? 1 : -1);
      if (cameras.back() < 0) needed.push_back(output);
    }
    for (const std::string& part : info_.attitude) needed.push_back(part);
    const auto radius = std::ranges::find(coordinates, "a", &samara::models::FamilyCoordinate::name);
    return std::make_unique<SilhouetteSource>(bodies_->at(times, needed, inner),
                                              static_cast<Eigen::Index>(times.size()), std::move(cameras),
                                              count, radius - coordinates.begin());
  }

 private:
  std::unique_ptr<models::TrajectoryFamily> bodies_;
  models::FamilyInfo info_;
};

}  // namespace

std::unique_ptr<models::TrajectoryFamily> with_silhouettes(std::unique_ptr<models::TrajectoryFamily> bodies) {
  return std::make_unique<SilhouetteFamily>(std::move(bodies));
}

}  // namespace samara::benchmarks::identification

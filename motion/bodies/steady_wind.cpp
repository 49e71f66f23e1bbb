#include "samara/motion/bodies/steady_wind.h"

#include "samara/base/errors.h"

namespace samara::motion {

namespace {

class SteadyWind final : public models::AmbientFlow {
 public:
  explicit SteadyWind(const Eigen::Vector3d& velocity) { sample_.velocity = velocity; }
  models::AmbientSample sample(double, const Eigen::Vector3d&) const override { return sample_; }
  double length() const override { return 1.0; }

 private:
  models::AmbientSample sample_;
};

}  // namespace

std::shared_ptr<const models::AmbientFlow> steady_wind(const Eigen::Vector3d& velocity) {
  if (!velocity.allFinite()) throw ArgumentError("the wind has a velocity that is not finite");
  return std::make_shared<SteadyWind>(velocity);
}

}  // namespace samara::motion

#include "samara/models/laws/ambient_flow.h"

#include <cmath>
#include <limits>
#include <utility>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/laws/immersed_body.h"

namespace samara::models {

namespace laws {

namespace {

/// A flow field as an ambient policy.
struct FieldFlow {
  static constexpr int kParameters = 0;
  static std::vector<ParameterInfo> parameters() { return {}; }

  std::shared_ptr<const AmbientFlow> field;

  template <class S>
  Ambient<S> at(const S& t, const Vector3<S>& position, const Vector3<S>& v, const S*) const {
    using added_mass::scalar_part;
    const double time = scalar_part(t);
    const Eigen::Vector3d place(scalar_part(position.x), scalar_part(position.y), scalar_part(position.z));
    const AmbientSample here = field->sample(time, place);
    Local<S> local(here);
    if constexpr (!std::is_same_v<S, double>) {
      local.follow({position.x - S(place.x()), position.y - S(place.y()), position.z - S(place.z())}, *field,
                   time, place, here.gradient);
    }
    return {.velocity = local.velocity,
            .path_rate = local.rate + local.gradient.along(v),
            .material_rate = local.rate + local.gradient.along(local.velocity),
            .gradient = local.gradient};
  }

 private:
  /// A sample whose entries may depend on the position to first order.
  template <class S>
  struct Local {
    Vector3<S> velocity, rate;
    Gradient<S> gradient;

    explicit Local(const AmbientSample& sample)
        : velocity(constant(sample.velocity)),
          rate(constant(sample.rate)),
          gradient{constant(sample.gradient.col(0)), constant(sample.gradient.col(1)),
                   constant(sample.gradient.col(2))} {}

    static Vector3<S> constant(const Eigen::Vector3d& u) { return {S(u.x()), S(u.y()), S(u.z())}; }

    /// Adds the change over the way `offset` from `place`, which is zero but for its derivatives.
    void follow(const Vector3<S>& offset, const AmbientFlow& flow, double time, const Eigen::Vector3d& place,
                const Eigen::Matrix3d& slope) {
      const S offsets[3] = {offset.x, offset.y, offset.z};
      const double step = std::cbrt(std::numeric_limits<double>::epsilon()) * flow.length();
      for (int k = 0; k < 3; ++k) {
        Eigen::Vector3d above = place;
        Eigen::Vector3d below = place;
        above[k] += step;
        below[k] -= step;
        const AmbientSample up = flow.sample(time, above);
        const AmbientSample down = flow.sample(time, below);
        const double way = above[k] - below[k];
        velocity = velocity + offsets[k] * constant(slope.col(k));
        rate = rate + offsets[k] * constant((up.rate - down.rate) / way);
        const Eigen::Matrix3d bend = (up.gradient - down.gradient) / way;
        gradient.by_x = gradient.by_x + offsets[k] * constant(bend.col(0));
        gradient.by_y = gradient.by_y + offsets[k] * constant(bend.col(1));
        gradient.by_z = gradient.by_z + offsets[k] * constant(bend.col(2));
      }
    }
  };
};

}  // namespace

template <>
ModelInfo ImmersedBodyIn<FieldFlow>::info() const {
  ModelInfo info = ImmersedBody::info();
  info.name = "immersed_body_in_flow";
  info.title = "Body with quasi-steady forces in a flow field";
  info.validity += "; the flow changes little over the length of the body";
  return info;
}

}  // namespace laws

std::shared_ptr<const Model> immersed_body_in(std::shared_ptr<const AmbientFlow> flow) {
  if (!flow) throw ArgumentError("there is no ambient flow; a flow field was expected");
  require_positive(flow->length(), "the length of the ambient flow");
  using Law = laws::ImmersedBodyIn<laws::FieldFlow>;
  constexpr bool kCompiled = false;  // a field answers for one place at a time
  return std::make_shared<LawModel<Law, kCompiled>>(Law{.flow = {.field = std::move(flow)}});
}

}  // namespace samara::models

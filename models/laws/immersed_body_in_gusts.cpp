// Apart from immersed_body.cpp: the kernels of each take the compiler long.
#include "samara/models/laws/immersed_body.h"
#include "samara/models/laws/parameter_list.h"

namespace samara::models::laws {

template <>
ModelInfo ImmersedBodyIn<GustRamp>::info() const {
  ModelInfo info = ImmersedBody::info();
  info.name = "immersed_body_in_gusts";
  info.title = "Body with quasi-steady forces in a fluid that changes in time";
  info.equations +=
      ";  w_air = (gust_x, gust_y, gust_z) + (t - gust_start) (gust_rate_x, gust_rate_y, gust_rate_z);  "
      "Dw_air/Dt = (gust_material_x, gust_material_y, gust_material_z);  "
      "in drag, lift and damping w is w - R^T (gust_spin_x, gust_spin_y, gust_spin_z)";
  info.validity +=
      "; a fluid that is the same over the length of the body. Realisations (samara simulate --realisations) "
      "set "
      "the gust step by step; by itself it is one ramp in time";
  // No rotation about z: the gust would have to turn with the state.
  info.symmetries = translations();
  append(info.parameters, GustRamp::parameters());
  return info;
}

std::shared_ptr<const Model> immersed_body_in_gusts() {
  return std::make_shared<LawModel<ImmersedBodyIn<GustRamp>>>();
}

}  // namespace samara::models::laws

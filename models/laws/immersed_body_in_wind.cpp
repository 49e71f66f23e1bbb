// Apart from immersed_body.cpp: the kernels of each take the compiler long.
#include "samara/models/law_tools/parameter_list.h"
#include "samara/models/laws/immersed_body.h"

namespace samara::models::laws {

template <>
ModelInfo ImmersedBodyIn<LinearWind>::info() const {
  ModelInfo info = ImmersedBody::info();
  info.name = "immersed_body_in_wind";
  info.title = "Body with quasi-steady forces in a steady wind";
  info.equations += ";  w_air = (wind_x + shear_x z, wind_y + shear_y z, wind_z)";
  info.validity += "; the wind changes little over the length of the body";
  // No rotation about z: the wind would have to turn with the state.
  info.symmetries = {"translation of x", "translation of y"};
  append(info.parameters, LinearWind::parameters());
  return info;
}

std::shared_ptr<const Model> immersed_body_in_wind() {
  return std::make_shared<LawModel<ImmersedBodyIn<LinearWind>>>();
}

}  // namespace samara::models::laws

// Apart from immersed_body.cpp: the kernels of each take the compiler long.
#include "samara/models/law_tools/parameter_list.h"
#include "samara/models/laws/immersed_body.h"

namespace samara::models::laws {

namespace {

/// What the fluid does to a turning body it does by the rate relative to itself: w_rx for w_x, and so on.
std::string with_relative_rates(std::string text) {
  const auto replace = [&](const std::string& old, const std::string& by) {
    for (std::size_t at = text.find(old); at != std::string::npos; at = text.find(old, at + by.size()))
      text.replace(at, old.size(), by);
  };
  for (const char* axis : {"x", "y", "z"}) replace(std::string(" w_") + axis, std::string(" w_r") + axis);
  for (const char* axis : {"x", "y"}) replace(std::string("(w_") + axis, std::string("(w_r") + axis);
  replace("w x p", "w_r x p");
  return text;
}

}  // namespace

template <>
ModelInfo ImmersedBodyIn<GustRamp>::info() const {
  ModelInfo info = ImmersedBody::info();
  info.name = "immersed_body_in_gusts";
  info.title = "Body with quasi-steady forces in a fluid that changes in time";
  info.equations = with_relative_rates(info.equations);
  info.equations +=
      ";  w_r = w - R^T (gust_spin_x, gust_spin_y, gust_spin_z);  "
      "w_air = (gust_x, gust_y, gust_z) + (t - gust_start) (gust_rate_x, gust_rate_y, gust_rate_z);  "
      "Dw_air/Dt is (gust_rate_x, gust_rate_y, gust_rate_z) - W R u_r;  "
      "W has the rows (gust_gradient_xx, gust_gradient_xy, gust_gradient_xz) and so on";
  info.validity +=
      "; the fluid changes little over the length of the body. Realisations (samara simulate "
      "--realisations) set the gust step by step; by itself it is one ramp in time";
  // No rotation about z: the gust would have to turn with the state.
  info.symmetries = translations();
  append(info.parameters, GustRamp::parameters());
  return info;
}

std::shared_ptr<const Model> immersed_body_in_gusts() {
  return std::make_shared<LawModel<ImmersedBodyIn<GustRamp>>>();
}

}  // namespace samara::models::laws

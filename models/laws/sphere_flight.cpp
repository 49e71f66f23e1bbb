#include "samara/models/laws/sphere_flight.h"

namespace samara::models::laws {

std::shared_ptr<const Model> sphere_flight() {
  return std::make_shared<LawModel<SphereFlight>>();
}

}  // namespace samara::models::laws

#include "samara/models/laws/falling_plate.h"

namespace samara::models::laws {

std::shared_ptr<const Model> falling_plate() {
  return std::make_shared<LawModel<FallingPlate>>();
}

}  // namespace samara::models::laws

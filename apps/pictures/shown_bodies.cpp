#include "pictures/shown_bodies.h"

#include <vector>

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "samara/base/errors.h"
#include "samara/models/bodies/mesh_file.h"
#include "samara/models/bodies/shown_body.h"

namespace samara::apps {

namespace {

std::vector<double> sizes_of(const ShownWords& words) {
  std::vector<double> sizes;
  for (const std::string& text : words.sizes) sizes.push_back(number_or_quantity("--size", text, "m"));
  return sizes;
}

}  // namespace

void refuse_shown(const ShownWords& words) {
  sizes_of(words);
  if (words.body.empty() && words.sizes.empty() && words.unit.empty()) return;
  throw ArgumentError(
      "--body, --size and --unit are of what is drawn: --output with a .glb or .usda was expected");
}

std::optional<models::TriangleMesh> shown_mesh(const ShownWords& words) {
  const std::vector<double> sizes = sizes_of(words);
  if (words.body.empty()) {
    if (words.sizes.empty() && words.unit.empty()) return std::nullopt;
    throw ArgumentError("--size and --unit are of a body: --body was expected");
  }
  const bool is_shape = words.body == "plate" || words.body == "disc" || words.body == "ellipsoid";
  if (is_shape) {
    if (!words.unit.empty())
      throw ArgumentError(
          fmt::format("--unit is of a mesh file, and --body is {}: --size was expected", words.body));
    return models::shown_shape(words.body, sizes);
  }
  if (!words.sizes.empty())
    throw ArgumentError("--size is of a plate, disc or ellipsoid; of a mesh file --unit was expected");
  if (words.unit.empty()) {
    throw ArgumentError(fmt::format(
        "--body is {}, a mesh file, which says no unit: --unit with mm, cm or m was expected", words.body));
  }
  return models::read_mesh(words.body, number_or_quantity("--unit", "1 " + words.unit, "m"),
                           {.turn_outward = true, .closed = false});
}

}  // namespace samara::apps

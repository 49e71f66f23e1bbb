#pragma once

#include <optional>
#include <string>
#include <vector>

#include "samara/codebooks/plan/plan.h"

namespace samara::codebooks {

/// What is put in place of what a plan says.
struct PlanChanges {
  struct Coordinate {
    std::string name;
    /// SI numbers or strings with a unit, as a plan has them: "1.2", "10 cm/s". One fixes the coordinate, two free it
    /// between them.
    std::string value, upper;
  };
  std::vector<Coordinate> coordinates = {};
  std::optional<double> relative = {};
  std::optional<int> threads = {};

  bool empty() const { return coordinates.empty() && !relative && !threads; }
};

/// The plan with the changes, and with a text that says the same, so that it can be built again from its codebook.
/// The nodes and the transform of an interval that is changed stay.
/// @param text, name as parse_plan() takes them @throws InputError as parse_plan() for the text as it stands;
/// ArgumentError for changes that make no plan of it, or that its form does not allow (io/toml_edit.h)
Plan changed_plan(const std::string& text, const std::string& name, const PlanChanges& changes,
                  const BodyReader& body_reader = {});

}  // namespace samara::codebooks

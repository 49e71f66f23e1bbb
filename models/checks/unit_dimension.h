#pragma once

#include <array>
#include <optional>
#include <string_view>

/// What a unit of a model means in lengths, masses and times.
namespace samara::models {

/// The base quantities whose units the check of models changes.
enum BaseQuantity { kLength, kMass, kTime, kBaseQuantities };

/// Powers of the base quantities: "N" is {1, 1, -2}.
using Dimension = std::array<int, kBaseQuantities>;

/// Whether the text is made of products and quotients of symbols with integer powers, such as "kg/m^3", "1/s"
/// or "1". A "/" goes for the one factor behind it: "J/m/s" is J/(m s).
bool looks_like_a_unit(std::string_view unit);

/// The dimension of a unit, or nothing if it holds a symbol other than the base units of SI and
/// rad, N, J, W, Pa, Hz. Kelvin, ampere, mole and candela count as 1, like rad.
std::optional<Dimension> dimension_of(std::string_view unit);

}  // namespace samara::models

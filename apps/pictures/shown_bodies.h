#pragma once

#include <optional>

#include "options/arguments.h"
#include "samara/models/bodies/triangle_mesh.h"

namespace samara::apps {

/// The body that was asked for, to draw [m]; nothing if none was.
/// @throws ArgumentError for sizes or a unit that do not belong to it; InputError for a mesh that cannot be read
std::optional<models::TriangleMesh> shown_mesh(const ShownWords& words);

/// Where nothing is drawn. @throws ArgumentError if a body was asked for
void refuse_shown(const ShownWords& words);

}  // namespace samara::apps

#pragma once

#include <string>

#include "samara/flow/files/flow_file.h"
#include "samara/io/png_image.h"

namespace samara::flow {

struct PictureOptions {
  std::string field = "k";  ///< or "speed": of the mean velocity
  int pixels_per_cell = 0;  ///< 0: so that the picture is about 1200 pixels wide
  bool streamlines = true;
};

/// A field of a flow, of its middle layer in space: colours with their numbers and unit, the body in grey, and
/// streamlines of the mean velocity, evenly started at the inflow and traced by Heun's method both ways.
/// @throws ArgumentError for a field that there is not
io::Picture draw_flow(const StoredFlow& flow, const PictureOptions& options = {});

}  // namespace samara::flow

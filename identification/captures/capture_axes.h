#pragma once

#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"

/// The axes of a capture's world and body; internal to identification/.
namespace samara::identification {

/// Three channels of angles (rad) become the channels qw, qx, qy, qz. The quaternion is continuous in sign.
/// @param order see EulerColumns
/// @throws ArgumentError if the capture has a channel "qw" already
void angles_to_quaternion(Capture& capture, const std::vector<std::string>& angles, const std::string& order);

/// Quantities that count the other way than the model's: their values change sign, and with a place x, y or z its
/// velocity.
/// @throws ArgumentError for one that is not measured, and for a place where the attitude is measured too: a mirrored
/// body has none
void flip_quantities(Capture& capture, const std::vector<std::string>& quantities);

/// Turns the world such that the axis `up` becomes z, by the shortest rotation: positions x, y, z, velocities
/// vx, vy, vz and the attitude qw, qx, qy, qz turn along; quantities in body axes stay.
/// @param up "x", "-x", "y", "-y", "z", "-z"
/// @throws ArgumentError if some but not all of x, y, z (or of the others) are measured
void turn_upright(Capture& capture, const std::string& up);

}  // namespace samara::identification

#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace samara::motion {

/// Longest gap that is bridged, in frames.
inline constexpr Eigen::Index kLongestGap = 10;

/// Where a frame of a bridged record lies: after a given frame, by a share of the way to the next.
struct BetweenFrames {
  Eigen::Index before = 0;
  double share = 0.0;
};

/// Frames with others put in where some are missing, so that frame numbers measure time, as recurrence asks for. All
/// are the given ones where nothing is missing: intervals below 1.5 times their median.
/// @param times of two frames or more, increasing
/// @throws ArgumentError naming a gap of more than kLongestGap frames: how a body moved there nobody knows.
std::vector<BetweenFrames> even_frames(const Eigen::VectorXd& times);

/// The sentence that even_frames() would throw; empty where it would not.
std::string long_gap(const Eigen::VectorXd& times);

/// Rows of `values` at such frames, by straight lines between given ones.
Eigen::MatrixXd between(const Eigen::MatrixXd& values, const std::vector<BetweenFrames>& frames);

/// Weights of values at these times of which polynomials of lower degree have nothing left: divided differences, their
/// squares adding up to 1, so that of white noise they leave its deviation.
/// @param times two or more, increasing
Eigen::VectorXd divided_difference(const Eigen::Ref<const Eigen::VectorXd>& times);

/// 1.4826 times the median of |differences|: the deviation of noise that is normal. 0 of none.
double deviation_of(const Eigen::Ref<const Eigen::VectorXd>& differences);

/// Standard deviation of a frame's noise from fourth differences, which a smooth motion does not have, of frames some
/// of which may be missing: from runs of five frames without a gap; where there are few, from any five. 0 for fewer.
double noise_of(const Eigen::Ref<const Eigen::VectorXd>& values, const Eigen::VectorXd& times);

}  // namespace samara::motion

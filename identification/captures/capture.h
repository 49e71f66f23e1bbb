#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

/// A capture is a measured trajectory: what one camera, or one mocap system, saw of one motion.
namespace samara::identification {

/// One measured quantity over the frames of a capture.
struct Channel {
  std::string quantity;    ///< "x", named like the model's output it measures
  std::string unit;        ///< of SI symbols; "px" if the file gives no scale
  Eigen::VectorXd values;  ///< one per frame; NaN where it was not seen
  /// The scale that took pixels to metres [m/px], where one did.
  std::optional<double> metres_per_pixel = {};
  bool is_flipped = false;  ///< `flip` of a sidecar has turned its sign
};

/// Angles are known by their names, since their unit is 1: theta, phi, psi, roll, pitch, yaw.
bool is_angle(const Channel& channel);

struct BeforeCleaning;

struct Capture {
  std::string id;             ///< group labels joined by "/", or the stem of the file
  std::string file;           ///< the table it was read from; empty if made in memory
  std::string checksum = {};  ///< of the bytes of that table, wherever it lies; empty as `file`
  std::map<std::string, std::string> labels;  ///< of its group: column -> value
  Eigen::VectorXd times;                      ///< s, strictly increasing
  std::vector<Channel> channels;
  std::vector<std::string> notes = {};  ///< what reading and cleaning did to it, in sentences
  std::string up = {};                  ///< the axis of its file that became z, "-y"; empty: z stayed
  std::string motion = {};              ///< of a span: the id of the capture that it was cut from
  double shift = 0.0;                   ///< s, of a span: what its times lack of those of that capture
  double start = 0.0;  ///< s, what its table, or the whole of which it is a part, says at time 0
  std::shared_ptr<const BeforeCleaning> before_cleaning = {};  ///< null: nothing was cleaned

  int frame_count() const { return static_cast<int>(times.size()); }
  /// The id of the capture of which it is all, or a part.
  const std::string& whole() const { return motion.empty() ? id : motion; }
  bool has(const std::string& quantity) const;
  /// @throws ArgumentError naming the capture and the nearest quantity.
  const Channel& channel(const std::string& quantity) const;
};

/// What is wrong with a capture is wrong with the file it came from, if it came from one.
/// @throws InputError, or ArgumentError where the name of the file is empty
[[noreturn]] void refuse(const std::string& file, const std::string& sentence);

/// @throws as refuse() if a channel has not one value for each frame
void check_sizes(const Capture& capture);

/// What cleaning began with, and the clock that it made.
struct BeforeCleaning {
  Capture capture;
  std::function<Capture(Capture)> clean;  ///< leaves frames out at the end alone
  Eigen::VectorXd times;                  ///< s, of the frames after cleaning
};

/// What was known of a capture at a moment: its frames at most `seconds` after the first, as frames_within()
/// counts. Cleaning looks at frames on both sides of one, and is done again without those after the moment.
/// @throws Error if too little is left to be cleaned, or cleaning leaves nothing.
Capture known_at(const Capture& capture, double seconds);

/// How many frames are at most `seconds` after the first. A frame on the border belongs to them, also where
/// rounding of the times (a thousandth of a frame interval) puts it just after.
Eigen::Index frames_within(const Capture& capture, double seconds);

/// The part of a capture that is at most `seconds` after its first frame, as frames_within() counts.
/// @throws ArgumentError if `seconds` is not positive, or fewer than 3 frames are left; as check_sizes()
Capture first(const Capture& capture, double seconds);

/// Spans of a capture: the first begins at its first frame, each next one at the first frame that is `stride`
/// or more after the start of the one before. They keep the capture's labels; their times count from their
/// own first frame. Left out are spans that reach beyond the end of the capture, and those of which fewer
/// than half of the frames (or than 3) are seen.
/// @param length s, of a span
/// @param stride s, from start to start
/// @param quantities of which a frame that is seen has all; empty: any
/// @throws ArgumentError for times that are not positive; as check_sizes()
std::vector<Capture> spans(const Capture& capture, double length, double stride,
                           const std::vector<std::string>& quantities = {});

/// "drop from 0.4 s": the id of the span of a capture that begins there, one for each frame.
/// @param begin s
std::string span_id(const std::string& capture, double begin);

}  // namespace samara::identification

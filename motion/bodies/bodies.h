#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "samara/models/laws/ambient_flow.h"
#include "samara/motion/bodies/next_pieces.h"

/// Many bodies at run time, for pictures that move: a thousand leaves within a frame of 60 Hz.
///
///   const NextPieces pieces(load_database("leaf.h5"));          // once, shared by all
///   Bodies leaves(pieces, 1000, {.ground = 0.0, .seed = 7});
///   for (Eigen::Index n = 0; n < 1000; ++n) leaves.release(n, place(n), yaw(n));
///   while (..) {
///     leaves.advance(1.0 / 60.0);                               // no allocation, no lock
///     leaves.read_poses(positions, rotations);
///   }
///
/// Each is one solution of the model: as soon as an event is certain, a few steps after it, its coefficients begin to
/// move to those of a segment that began in a state like its own at the event, over a ramp; nothing is blended, and
/// place, velocity, attitude and rate have no jumps. Bodies do not see each other: there are no collisions.
namespace samara::motion {

enum class BodyStatus {
  falling,
  landed,      ///< it came to the ground, and rests where it met it
  not_finite,  ///< its states are no numbers any more; it rests where it was last
  waiting,     ///< it was not released yet
};

/// An event of one of the bodies.
struct BodyEvent {
  Eigen::Index body = 0;
  double t = 0.0;                          ///< s since its release
  EventKind kind = EventKind::swing_plus;  ///< of the segment that ended
  bool is_steady = false;                  ///< as Event::is_steady: its kind counts for nothing
  std::optional<EventKind> planned;        ///< the kind of the piece that was chosen for that segment
  NextPiece next;                          ///< with the kind that the chain drew, if it did
};

/// Of all events since construction.
struct BodyCounts {
  long events = 0;
  long dropped = 0;  ///< that events() had no room for
  long planned = 0;  ///< that ended a segment for which a piece was chosen, those that are steady left out ..
  long kept = 0;     ///< .. and were of its kind
  long drawn = 0;    ///< at which a chain drew a kind ..
  long taken = 0;    ///< .. and a piece of it was taken ..
  long redrawn = 0;  ///< .. or of one that it drew then, among those that were left
};

struct BodiesOptions {
  enum class Choice { chain, graph };
  Choice choice = Choice::chain;      ///< where next pieces come from
  double step = 0.0;                  ///< s, at most; 0: that of the database
  double ramp = -1.0;                 ///< s, of the coefficients; below 0: that with which pieces were tried
  std::optional<double> ground = {};  ///< m, height at which bodies rest; none: they fall for ever
  /// Next pieces that are tried ahead at an event, from the state that the body is really in, at most 8: the first
  /// whose next event is of its kind is taken (the air about the body resting as it is). 0: none is tried, and the
  /// best is taken as it is. Trying costs about a segment's steps for each event.
  int tries = 0;
  /// Wind: sampled once per body and step at its place, and at the time of the crowd, the sum of what it has advanced:
  /// all feel a gust at the same instant, whenever they were released. Of models that have a sibling `.._in_gusts`.
  /// Planar bodies move in x and z at y = 0, and do not feel its y. What the air turns is not felt.
  std::shared_ptr<const models::AmbientFlow> wind = {};
  std::uint64_t seed = 1;  ///< body n draws from its stream n
};

class Bodies {
 public:
  /// @param pieces must live as long
  /// @throws ArgumentError for no bodies, a step, ramp or ground that is not finite, tries outside 0 to
  /// 8, or wind for a model without it.
  Bodies(const NextPieces& pieces, Eigen::Index count, const BodiesOptions& options = {});
  ~Bodies();
  Bodies(Bodies&&) noexcept;
  Bodies& operator=(Bodies&&) noexcept;

  Eigen::Index count() const;

  /// Lets a body go in a state that a segment, drawn from the graph's largest component, begins in: moving, as if it
  /// had fallen for a while in the air that is there now.
  /// @param place of its centre, world, z up (m); of a planar model y is ignored
  /// @param yaw rad, about the vertical; of a planar model ignored
  /// @throws ArgumentError for a body that there is not, numbers that are not finite, or a place that is not above the
  /// ground; then nothing has changed
  void release(Eigen::Index body, const Eigen::Vector3d& place, double yaw);

  /// Lets a body go in a state of the model, SI, with coefficients in the order of the database; none: those of the run
  /// that has the nearest segment.
  /// @throws ArgumentError likewise, for other sizes, or a quaternion whose length is not 1 to 1e-3
  void release(Eigen::Index body, std::span<const double> state, std::span<const double> coefficients = {});

  /// All that fall, by steps of equal length. Does not allocate.
  /// @param dt s, more than 0. @throws ArgumentError otherwise
  void advance(double dt);

  /// Events of the last advance(), in the order of its steps. There is room for four times as many as there are
  /// bodies; what is dropped is counted.
  std::span<const BodyEvent> events() const;
  const BodyCounts& counts() const;

  BodyStatus status(Eigen::Index body) const;
  Eigen::Index falling() const;
  double time(Eigen::Index body) const;  ///< s since its release
  void read_state(Eigen::Index body, std::span<double> state) const;
  void read_coefficients(Eigen::Index body, std::span<double> coefficients) const;

  /// Poses of all bodies in a world with z up; those that were not released are at the origin, unturned.
  /// @param positions 3 numbers a body, m  @param rotations 4 a body: w, x, y, z, body to world, of length one
  /// @throws ArgumentError for other sizes
  void read_poses(std::span<double> positions, std::span<double> rotations) const;

 private:
  struct Impl;
  void require_index(Eigen::Index body) const;

  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::motion

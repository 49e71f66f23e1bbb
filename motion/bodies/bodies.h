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
/// Each is one solution of the model: at its events its coefficients begin to move to those of a segment that began in
/// a state like its own, over a ramp; nothing is blended, and place, velocity, attitude and rate have no jumps. Bodies
/// do not see each other: there are no collisions.
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
  std::optional<EventKind> planned;        ///< the kind of the piece that was chosen for that segment
  NextPiece next;
};

struct BodiesOptions {
  enum class Choice { chain, graph };
  Choice choice = Choice::chain;      ///< where next pieces come from
  double step = 0.0;                  ///< s, at most; 0: that of the database
  double ramp = -1.0;                 ///< s, of the coefficients; below 0: a quarter of the median segment
  std::optional<double> ground = {};  ///< m, height at which bodies rest; none: they fall for ever
  /// Wind: sampled once per body and step at its place. Of models that have a sibling `.._in_gusts`.
  std::shared_ptr<const models::AmbientFlow> wind = {};
  std::uint64_t seed = 1;  ///< body n draws from its stream n
};

class Bodies {
 public:
  /// @param pieces must live as long
  /// @throws ArgumentError for no bodies, a step, ramp or ground that is not finite, or wind for a model without it.
  Bodies(const NextPieces& pieces, Eigen::Index count, const BodiesOptions& options = {});
  ~Bodies();
  Bodies(Bodies&&) noexcept;
  Bodies& operator=(Bodies&&) noexcept;

  Eigen::Index count() const;

  /// Lets a body go in a state that a segment, drawn from the graph's largest component, begins in: moving, as if it
  /// had fallen for a while.
  /// @param place of its centre, world, z up (m); of a planar model y is ignored
  /// @param yaw rad, about the vertical; of a planar model ignored
  /// @throws ArgumentError for a body that there is not, or numbers that are not finite
  void release(Eigen::Index body, const Eigen::Vector3d& place, double yaw);

  /// Lets a body go in a state of the model, SI, with coefficients in the order of the database; none: those of the run
  /// that has the nearest segment.
  /// @throws ArgumentError likewise, or for other sizes
  void release(Eigen::Index body, std::span<const double> state, std::span<const double> coefficients = {});

  /// All that fall, by steps of equal length. Does not allocate.
  /// @param dt s, more than 0. @throws ArgumentError otherwise
  void advance(double dt);

  /// Events of the last advance(), in the order of its steps; four a body at most are kept.
  std::span<const BodyEvent> events() const;

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

#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/build/build.h"

/// Codebooks for the tests.

/// A coin falling in water, C_D and v(0) free, to 1e-3; built once per program.
const std::string& coin_plan();
const samara::codebooks::BuildResult& coin_build();

/// Interval of every coordinate of a hand-made piece.
struct PieceBox {
  double t_lower, t_upper;  ///< s
  double C_D_lower, C_D_upper;
};

/// Random fields over t (radau), C_D (chebyshev) and v(0) (p1, on a mesh that is not equidistant): two
/// groups, the first with outputs x and v, the second with E. Nothing makes pieces of different seeds agree
/// where they meet.
samara::codebooks::Piece random_piece(const PieceBox& box, unsigned seed, int rank = 5);

/// Two slabs of time by two cells of C_D: four random pieces in the order of their lower corners.
samara::codebooks::Codebook four_pieces();
/// What four_pieces() is made of: t in [0, 0.2] and [0.2, 0.5], C_D in [0.5, 1] and [1, 2].
inline constexpr double kSlabBorder = 0.2;
inline constexpr double kCellBorder = 1.0;

/// Texts with line breaks, quotes and letters beyond ASCII, and numbers without short decimal forms.
samara::codebooks::ModelDescription sample_model();
samara::codebooks::BuildRecord sample_build();
samara::codebooks::Provenance sample_provenance();
samara::codebooks::Certificate sample_certificate(const samara::codebooks::Codebook& book);

/// The codebook of the golden file of format 0.1: v = v(0) + C_D t and x = v(0) t + C_D t^2 / 2, exact to
/// round-off, for t in [0, 2] and [2, 3], C_D in [-1, 2], v(0) in [0, 1], with the samples' texts and
/// certificate.
samara::codebooks::Codebook golden_book();

/// The same pieces with every group as a train, equal to rounding.
samara::codebooks::Piece as_trains(const samara::codebooks::Piece& piece);
samara::codebooks::Codebook four_pieces_of_trains();

/// A random train of these ranks over the axes of a random piece, with outputs x, v and E.
samara::codebooks::Piece random_train_piece(const PieceBox& box, unsigned seed, int rank);

/// The codebook of the golden file of format 0.4: a command without time, u = a b and v = 1 + a, exact to
/// round-off, for a in [-1, 2] and b in [0, 1], as one train.
samara::codebooks::Codebook golden_command();
/// The same, certified by climbs, after certificates that found earlier fields wrong.
samara::codebooks::Codebook golden_climbs();

/// The codebook of the golden file of format 0.6: a field over the nodes of a mesh of two triangles, u = k + x + 2 y,
/// exact to round-off, for k in [0, 1], certified at all places.
samara::codebooks::Codebook golden_mesh();

/// The codebook of the golden file of format 0.7, whose C is counted from a front that moves with k and h. With
/// its number s on the axis u = (1 + t) s + k^2 + m and w = s^2 h, exact to round-off, for t in [0, 2], C in
/// [1, 3], k and m in [0, 1], and h in [-2, 2]. On [-1, 1] the front is at 0.1 + 0.2 K - 0.3 H +
/// 0.15 K (2 H^2 - 1), with K and H the others there.
samara::codebooks::Codebook golden_front();

/// The codebook of the golden file of format 0.3: golden_book() with the first piece as one train of both
/// outputs.
samara::codebooks::Codebook golden_trains();

/// The codebook of the golden file of format 0.2: an axis of every kind that a file can hold, and
///   u = v(0) sqrt(m) + t log(C_D) cos(2 angle) plies + k^2 / h, exact to round-off, with t in [0, 2]
///   (legendre elements), C_D in [0.01, 10] (log), angle in [0, pi] (fourier), plies of 1, 2, 4 (discrete),
///   v(0) in [0, 1] (p1), m in [0, 4] (square root), k in [-1, 1] (p2), h in [0.5, 8] (reciprocal).
samara::codebooks::Codebook all_kinds();

/// Random points of the codebook's box: coordinates x count; of discrete axes, random values.
Eigen::MatrixXd random_points(const samara::codebooks::Codebook& book, int count, unsigned seed);

/// One column of the points.
inline std::span<const double> point(const Eigen::MatrixXd& points, Eigen::Index j) {
  return {points.data() + j * points.rows(), static_cast<std::size_t>(points.rows())};
}

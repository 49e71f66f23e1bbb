#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"

/// Answers of a codebook: at points, at fixed times, in batches; values, exact gradients and second
/// derivatives of the separated form.
///
/// What is known before the first point (outputs, held coordinates, times) is worked out once. Then each call
/// interpolates the factors of the free coordinates and multiplies them.
///
/// A query holds scratch space: one per thread. Copies share the prepared factors. Calls do not allocate,
/// lock, or print, with two exceptions: batches on several threads allocate, and the first point in a piece
/// that a large file has not given yet (load.h) reads it, while others that need the same piece wait. The
/// codebook must outlive its queries.
///
/// Usage:
///   Query query(book, {.outputs = {"x", "y"}, .fixed = {{"t", 5.0}}});
///   query.values(q, values, gradient);                 // by query.coordinates()
namespace samara::codebooks {

/// In what numbers factors are kept. Points, weights and answers are doubles always.
enum class Precision {
  double_precision,
  single_precision,
  /// Single floats where they change answers by no more than a twentieth of the largest error that the
  /// certificate has for the output, at trial points; doubles otherwise, where there is no certificate, and
  /// where pieces of a large file are not read yet.
  automatic,
};

struct QueryOptions {
  std::vector<std::string> outputs = {};     ///< in the order wanted; empty: all
  std::map<std::string, double> fixed = {};  ///< coordinates that are held, SI
  Precision precision = Precision::double_precision;
  bool as_stored = false;  ///< quaternions as the build left them, not of the length with which they began
};

/// Answers at single points and at many.
class Query {
 public:
  /// @throws ArgumentError for an unknown name, an output chosen twice, or no coordinate left free;
  /// OutsideBoxError for a coordinate held outside the box.
  explicit Query(const Codebook& book, const QueryOptions& options = {});
  ~Query();
  Query(const Query& other);
  Query(Query&&) noexcept;
  Query& operator=(const Query& other);
  Query& operator=(Query&&) noexcept;

  /// Those that are free, in the order of Codebook::coordinates().
  const std::vector<Coordinate>& coordinates() const;
  int output_count() const;
  /// The precision in use; where `automatic` was asked for, the one that was chosen.
  Precision precision() const;

  /// The chosen outputs at a point.
  /// @param x coordinates() in order, SI
  /// @throws ArgumentError if x or an answer has the wrong size or x is not finite; OutsideBoxError naming
  /// the coordinate, or if the point lies in a gap between the pieces.
  void values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values);

  /// The same with gradient(output, coordinate), exact derivatives of the separated form. At a border of
  /// pieces they are one-sided, from the lower piece.
  void values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
              Eigen::Ref<Eigen::MatrixXd> gradient);

  /// The same with second derivatives: column j + n k of `hessian` (outputs x n n, for n coordinates) holds
  /// those by coordinates j and k.
  void values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
              Eigen::Ref<Eigen::MatrixXd> gradient, Eigen::Ref<Eigen::MatrixXd> hessian);

  /// Many points at once, side by side in the vectors of the machine. Differs from values() by round-off.
  /// @param points coordinates x points  @param values outputs x points
  /// @param threads 0: as many as the machine has
  /// @throws as values(), naming the first point that is refused; then no answer is to be used
  void batch(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
             int threads = 1);

  /// The same with derivatives, point by point as values() gives them.
  /// @param gradients (outputs * coordinates) x points: row o + outputs * k holds d(output o)/dx_k
  void batch(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
             Eigen::Ref<Eigen::MatrixXd> gradients, int threads = 1);

  /// @param hessians (outputs * n n) x points, for n coordinates: row o + outputs * (j + n k) holds the second
  /// derivative of output o by coordinates j and k
  void batch(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
             Eigen::Ref<Eigen::MatrixXd> gradients, Eigen::Ref<Eigen::MatrixXd> hessians, int threads = 1);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace samara::codebooks

#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/certify/certify.h"

/// Certificates of fields: codebooks of one output with one coordinate of space. A field is compared with its
/// reference at the points of the certificate everywhere in space and time at once: points are drawn over the
/// parameters, places are all nodes of a mesh, or lie twice as dense as those of an axis. Whether the error of the
/// discretisation in space counts depends on the reference, which says so by its name. Fields are compared in blocks of
/// times, so that the memory does not grow with their number where the reference gives them one after the other.
namespace samara::codebooks {

/// What a field ought to be, by something that is independent of what built it.
struct FieldReference {
  /// Takes the field at one of the times, in their order: its place among them, and the values at the places.
  using Take = std::function<void(std::size_t time, const Eigen::Ref<const Eigen::VectorXd>& values)>;

  /// The field at the parameters q, which are the coordinates of the codebook but time and space in their order:
  /// times (one row where there is no time) x places. It is called from several threads.
  /// @throws NoResultError where it has no answer
  std::function<Eigen::MatrixXd(std::span<const double> q, const std::vector<double>& times,
                                const Eigen::VectorXd& places)>
      values;
  /// The same time by time, for fields of so many places that all times at once would fill the memory. Empty: values()
  /// is asked.
  std::function<void(std::span<const double> q, const std::vector<double>& times,
                     const Eigen::VectorXd& places, const Take& take)>
      time_by_time = {};
  std::string name;        ///< for readers: "the exact solution", "CVODE on the nodes of the field"
  double tolerance = 0.0;  ///< relative, its own; 0: none
};

/// Measures the codebook of a field, see Certificate; `met` means tolerance and comparisons only.
/// @throws ArgumentError if points < 1, there is no coordinate of space or more than one, more than one output,
/// or the reference is empty or gives another size
Certificate certify(const Codebook& book, const FieldReference& reference, const CertifyOptions& options);

}  // namespace samara::codebooks

#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/codebook.h"
#include "samara/codebooks/trajectory_part.h"

namespace samara::codebooks {

/// Answers at single points. Holds the scratch space of one thread; the codebook must outlive it. Does not
/// allocate after construction.
class Query {
 public:
  explicit Query(const Codebook& book);

  /// All outputs at a point.
  /// @param x coordinates in the order of Codebook::coordinates(), SI
  /// @throws ArgumentError if x or an answer has the wrong size or x is not finite; OutsideBoxError naming
  /// the coordinate, or if the point lies in a gap between the pieces.
  void values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values);

  /// The same with gradient(output, coordinate), exact derivatives of the separated form. At a border of
  /// pieces they are one-sided, from the lower piece.
  void values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
              Eigen::Ref<Eigen::MatrixXd> gradient);

 private:
  struct Group {
    const FieldGroup* field;
    FieldGroup::Workspace workspace;
    std::vector<int> outputs;  ///< their places in the codebook
    Eigen::VectorXd values;
    Eigen::MatrixXd gradient;
  };
  std::vector<Group>& groups_at(std::span<const double> x);

  const Codebook& book_;
  std::vector<std::vector<Group>> pieces_;
};

/// Answers at fixed times, for chosen outputs, again and again at other parameters: what a fit asks for. Each
/// call costs one product over the parameter axes and one small matrix product over the prepared times. Does
/// not allocate after construction; one per thread; the codebook must outlive it.
class TrajectoryQuery {
 public:
  /// @param times s, inside the box
  /// @param outputs names; empty: all
  /// @throws ArgumentError for an unknown output or one named twice, or a codebook without time;
  /// OutsideBoxError for a time outside the box.
  TrajectoryQuery(const Codebook& book, std::vector<double> times,
                  const std::vector<std::string>& outputs = {});

  int time_count() const { return static_cast<int>(times_.size()); }
  int output_count() const { return output_count_; }
  int parameter_count() const { return book_.coordinate_count() - 1; }

  /// @param q the coordinates behind time, in order, SI
  /// @param values times x outputs
  /// @throws as Query::values
  void values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values);

  /// @param derivatives times x (outputs * parameters): column o + outputs * k holds d(output o)/d(q_k)
  void values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values,
              Eigen::Ref<Eigen::MatrixXd> derivatives);

 private:
  /// The part of one group of one piece: the times it answers for.
  struct Part {
    std::span<const pgd::Axis> axes;  ///< behind time
    std::vector<int> rows;            ///< of the times
    std::vector<int> columns;         ///< of the chosen outputs
    GroupAtTimes group;
    Eigen::MatrixXd result;  ///< those times x those outputs

    void copy_result(Eigen::Ref<Eigen::MatrixXd> target, Eigen::Index first_column) const;
  };
  void check(std::span<const double> q) const;

  const Codebook& book_;
  std::vector<double> times_;
  std::vector<char> answered_;  ///< per time, in the present call
  int output_count_ = 0;
  std::vector<Part> parts_;
};

}  // namespace samara::codebooks

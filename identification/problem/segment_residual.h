#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/camera.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Internal to identification/.
namespace samara::identification {

/// Residuals of one segment, and their derivatives by the shared unknowns, its own, and those of the segment
/// it is joined to. Holds the scratch space of one thread; `problem` must outlive it. Does not allocate after
/// construction, beyond what the source does.
///
/// Rows are the observations, then three for each attitude (the turn from measured to model, in body axes),
/// then the priors of the start of a motion, then the differences at the join.
class SegmentResidual {
 public:
  SegmentResidual(const models::TrajectoryFamily& family, const FitProblem& problem, const Segment& segment);

  /// @param shared, own values of the unknowns, in the order of the problem
  /// @param next own unknowns of the next segment, if this one is joined
  /// @returns false if there is no trajectory there, or a residual or a derivative that is wanted is not finite: an
  ///   output may be the root of a negative number
  bool evaluate(const double* shared, const double* own, const double* next, bool with_derivatives);
  /// Whether all residuals are finite at the last point, whatever their derivatives are.
  bool has_residuals() const;
  /// Why evaluate() gave false, in half a sentence; empty where it gave true, and before.
  std::string failure() const;

  const Segment& segment() const { return *segment_; }
  int size() const { return static_cast<int>(residual_.size()); }
  /// Rows that compare with the capture.
  int data_size() const { return data_size_; }
  /// Rows after them that hold what was known of the start beforehand.
  int prior_size() const { return prior_size_; }
  int join_size() const { return size() - data_size_ - prior_size_; }
  long evaluations() const { return evaluations_; }

  /// (model - measured)/scale, per row; at a join, (end - next start) * weight.
  const Eigen::VectorXd& residual() const { return residual_; }
  /// Rows x shared unknowns, and rows x own unknowns.
  const Eigen::MatrixXd& by_shared() const { return by_shared_; }
  const Eigen::MatrixXd& by_own() const { return by_own_; }
  const Eigen::MatrixXd& by_next() const { return by_next_; }
  /// The model's compared outputs without gains and offsets, frames x outputs, SI.
  auto values() const {
    return values_.topLeftCorner(frame_count_, static_cast<Eigen::Index>(problem_->outputs.size()));
  }
  /// What should have been measured: compared outputs with gains and offsets, frames x outputs, SI.
  Eigen::MatrixXd seen(const double* own) const;
  /// The model's attitude at a frame: (w, x, y, z), not normalised. If attitudes are compared.
  Eigen::Vector4d attitude(Eigen::Index frame) const {
    return values_.row(frame).segment<4>(problem_->attitude_column()).transpose();
  }

  /// Per row of the join, in the order of FitProblem::joins; 1 at first.
  void set_join_weights(const Eigen::VectorXd& weights) { join_weights_ = weights; }
  const Eigen::VectorXd& join_weights() const { return join_weights_; }

  /// The offsets that make the mean residual of each output zero at the last point.
  void centre_offsets(Eigen::VectorXd& own) const;

 private:
  /// Output of a frame as the camera should see it.
  double shown_value(Eigen::Index frame, int output) const;
  /// The same as it should be measured, with gain and offset.
  double seen_value(Eigen::Index frame, int output, const double* own) const;
  /// The coordinates of the place at a frame, as the model has them.
  Eigen::Vector3d place(Eigen::Index frame) const;
  void compare(const double* own);
  void compare_attitudes(bool with_derivatives);
  /// Derivatives of a row by the unknowns of the camera, and by others through it.
  void fill_seen(Eigen::Index row, const Observation& observation, double factor);
  /// The same of what the camera makes of a way, the place at a frame or where the segment ends less where it
  /// starts, along one of its axes.
  void fill_axis(Eigen::Index row, Eigen::Index frame, int axis, const Eigen::Vector3d& way, double factor);
  /// Offsets lie in the axes of the camera: the next one is this one, and the way as the camera sees it.
  void join_offset(const JoinRule& rule, int axis, Eigen::Index row, const double* own, const double* next,
                   bool with_derivatives);
  void add_priors(const double* own, bool with_derivatives);
  void join(const double* own, const double* next, bool with_derivatives);
  void join_turn(const JoinRule& rule, Eigen::Index row, const double* next, bool with_derivatives);
  void fill_derivatives();
  /// The derivative of a row by one coordinate, if that is unknown.
  void fill_slot(Eigen::Index row, std::size_t slot, double derivative);
  /// Row of derivatives of requested output `column` at `frame`, times `factor`.
  void fill_row(Eigen::Index row, Eigen::Index frame, Eigen::Index column, double factor);
  /// Whether all derivatives of some rows are finite.
  bool are_slopes_finite(Eigen::Index row, Eigen::Index rows) const;
  /// What a row compares, in words.
  std::string name_of_row(Eigen::Index row) const;

  const FitProblem* problem_;
  const Segment* segment_;
  std::unique_ptr<models::TrajectorySource> source_;
  std::size_t source_slots_ = 0;  ///< on which the source depends: all but the gains
  Eigen::Index frame_count_ = 0;  ///< without the end of a joined segment
  int data_size_ = 0;
  int prior_size_ = 0;
  Eigen::VectorXd q_;
  Eigen::MatrixXd values_;
  Eigen::MatrixXd derivatives_;
  Eigen::VectorXd residual_;
  Eigen::VectorXd join_weights_;
  Eigen::MatrixXd by_shared_, by_own_, by_next_;
  CameraView view_;           ///< at the last point
  std::vector<int> axis_of_;  ///< of the camera, per compared output; -1: none
  std::vector<char> turns_;   ///< per compared output: an angle that turns with the camera
  long evaluations_ = 0;
  bool has_trajectory_ = true;  ///< at the last point
  bool is_finite_ = true;       ///< what was wanted there
};

/// One per segment of the problem.
/// @param like residuals of the same segments whose weights at joins are taken over; none: they stay 1
std::vector<SegmentResidual> make_residuals(const models::TrajectoryFamily& family, const FitProblem& problem,
                                            const std::vector<SegmentResidual>& like = {});

/// The first failure() among them; empty if there is none.
std::string failure_of(const std::vector<SegmentResidual>& residuals);

/// Of all of them.
long evaluations_of(const std::vector<SegmentResidual>& residuals);

}  // namespace samara::identification

#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/composition/motion_symmetry.h"
#include "samara/codebooks/composition/reduced_attitude.h"
#include "samara/codebooks/query/query.h"
#include "samara/models/interface/parametric_model.h"

namespace samara::codebooks {

/// A state that is outside the box of a codebook at the start of a window.
struct LeavingState {
  std::size_t state = 0;
  double value = 0.0;                  ///< reduced
  const MotionImage* image = nullptr;  ///< in which it is; null: as it is
};

/// Where a window begins.
struct WindowStart {
  Eigen::VectorXd start;               ///< all states as they are
  const MotionImage* image = nullptr;  ///< that lies in the box; null: none is needed
  Eigen::VectorXd inside;              ///< that image of them
  Eigen::VectorXd reduced;             ///< without heading, where an attitude is reduced
  Eigen::MatrixXd reduced_by_start;    ///< where derivatives are wanted
  std::vector<double> shift;           ///< what the codebook's states are displaced by
};

/// One codebook as the flow map of its model over a window (flow_map.h), for the starts that its box holds.
class WindowChart {
 public:
  /// The codebook must outlive the chart. @throws ArgumentError as FlowMap
  explicit WindowChart(const Codebook& book);

  const Codebook& book() const { return *book_; }
  const std::vector<std::string>& states() const { return states_; }
  const std::vector<Coordinate>& parameters() const { return parameters_; }
  double window() const { return window_; }

  void set_parameters(std::span<const double> q);

  /// Loads the start of a window, or an image of it (motion_symmetry.h) where that is needed.
  /// @returns why it is outside the box, if it is: as it is, or for what an image that helps the attitude leaves
  std::optional<LeavingState> open(WindowStart& at, bool with_derivatives);

  /// Whether a state is an angle or a number of the quaternion.
  bool is_of_attitude(std::size_t state) const;

  /// States at a time of the window that was opened, and their derivatives by those at its start and the parameters.
  void answer(const WindowStart& at, double t, Eigen::VectorXd& x, Eigen::MatrixXd* by_start,
              Eigen::MatrixXd* by_parameters);

  /// "qx = 1.2, without yaw, is outside [-1, 1]"
  std::string words(const LeavingState& leaving) const;

 private:
  /// How a state goes from window to window.
  struct Carried {
    int output = 0;                 ///< place in the codebook's outputs
    std::optional<int> coordinate;  ///< of "s(0)"; none: the state is only displaced, or held
    bool held = false;              ///< the same at the start of every window: of a reduced attitude
    double origin = 0.0;            ///< initial value in the codebook, of a state that is only displaced
    double lower = 0.0, upper = 0.0;
    bool wraps = false;  ///< an angle: full turns do not matter
  };
  Carried carry(const models::ModelInfo& info, std::size_t state, bool is_angle) const;
  /// As it is, or its image.
  std::optional<LeavingState> load(WindowStart& at, bool with_derivatives);
  /// Whether f at the image of a start is the image of f, at the present parameters: what the draws of
  /// motion_symmetry() have missed, since it acts in a small part of the box, is seen where it matters.
  bool is_kept(const MotionImage& image, const Eigen::VectorXd& start);
  /// Reduced, as the start.
  void answer_reduced(double t, const WindowStart& at, Eigen::VectorXd& x, Eigen::MatrixXd* by_start,
                      Eigen::MatrixXd* by_parameters);

  const Codebook* book_;
  Query query_;
  std::vector<std::string> states_, units_;
  std::vector<Carried> carried_;
  std::optional<ReducedAttitude> attitude_;
  MotionSymmetry symmetry_;
  models::ParametricModel model_;
  models::ParametricModel::Workspace workspace_;
  /// Free coordinates of the model; those of initial values do not matter to f.
  std::vector<double> model_parameters_;
  std::vector<Coordinate> parameters_;
  std::vector<int> parameter_places_;  ///< coordinates of the codebook
  double window_ = 0.0;

  std::vector<double> point_;
  Eigen::VectorXd values_;
  Eigen::MatrixXd gradient_;
  Eigen::MatrixXd by_reduced_, by_heading_;
};

}  // namespace samara::codebooks

#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "samara/models/interface/model.h"

namespace samara::models {

/// A free coordinate of a parametric problem: a parameter of the model, or the initial value "s(0)" of state
/// s.
struct FreeCoordinate {
  std::string name;
  std::string unit;
  bool is_initial = false;
  int index = 0;  ///< of the parameter, or of the state
};

/// Derivatives of the right-hand side at one point. Allocate once, use often.
struct RhsDerivatives {
  Eigen::MatrixXd df_dx;  ///< states x states
  Eigen::MatrixXd df_dq;  ///< states x free coordinates (zero columns for initial values)
};

/// A model with some coordinates fixed and the others free, in a stated order:
///   x' = f(t, x; q),  x(0) = x0(q),  q = the free coordinates.
///
/// Value type, immutable, safe to share between threads; evaluation does not allocate beyond the workspace.
class ParametricModel {
 public:
  /// Scratch space of one thread.
  struct Workspace {
    ParameterValues p;
    Eigen::MatrixXd df_dp;
    /// All parameters at the point `q` of a model with that base: derived defaults are costly and change with
    /// q alone.
    ParameterValues complete;
    std::vector<double> q;
    std::shared_ptr<const ParameterValues> base;
    /// Derivatives of all parameters by the free ones, at the same point, where the model has them.
    Eigen::MatrixXd tangents;
    enum class Tangents { unknown, known, none } has_tangents = Tangents::unknown;
  };

  /// @param fixed values (SI) of parameters and of initial values "s(0)"
  /// @param free names of parameters and initial values that stay free
  /// @throws ArgumentError for an unknown name, a name both fixed and free or twice free, a value that is not
  ///   finite or outside the parameter's meaning, or a required parameter that is neither fixed nor free.
  ParametricModel(std::shared_ptr<const Model> model, const std::map<std::string, double>& fixed,
                  const std::vector<std::string>& free);

  const Model& model() const { return *model_; }
  std::shared_ptr<const Model> shared_model() const { return model_; }
  const std::vector<FreeCoordinate>& free() const { return free_; }
  /// What the caller fixed, as given.
  const std::map<std::string, double>& fixed() const { return fixed_; }
  int state_count() const { return static_cast<int>(model_->info().states.size()); }
  int free_count() const { return static_cast<int>(free_.size()); }

  Workspace make_workspace() const;

  /// f(t, x; q). Does not check q: see check().
  void rhs(double t, std::span<const double> x, std::span<const double> q, std::span<double> dxdt,
           Workspace& workspace) const;

  /// f and its derivatives by x and by q. `derivatives` is resized on its first use only.
  void rhs_with_derivatives(double t, std::span<const double> x, std::span<const double> q,
                            std::span<double> dxdt, RhsDerivatives& derivatives, Workspace& workspace) const;

  /// f at many points: t (points), x (states x points), q (free coordinates x points), into dxdt (states x
  /// points). Fastest where neighbours have the same q.
  void rhs_at_points(const Eigen::Ref<const Eigen::VectorXd>& t, const Eigen::Ref<const Eigen::MatrixXd>& x,
                     const Eigen::Ref<const Eigen::MatrixXd>& q, Eigen::Ref<Eigen::MatrixXd> dxdt) const;

  /// df_dx likewise, into (states^2 x points), column-major.
  void jacobians_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                           const Eigen::Ref<const Eigen::MatrixXd>& x,
                           const Eigen::Ref<const Eigen::MatrixXd>& q,
                           Eigen::Ref<Eigen::MatrixXd> jacobians) const;

  /// x(0) at q. Its derivative by q_j is one where q_j is the initial value of that state, else zero.
  void initial(std::span<const double> q, std::span<double> x0) const;

  /// The parameters at q as the model takes them: what is fixed or free is given.
  ParameterValues parameter_values(std::span<const double> q) const;
  /// The same into p, which allocates on its first use only.
  void parameter_values(std::span<const double> q, ParameterValues& p) const;

  /// All parameters at q with defaults filled in, in the order of the model.
  std::vector<double> parameters(std::span<const double> q) const;

  Scales scales(std::span<const double> q) const;

  /// @throws ArgumentError naming the coordinate if a value is not finite or outside the parameter's meaning,
  /// or if parameters do not fit together (Model::problem) or an initial quaternion is zero.
  void check(std::span<const double> q) const;

 private:
  /// Completes the parameters, unless the workspace has them already.
  void complete(std::span<const double> q, Workspace& workspace) const;
  /// All parameters at the points q, in columns.
  Eigen::MatrixXd complete_at_points(const Eigen::Ref<const Eigen::MatrixXd>& q) const;
  void check_attitude(std::span<const double> q) const;

  std::shared_ptr<const Model> model_;
  std::map<std::string, double> fixed_;
  std::vector<FreeCoordinate> free_;
  std::vector<int> free_parameters_;  ///< indices of the parameters among them, in their order
  /// Fixed parameters; free ones are marked given. Shared by copies, and by no other model: by it a
  /// workspace is matched to its model.
  std::shared_ptr<const ParameterValues> base_;
  std::vector<double> base_initial_;  ///< fixed or default initial values
};

}  // namespace samara::models

#pragma once

#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

/// A model is an ordinary differential equation x' = f(t, x, p) with named, united states and parameters.
///
/// Models are immutable and may be shared between threads. Everything is in SI units; angles are in rad;
/// a dimensionless quantity has the unit "1".
namespace samara::models {

struct ParameterInfo {
  std::string name;
  std::string unit;  ///< SI, as text: "kg/m^3"; "1" if dimensionless
  /// The value used when none is given. Empty: the parameter must be given, or, if `derived` says how, it
  /// follows from the others.
  std::optional<double> default_value = {};
  /// Formula of a default that depends on other parameters ("8/3 fluid_density (area/pi)^(3/2)"), or empty.
  std::string derived = {};
  std::string description = {};
  /// Open lower bound of meaningful values: they must be greater (or equal, if `lower_inclusive`).
  double lower = -std::numeric_limits<double>::infinity();
  bool lower_inclusive = false;
  /// Closed upper bound of meaningful values.
  double upper = std::numeric_limits<double>::infinity();
};

/// Whether `value` respects the bounds of the parameter's meaning (NaN does not).
bool in_meaning(const ParameterInfo& parameter, double value);

/// The bounds in words: "> 0 kg/m^3", ">= 0", "from 0 to 1"; empty if there are none.
std::string meaning_text(const ParameterInfo& parameter);

struct StateInfo {
  std::string name;
  std::string unit;
  double default_initial = 0.0;
  std::string description = {};
  std::optional<double> scale = {};  ///< characteristic size, if it does not follow from Scales by the unit
};

/// Where the state starts whose start is no coordinate: at the value that is held of "s(0)", else at its default.
double held_start(const StateInfo& state, const std::map<std::string, double>& held);

/// What follows from the states at an instant and is given beside them: the place of a tip, an energy, a current.
struct OutputInfo {
  std::string name;
  std::string unit;
  std::string description = {};
};

/// One term of the forces on a body: "drag", "gravity and buoyancy".
struct ForceTermInfo {
  std::string name;
  std::string description = {};
};

/// Force, torque and power of one term at an instant. Force and torque are in body axes, the torque about the
/// body's origin; a planar model has its chord along the first axis, its normal along the second, its torque
/// along the third, and everything per unit span. Units N, N m, W (per m of span), or 1 for a dimensionless
/// model.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  double power = 0.0;  ///< on the motion relative to the fluid: force . u_r + torque . w
};

/// How consecutive states turn when the world is turned about the vertical.
enum class StateGroupKind {
  position,    ///< three world coordinates of a point
  vector,      ///< a vector in world axes
  quaternion,  ///< attitude (w, x, y, z), body to world; f keeps its norm only to first order in time
};

struct StateGroup {
  StateGroupKind kind = StateGroupKind::position;
  int first = 0;  ///< index of the first of its states
};

struct ModelInfo {
  std::string name;
  std::string title;
  std::string equations;  ///< as text, in the names below
  std::string frames;     ///< what the axes mean, in words
  std::string source;     ///< paper or book, with equation numbers
  std::string validity;   ///< range of validity, in words
  /// Symmetries of the motion. "translation of x": f does not depend on the state x. "rotation about
  /// z": f turns with the states of `groups`. Other words are for readers.
  std::vector<std::string> symmetries = {};
  std::vector<StateInfo> states;
  std::vector<ParameterInfo> parameters;
  std::vector<OutputInfo> outputs = {};  ///< that follow from the states, see Model::outputs
  /// Names of parameters in which f is affine, in all of them together: f = f_0 + sum_j p_j f_j.
  std::vector<std::string> affine_in = {};
  std::vector<ForceTermInfo> force_terms = {};  ///< empty: the model does not list its force by terms
  std::vector<StateGroup> groups = {};          ///< states that belong together; others do not turn
  bool per_span = false;  ///< a planar model: forces, torques, powers and energy are per metre of span
};

/// Units of Wrench and of the kinetic energy.
struct ForceUnits {
  std::string force, torque, power, energy;
};

/// Characteristic sizes of a motion, in SI units. The scale of every state follows from them by its unit.
struct Scales {
  double length = 1.0;
  double time = 1.0;
  double velocity = 1.0;
};

/// Values of all parameters of a model, in the order of ModelInfo::parameters. Where `given` is false, the
/// model puts the default, or the derived default, in place of `value`.
struct ParameterValues {
  std::vector<double> value;
  std::vector<char> given;
};

struct StepKernels;

class Model {
 public:
  virtual ~Model() = default;

  virtual const ModelInfo& info() const = 0;

  /// f(t, x, p). Sizes: x and dxdt number of states, p all parameters. Does not allocate, does not check.
  virtual void rhs(double t, std::span<const double> x, const ParameterValues& p,
                   std::span<double> dxdt) const = 0;

  /// f and its derivatives: df_dx (states x states) and df_dp (states x all parameters, the chain through
  /// derived defaults included; zero columns for parameters that are not given). Does not allocate, does not
  /// check.
  virtual void rhs_with_derivatives(double t, std::span<const double> x, const ParameterValues& p,
                                    std::span<double> dxdt, Eigen::Ref<Eigen::MatrixXd> df_dx,
                                    Eigen::Ref<Eigen::MatrixXd> df_dp) const = 0;

  /// The same in two parts, for models whose derivatives by all parameters are costly while few are free and
  /// defaults do not change: first the derivatives of the completed parameters by the given ones that
  /// `wanted` lists (by index), into `tangents` (parameters x wanted).
  /// @returns false if the model has no such parts (the default); then rhs_with_tangents is not called.
  virtual bool completion_tangents(const ParameterValues& p, std::span<const int> wanted,
                                   Eigen::Ref<Eigen::MatrixXd> tangents) const;

  /// Then f at completed parameters, and its derivatives by the states and along `tangents` of the parameters
  /// (df_dq: states x columns of tangents). Does not allocate, does not check.
  virtual void rhs_with_tangents(double t, std::span<const double> x, std::span<const double> all,
                                 const Eigen::Ref<const Eigen::MatrixXd>& tangents, std::span<double> dxdt,
                                 Eigen::Ref<Eigen::MatrixXd> df_dx, Eigen::Ref<Eigen::MatrixXd> df_dq) const;

  /// The force by term, in the order of ModelInfo::force_terms. Inertial forces (of the body and of the fluid
  /// it sets in motion) are a term like others, so that the sum is what changes the momentum in body axes.
  virtual void forces(double t, std::span<const double> x, const ParameterValues& p,
                      std::span<Wrench> terms) const;

  /// Kinetic energy of body and fluid in their motion relative to the undisturbed fluid [J, or J/m of span]:
  /// the powers of all terms sum to its rate where the undisturbed fluid is steady and uniform. Empty: the
  /// model has none.
  virtual std::optional<double> kinetic_energy(double t, std::span<const double> x,
                                               const ParameterValues& p) const;

  /// The outputs of ModelInfo::outputs, y = g(t, x, p), in their order.
  virtual void outputs(double t, std::span<const double> x, const ParameterValues& p,
                       std::span<double> y) const;

  /// The same with their derivatives: dy_dt at fixed x (outputs), dy_dx (outputs x states), dy_dp (outputs x all
  /// parameters, zero columns for those that are not given).
  virtual void outputs_with_derivatives(double t, std::span<const double> x, const ParameterValues& p,
                                        std::span<double> y, Eigen::Ref<Eigen::VectorXd> dy_dt,
                                        Eigen::Ref<Eigen::MatrixXd> dy_dx,
                                        Eigen::Ref<Eigen::MatrixXd> dy_dp) const;

  /// f at many points, one per column: t (points), x (states x points), p (all parameters x points, complete), into
  /// dxdt (states x points). Does not check. By default one point after another.
  virtual void rhs_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                             const Eigen::Ref<const Eigen::MatrixXd>& x,
                             const Eigen::Ref<const Eigen::MatrixXd>& p,
                             Eigen::Ref<Eigen::MatrixXd> dxdt) const;

  /// df_dx at many points likewise, into (states^2 x points), column-major.
  virtual void jacobians_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                                   const Eigen::Ref<const Eigen::MatrixXd>& x,
                                   const Eigen::Ref<const Eigen::MatrixXd>& p,
                                   Eigen::Ref<Eigen::MatrixXd> jacobians) const;

  /// Parameters with defaults and derived defaults filled in.
  virtual std::vector<double> completed(const ParameterValues& p) const = 0;

  /// The same into `all`, one number per parameter; models of Samara do not allocate here.
  virtual void complete_into(const ParameterValues& p, std::span<double> all) const;

  /// What is wrong with a parameter point that lies within the meaning of every single parameter: a sentence
  /// ("the inertia is not positive definite"), or empty.
  virtual std::string problem(const ParameterValues& p) const;

  /// Characteristic sizes at a parameter point.
  virtual Scales scales(const ParameterValues& p) const = 0;

  /// Compiled fixed steps of the model's law, for one trajectory and for packs of them; laws of Samara have
  /// them. Null: there are none, and fixed-step methods go through rhs.
  virtual const StepKernels* step_kernels() const { return nullptr; }
};

/// f = constant + slopes * coefficients at one point: f split by the parameters in which it is affine.
struct AffineSplit {
  std::vector<std::string> names;  ///< of the coefficients: ModelInfo::affine_in
  Eigen::VectorXd constant;        ///< f with all of them zero
  Eigen::MatrixXd slopes;          ///< states x coefficients
};

/// The affine split at a point; empty names if the model has none. The derived defaults of other parameters
/// are taken as constants.
/// @throws ArgumentError if ModelInfo::affine_in names something that is no parameter.
AffineSplit affine_split(const Model& model, double t, std::span<const double> x, const ParameterValues& p);

/// The scale of a state: its own, or length, velocity, 1/time by its unit ("m", "m/s", "rad/s" or "1/s"), else 1.
double state_scale(const StateInfo& state, const Scales& scales);
/// Whether that follows from what the model says, and is not 1 for want of it.
bool has_scale(const StateInfo& state);

/// "s", or "1" for a model all of whose states and parameters are dimensionless.
std::string time_unit(const ModelInfo& info);

/// "N", "N m", "W", "J"; "N/m", "N", "W/m", "J/m" for a planar model, "1" for a dimensionless one.
ForceUnits force_units(const ModelInfo& info);

}  // namespace samara::models

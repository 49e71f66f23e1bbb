#include "samara/models/integrators/cvodes_solver.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include <cvodes/cvodes_ls.h>
#include <fmt/format.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"
#include "samara/base/require.h"
#include "samara/models/equations/equation_model.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

/// At least, where something acts for a while only.
constexpr int kStepsOverTime = 200;

void check_options(const IntegrateOptions& options) {
  check_relative_tolerance(options.relative_tolerance);
  check_max_steps(options.max_steps);
  require_not_negative(options.max_step, "max_step [s]");
}

/// For calls of SUNDIALS that fail only if memory is short, or if we are wrong.
void must(bool success, const char* call) {
  if (!success) throw Error(std::string("internal: ") + call + " of SUNDIALS failed");
}
void must(int flag, const char* call) {
  must(flag == CV_SUCCESS, call);
}

/// The size of a coordinate against which its sensitivities are weighed: a change by this much is a large
/// one. A parameter at zero, or near it by chance, must not loosen the tolerance; its default, or 1 where it
/// has no unit, stands in then.
double characteristic_size(const ModelInfo& info, const FreeCoordinate& coordinate, double value,
                           const Scales& scales) {
  const auto index = static_cast<std::size_t>(coordinate.index);
  if (coordinate.is_initial) return std::max(std::abs(value), state_scale(info.states[index], scales));
  const ParameterInfo& parameter = info.parameters[index];
  const double usual = std::abs(parameter.default_value.value_or(parameter.unit == "1" ? 1.0 : 0.0));
  const double size = std::max(std::abs(value), usual);
  return size > 0.0 ? size : 1.0;
}

IntegrateStatus status_of(int flag) {
  switch (flag) {
    case CV_ERR_FAILURE:
    case CV_CONV_FAILURE:
      return IntegrateStatus::step_too_small;
    case CV_FIRST_RHSFUNC_ERR:
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR:
    case CV_FIRST_SRHSFUNC_ERR:
    case CV_REPTD_SRHSFUNC_ERR:
    case CV_UNREC_SRHSFUNC_ERR:
      return IntegrateStatus::not_finite;
    default:
      return IntegrateStatus::failed;
  }
}

std::string reason(IntegrateStatus status, int flag, const IntegrateOptions& options) {
  switch (status) {
    case IntegrateStatus::step_too_small:
      return "no step meets the relative tolerance " + number_text(options.relative_tolerance);
    default:
      const std::unique_ptr<char, decltype(&std::free)> name(CVodeGetReturnFlagName(flag), &std::free);
      return std::string("CVODES says ") + name.get();
  }
}

}  // namespace

CvodesSolver::CvodesSolver(const ParametricModel& model, const IntegrateOptions& options,
                           bool with_sensitivities)
    : model_(model),
      options_(options),
      sensitivity_count_(with_sensitivities ? model.free_count() : 0),
      workspace_(model.make_workspace()),
      rate_(static_cast<std::size_t>(model.state_count())) {
  check_options(options_);
  create_state_solver();
  if (sensitivity_count_ > 0) create_sensitivity_solver();
}

void CvodesSolver::create_state_solver() {
  const int n = model_.state_count();
  x_.reset(N_VNew_Serial(n, context_));
  tolerance_.reset(N_VNew_Serial(n, context_));
  must(x_ && tolerance_, "N_VNew_Serial");
  N_VConst(0.0, x_.get());

  cvodes_.reset(CVodeCreate(options_.stiff ? CV_BDF : CV_ADAMS, context_));
  must(cvodes_ != nullptr, "CVodeCreate");
  // A library does not print; flags become statuses.
  must(CVodeSetErrFile(cvodes_.get(), nullptr), "CVodeSetErrFile");
  must(CVodeInit(cvodes_.get(), state_rate, 0.0, x_.get()), "CVodeInit");
  must(CVodeSetUserData(cvodes_.get(), this), "CVodeSetUserData");
  if (options_.max_step > 0.0) must(CVodeSetMaxStep(cvodes_.get(), options_.max_step), "CVodeSetMaxStep");
  if (options_.stiff) {
    matrix_.reset(SUNDenseMatrix(n, n, context_));
    linear_solver_.reset(SUNLinSol_Dense(x_.get(), matrix_.get(), context_));
    must(matrix_ && linear_solver_, "SUNLinSol_Dense");
    must(CVodeSetLinearSolver(cvodes_.get(), linear_solver_.get(), matrix_.get()), "CVodeSetLinearSolver");
    must(CVodeSetJacFn(cvodes_.get(), jacobian), "CVodeSetJacFn");
  } else {
    nonlinear_solver_.reset(SUNNonlinSol_FixedPoint(x_.get(), 0, context_));
    must(nonlinear_solver_ != nullptr, "SUNNonlinSol_FixedPoint");
    must(CVodeSetNonlinearSolver(cvodes_.get(), nonlinear_solver_.get()), "CVodeSetNonlinearSolver");
  }
}

void CvodesSolver::create_sensitivity_solver() {
  s_ = VectorArrayHandle(sensitivity_count_, x_.get());
  must(s_.get() != nullptr, "N_VCloneVectorArray");
  for (int j = 0; j < sensitivity_count_; ++j) N_VConst(0.0, s_.get()[j]);
  // Staggered: the states of a step are settled first, so that all iterations for the sensitivities share one
  // linearisation.
  must(CVodeSensInit(cvodes_.get(), sensitivity_count_, CV_STAGGERED, sensitivity_rate, s_.get()),
       "CVodeSensInit");
  // Relative tolerance of the states; absolute tolerances theirs over the characteristic size of q_j.
  must(CVodeSensEEtolerances(cvodes_.get()), "CVodeSensEEtolerances");
  must(CVodeSetSensErrCon(cvodes_.get(), SUNTRUE), "CVodeSetSensErrCon");
  if (options_.stiff) return;
  sensitivity_nonlinear_solver_.reset(SUNNonlinSol_FixedPointSens(sensitivity_count_, x_.get(), 0, context_));
  must(sensitivity_nonlinear_solver_ != nullptr, "SUNNonlinSol_FixedPointSens");
  must(CVodeSetNonlinearSolverSensStg(cvodes_.get(), sensitivity_nonlinear_solver_.get()),
       "CVodeSetNonlinearSolverSensStg");
}

void CvodesSolver::start(std::span<const double> q, double end) {
  q_.assign(q.begin(), q.end());
  evaluations_ = 0;
  linearised_x_.clear();
  not_finite_at_ = -1.0;
  thrown_ = nullptr;

  const std::vector<StateInfo>& states = model_.model().info().states;
  const Scales scales = model_.scales(q_);
  const std::span<double> absolute = entries(tolerance_.get());
  for (std::size_t i = 0; i < absolute.size(); ++i) {
    absolute[i] = options_.relative_tolerance * state_scale(states[i], scales);
  }
  model_.initial(q_, entries(x_.get()));
  must(CVodeReInit(cvodes_.get(), 0.0, x_.get()), "CVodeReInit");
  must(CVodeSVtolerances(cvodes_.get(), options_.relative_tolerance, tolerance_.get()), "CVodeSVtolerances");
  must(CVodeSetStopTime(cvodes_.get(), end), "CVodeSetStopTime");
  // 0: without a bound.
  if (options_.max_step == 0.0)
    must(CVodeSetMaxStep(cvodes_.get(), acts_for_a_while(end, scales) ? end / kStepsOverTime : 0.0),
         "CVodeSetMaxStep");
  if (sensitivity_count_ > 0) start_sensitivities(scales);
}

bool CvodesSolver::acts_for_a_while(double end, const Scales& scales) {
  const Equations* const text = equations_of(model_.model());
  if (text == nullptr || end <= 0.0 || !mention_time(*text)) return false;
  // What multiplies a state has no effect where that is 0.
  std::vector<double> moved(states().begin(), states().end());
  for (std::size_t i = 0; i < moved.size(); ++i)
    moved[i] += state_scale(model_.model().info().states[i], scales);
  return acts_for_a_while_at(states(), end) || acts_for_a_while_at(moved, end);
}

bool CvodesSolver::acts_for_a_while_at(std::span<const double> x, double end) {
  constexpr Eigen::Index kApart = 8;
  constexpr double kSmooth = 0.03;  // three periods of a sine bend less
  Eigen::MatrixXd rates(std::ssize(rate_), kStepsOverTime + 1);
  for (Eigen::Index k = 0; k < rates.cols(); ++k) {
    model_.rhs(end * static_cast<double>(k) / kStepsOverTime, x, q_, rate_, workspace_);
    rates.col(k) = Eigen::Map<const Eigen::VectorXd>(rate_.data(), std::ssize(rate_));
  }
  if (!rates.allFinite()) return true;
  const Eigen::VectorXd ranges = rates.rowwise().maxCoeff() - rates.rowwise().minCoeff();
  if (ranges.maxCoeff() == 0.0) return true;  // what it acts on is not there yet
  for (Eigen::Index k = 0; k < rates.cols() - 1; ++k) {
    const Eigen::Index before = k - k % kApart;
    const double share = static_cast<double>(k - before) / kApart;
    const Eigen::VectorXd line = rates.col(before) + share * (rates.col(before + kApart) - rates.col(before));
    if (((rates.col(k) - line).cwiseAbs().array() > kSmooth * ranges.array()).any()) return true;
  }
  return false;
}

void CvodesSolver::start_sensitivities(const Scales& scales) {
  std::vector<double> sizes;
  for (std::size_t j = 0; j < q_.size(); ++j) {
    const FreeCoordinate& coordinate = model_.free()[j];
    sizes.push_back(characteristic_size(model_.model().info(), coordinate, q_[j], scales));
    N_VConst(0.0, s_[j]);
    if (coordinate.is_initial) entries(s_[j])[static_cast<std::size_t>(coordinate.index)] = 1.0;
  }
  must(CVodeSetSensParams(cvodes_.get(), nullptr, sizes.data(), nullptr), "CVodeSetSensParams");
  must(CVodeSensReInit(cvodes_.get(), CV_STAGGERED, s_.get()), "CVodeSensReInit");
}

IntegrateStatus CvodesSolver::step(double& t, double end, std::string& message) {
  double after = t;
  const int flag = CVode(cvodes_.get(), end, x_.get(), &after, CV_ONE_STEP);
  if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
  if (flag < 0) {
    const IntegrateStatus status = status_of(flag);
    message = status == IntegrateStatus::not_finite ? not_finite_text() : reason(status, flag, options_);
    return status;
  }
  if (!(after > t)) {
    // Steps shrank to nothing in front of a time where f does not exist, or in front of a singularity.
    const bool in_front = not_finite_at_ >= t;
    message = in_front ? not_finite_text() : "the step is too small to advance time";
    return in_front ? IntegrateStatus::not_finite : IntegrateStatus::step_too_small;
  }
  t = after;
  return IntegrateStatus::done;
}

/// With the first state whose rate is not: else it is a derivative that does not exist.
std::string CvodesSolver::not_finite_text() const {
  const auto bad = std::ranges::find_if_not(rate_, [](double rate) { return std::isfinite(rate); });
  const std::string which =
      bad == rate_.end()
          ? std::string()
          : fmt::format(" (the rate of \"{}\" is {})",
                        model_.model().info().states[static_cast<std::size_t>(bad - rate_.begin())].name,
                        *bad);
  return fmt::format("the right-hand side is not finite{}, however small the step", which);
}

void CvodesSolver::interpolate(double t) {
  if (t == 0.0) return;  // the initial values are still in place: exact
  must(CVodeGetDky(cvodes_.get(), t, 0, x_.get()), "CVodeGetDky");
  if (sensitivity_count_ > 0) must(CVodeGetSensDky(cvodes_.get(), t, 0, s_.get()), "CVodeGetSensDky");
}

void CvodesSolver::linearise(double t, std::span<const double> x) {
  if (t == linearised_t_ && std::ranges::equal(x, linearised_x_)) return;
  model_.rhs_with_derivatives(t, x, q_, rate_, derivatives_, workspace_);
  ++evaluations_;
  linearised_t_ = t;
  linearised_x_.assign(x.begin(), x.end());
}

/// Runs the body of a callback at time t, which says whether its result is finite. An exception must not
/// cross the C code: it waits for step() to throw it again.
template <class Body>
int CvodesSolver::guarded(double t, Body body) {
  try {
    if (body()) return 0;
    not_finite_at_ = t;
    return 1;
  } catch (...) {
    thrown_ = std::current_exception();
    return -1;
  }
}

int CvodesSolver::state_rate(double t, N_Vector x, N_Vector dxdt, void* self) {
  CvodesSolver& solver = *static_cast<CvodesSolver*>(self);
  return solver.guarded(t, [&] {
    solver.model_.rhs(t, entries(x), solver.q_, entries(dxdt), solver.workspace_);
    ++solver.evaluations_;
    if (all_finite(entries(dxdt))) return true;
    std::ranges::copy(entries(dxdt), solver.rate_.begin());
    return false;
  });
}

int CvodesSolver::jacobian(double t, N_Vector x, N_Vector, SUNMatrix matrix, void* self, N_Vector, N_Vector,
                           N_Vector) {
  CvodesSolver& solver = *static_cast<CvodesSolver*>(self);
  return solver.guarded(t, [&] {
    solver.linearise(t, entries(x));
    const Eigen::MatrixXd& df_dx = solver.derivatives_.df_dx;
    std::copy_n(df_dx.data(), df_dx.size(), SUNDenseMatrix_Data(matrix));  // both column by column
    return df_dx.allFinite();
  });
}

int CvodesSolver::sensitivity_rate(int count, double t, N_Vector x, N_Vector, N_Vector* s, N_Vector* dsdt,
                                   void* self, N_Vector, N_Vector) {
  CvodesSolver& solver = *static_cast<CvodesSolver*>(self);
  return solver.guarded(t, [&] {
    solver.linearise(t, entries(x));
    const RhsDerivatives& f = solver.derivatives_;
    bool finite = true;
    for (int j = 0; j < count; ++j) {
      const Eigen::Map<const Eigen::VectorXd> s_j(N_VGetArrayPointer(s[j]), f.df_dx.rows());
      Eigen::Map<Eigen::VectorXd> rate_j(N_VGetArrayPointer(dsdt[j]), f.df_dx.rows());
      rate_j.noalias() = f.df_dx * s_j;
      rate_j += f.df_dq.col(j);
      finite = finite && rate_j.allFinite();
    }
    return finite;
  });
}

}  // namespace samara::models

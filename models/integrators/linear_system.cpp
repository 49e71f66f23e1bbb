#include "samara/models/integrators/linear_system.h"

#include <algorithm>
#include <cmath>
#include <exception>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/integrators/sundials_handles.h"

namespace samara::models {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

bool is_symmetric(const Sparse& matrix) {
  const Sparse transpose = matrix.transpose();
  return (matrix - transpose).norm() <= 1e-13 * matrix.norm();
}

/// A factorised matrix: LDL^T where it is symmetric, else LU.
class Factorised {
 public:
  explicit Factorised(bool symmetric) : symmetric_(symmetric) {}

  bool factorise(const Sparse& matrix) {
    if (symmetric_) {
      ldlt_.compute(matrix);
      return ldlt_.info() == Eigen::Success;
    }
    lu_.compute(matrix);
    return lu_.info() == Eigen::Success;
  }
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const {
    return symmetric_ ? Eigen::VectorXd(ldlt_.solve(b)) : Eigen::VectorXd(lu_.solve(b));
  }

 private:
  bool symmetric_;
  Eigen::SimplicialLDLT<Sparse> ldlt_;
  Eigen::SparseLU<Sparse> lu_;
};

using State = Eigen::Map<Eigen::VectorXd>;

State state_of(N_Vector vector) {
  return {N_VGetArrayPointer(vector), static_cast<Eigen::Index>(N_VGetLength(vector))};
}

/// What CVODE calls back for.
struct Callbacks {
  const LinearSystem* system;
  Factorised mass;
  Factorised iteration;       ///< M + gamma K
  double gamma = 0.0;         ///< of `iteration`; 0: none yet
  void* cvode = nullptr;      ///< that asks
  Eigen::VectorXd load;       ///< scratch
  std::exception_ptr thrown;  ///< in a callback; carried past the C code

  /// M^-1 (f - K u)
  static int rate(double t, N_Vector u, N_Vector slope, void* data) {
    auto& self = *static_cast<Callbacks*>(data);
    try {
      self.load.setZero();
      if (self.system->load) self.system->load(t, self.load);
      self.load -= self.system->stiffness * state_of(u);
      state_of(slope) = self.mass.solve(self.load);
      return 0;
    } catch (...) {
      self.thrown = std::current_exception();
      return -1;
    }
  }

  /// (I + gamma M^-1 K) x = b
  static int solve(SUNLinearSolver solver, SUNMatrix, N_Vector x, N_Vector b, double) {
    auto& self = *static_cast<Callbacks*>(solver->content);
    double gamma = 0.0;
    if (CVodeGetCurrentGamma(self.cvode, &gamma) != CV_SUCCESS) return -1;
    try {
      if (gamma != self.gamma) {
        self.gamma = 0.0;
        if (!self.iteration.factorise(self.system->mass + gamma * self.system->stiffness)) return 1;
        self.gamma = gamma;
      }
      state_of(x) = self.iteration.solve(self.system->mass * state_of(b));
      return 0;
    } catch (...) {
      self.thrown = std::current_exception();
      return -1;
    }
  }

  static SUNLinearSolver_Type type(SUNLinearSolver) { return SUNLINEARSOLVER_MATRIX_EMBEDDED; }
  static int free(SUNLinearSolver solver) {
    SUNLinSolFreeEmpty(solver);
    return 0;
  }
};

void check_linear_system(const LinearSystem& system, const Eigen::VectorXd& start) {
  const Eigen::Index n = start.size();
  for (const Sparse* matrix : {&system.mass, &system.stiffness}) {
    if (matrix->rows() == n && matrix->cols() == n && n > 0) continue;
    throw ArgumentError(fmt::format(
        "integrate_linear: a matrix is {} x {}, the start has {} states; square matrices of that size were "
        "expected",
        matrix->rows(), matrix->cols(), n));
  }
  const auto is_finite = [](const Sparse& matrix) {
    return std::all_of(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros(),
                       [](double value) { return std::isfinite(value); });
  };
  const bool compressed = system.mass.isCompressed() && system.stiffness.isCompressed();
  if (!compressed)
    throw ArgumentError("integrate_linear: a matrix is not compressed, makeCompressed() was expected");
  if (!start.allFinite() || !is_finite(system.mass) || !is_finite(system.stiffness))
    throw ArgumentError("integrate_linear: a matrix or the start has an entry that is not finite");
}

void check_increasing_times(std::span<const double> times) {
  if (times.empty()) throw ArgumentError("integrate_linear: there are no times, expected at least one");
  for (std::size_t i = 0; i < times.size(); ++i) {
    require(std::isfinite(times[i]) && (i == 0 || times[i] > times[i - 1]), fmt::format("times[{}]", i),
            times[i], "finite times that increase", "integrate_linear");
  }
}

/// @throws NoResultError for what CVODE cannot do
void must(int flag, const Callbacks& callbacks, double reached) {
  if (callbacks.thrown) std::rethrow_exception(callbacks.thrown);
  if (flag >= 0) return;
  throw NoResultError(
      fmt::format("CVODE gave up on a linear system of {} states at t = {:.6g}, with its flag {}",
                  callbacks.load.size(), reached, flag));
}

LinearSolverHandle make_linear_solver(Callbacks& callbacks, SUNContext context) {
  LinearSolverHandle solver(SUNLinSolNewEmpty(context));
  solver->ops->gettype = &Callbacks::type;
  solver->ops->solve = &Callbacks::solve;
  solver->ops->free = &Callbacks::free;
  solver->content = &callbacks;
  return solver;
}

}  // namespace

Eigen::MatrixXd integrate_linear(const LinearSystem& system, const Eigen::VectorXd& start,
                                 std::span<const double> times, const LinearIntegrationOptions& options) {
  Eigen::MatrixXd states(start.size(), static_cast<Eigen::Index>(times.size()));
  integrate_linear(system, start, times, options, [&](std::size_t time, const auto& at) {
    states.col(static_cast<Eigen::Index>(time)) = at;
  });
  return states;
}

void integrate_linear(
    const LinearSystem& system, const Eigen::VectorXd& start, std::span<const double> times,
    const LinearIntegrationOptions& options,
    const std::function<void(std::size_t, const Eigen::Ref<const Eigen::VectorXd>&)>& take) {
  check_linear_system(system, start);
  check_increasing_times(times);
  require_positive(options.relative_tolerance, "relative_tolerance", "integrate_linear");
  require_positive(options.absolute_tolerance, "absolute_tolerance", "integrate_linear");
  require(options.max_steps > 0, "max_steps", options.max_steps, "at least 1", "integrate_linear");
  const bool symmetric = is_symmetric(system.mass) && is_symmetric(system.stiffness);
  Callbacks callbacks{&system,
                      Factorised(is_symmetric(system.mass)),
                      Factorised(symmetric),
                      0.0,
                      nullptr,
                      Eigen::VectorXd::Zero(start.size()),
                      {}};
  if (!callbacks.mass.factorise(system.mass))
    throw NoResultError("the mass matrix of a linear system is singular");

  const sundials::Context context;
  const VectorHandle u(N_VNew_Serial(start.size(), context));
  state_of(u.get()) = start;
  const CvodesHandle cvode(CVodeCreate(CV_BDF, context));
  callbacks.cvode = cvode.get();
  const LinearSolverHandle linear = make_linear_solver(callbacks, context);
  must(CVodeInit(cvode.get(), &Callbacks::rate, times.front(), u.get()), callbacks, times.front());
  must(CVodeSStolerances(cvode.get(), options.relative_tolerance, options.absolute_tolerance), callbacks,
       times.front());
  must(CVodeSetErrFile(cvode.get(), nullptr), callbacks, times.front());
  must(CVodeSetStopTime(cvode.get(), times.back()), callbacks, times.front());
  must(CVodeSetUserData(cvode.get(), &callbacks), callbacks, times.front());
  must(CVodeSetMaxNumSteps(cvode.get(), options.max_steps), callbacks, times.front());
  must(CVodeSetLinearSolver(cvode.get(), linear.get(), nullptr), callbacks, times.front());

  take(0, start);
  double reached = times.front();
  for (std::size_t i = 1; i < times.size(); ++i) {
    must(CVode(cvode.get(), times[i], u.get(), &reached, CV_NORMAL), callbacks, reached);
    take(i, state_of(u.get()));
  }
}

}  // namespace samara::models

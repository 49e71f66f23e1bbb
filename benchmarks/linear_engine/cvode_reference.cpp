#include "cvode_reference.h"

#include <stdexcept>

#include <Eigen/Cholesky>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include "samara/models/integrators/sundials_handles.h"

namespace samara::benchmarks {

namespace {

using namespace models;

struct System {
  Eigen::MatrixXd matrix;  ///< M^-1 K
  Eigen::LLT<Eigen::MatrixXd> mass;
  const std::function<Eigen::VectorXd(double)>* load;
};

int right_hand_side(double t, N_Vector u, N_Vector slope, void* data) {
  const System& system = *static_cast<System*>(data);
  const Eigen::Map<const Eigen::VectorXd> state(N_VGetArrayPointer(u), system.matrix.rows());
  Eigen::Map<Eigen::VectorXd>(N_VGetArrayPointer(slope), system.matrix.rows()) =
      system.mass.solve((*system.load)(t)) - system.matrix * state;
  return 0;
}

int jacobian(double, N_Vector, N_Vector, SUNMatrix matrix, void* data, N_Vector, N_Vector, N_Vector) {
  const System& system = *static_cast<System*>(data);
  Eigen::Map<Eigen::MatrixXd>(SM_DATA_D(matrix), system.matrix.rows(), system.matrix.cols()) = -system.matrix;
  return 0;
}

void must(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(std::string("CVODE failed: ") + what);
}

}  // namespace

Eigen::MatrixXd integrate_linear(const Eigen::MatrixXd& mass, const Eigen::MatrixXd& stiffness,
                                 const std::function<Eigen::VectorXd(double)>& load,
                                 const Eigen::VectorXd& start, const Eigen::VectorXd& times) {
  System system{{}, Eigen::LLT<Eigen::MatrixXd>(mass), &load};
  system.matrix = system.mass.solve(stiffness);
  sundials::Context context;
  const VectorHandle u(N_VNew_Serial(start.size(), context));
  Eigen::Map<Eigen::VectorXd>(N_VGetArrayPointer(u.get()), start.size()) = start;
  const CvodesHandle solver(CVodeCreate(CV_BDF, context));
  must(CVodeInit(solver.get(), right_hand_side, times[0], u.get()) == CV_SUCCESS, "CVodeInit");
  must(CVodeSStolerances(solver.get(), 1e-10, 1e-12) == CV_SUCCESS, "CVodeSStolerances");
  must(CVodeSetUserData(solver.get(), &system) == CV_SUCCESS, "CVodeSetUserData");
  must(CVodeSetMaxNumSteps(solver.get(), 100000) == CV_SUCCESS, "CVodeSetMaxNumSteps");
  const MatrixHandle matrix(SUNDenseMatrix(start.size(), start.size(), context));
  const LinearSolverHandle linear(SUNLinSol_Dense(u.get(), matrix.get(), context));
  must(CVodeSetLinearSolver(solver.get(), linear.get(), matrix.get()) == CV_SUCCESS, "CVodeSetLinearSolver");
  must(CVodeSetJacFn(solver.get(), jacobian) == CV_SUCCESS, "CVodeSetJacFn");
  Eigen::MatrixXd result(start.size(), times.size());
  result.col(0) = start;
  for (Eigen::Index i = 1; i < times.size(); ++i) {
    double reached = 0.0;
    must(CVode(solver.get(), times[i], u.get(), &reached, CV_NORMAL) == CV_SUCCESS, "CVode");
    result.col(i) = Eigen::Map<const Eigen::VectorXd>(N_VGetArrayPointer(u.get()), start.size());
  }
  return result;
}

}  // namespace samara::benchmarks

#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.hpp>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <sundials/sundials_nvector.h>

/// Owners of the C objects of SUNDIALS. A context must outlive everything made with it: declare it first.
namespace samara::models {

struct SundialsDelete {
  void operator()(N_Vector vector) const { N_VDestroy(vector); }
  void operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
  void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
  void operator()(SUNNonlinearSolver solver) const { SUNNonlinSolFree(solver); }
  void operator()(void* cvodes) const { CVodeFree(&cvodes); }
};

using VectorHandle = std::unique_ptr<_generic_N_Vector, SundialsDelete>;
using MatrixHandle = std::unique_ptr<_generic_SUNMatrix, SundialsDelete>;
using LinearSolverHandle = std::unique_ptr<_generic_SUNLinearSolver, SundialsDelete>;
using NonlinearSolverHandle = std::unique_ptr<_generic_SUNNonlinearSolver, SundialsDelete>;
using CvodesHandle = std::unique_ptr<void, SundialsDelete>;

/// An array of vectors shaped like a given one.
class VectorArrayHandle {
 public:
  VectorArrayHandle() = default;
  VectorArrayHandle(int count, N_Vector like) : count_(count), vectors_(N_VCloneVectorArray(count, like)) {}
  ~VectorArrayHandle() {
    if (vectors_ != nullptr) N_VDestroyVectorArray(vectors_, count_);
  }
  VectorArrayHandle(const VectorArrayHandle&) = delete;
  VectorArrayHandle& operator=(const VectorArrayHandle&) = delete;
  VectorArrayHandle(VectorArrayHandle&& other) noexcept { *this = std::move(other); }
  VectorArrayHandle& operator=(VectorArrayHandle&& other) noexcept {
    std::swap(count_, other.count_);
    std::swap(vectors_, other.vectors_);
    return *this;
  }

  N_Vector* get() const { return vectors_; }
  N_Vector operator[](std::size_t i) const { return vectors_[i]; }

 private:
  int count_ = 0;
  N_Vector* vectors_ = nullptr;
};

/// The entries of a serial vector.
inline std::span<double> entries(N_Vector vector) {
  return {N_VGetArrayPointer(vector), static_cast<std::size_t>(N_VGetLength(vector))};
}

}  // namespace samara::models

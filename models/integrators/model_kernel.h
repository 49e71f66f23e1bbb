#pragma once

#include <vector>

#include "samara/models/integrators/step_kernel.h"
#include "samara/models/interface/model.h"

namespace samara::models {

/// The steps of any model through Model::rhs, one lane, for models that bring no kernels of their own. The
/// arithmetic of a step is that of LawKernel. Has scratch space: one per thread.
class ModelKernel final : public StepKernel {
 public:
  /// @param directions tangents carried beside the values, 0 or more
  ModelKernel(const Model& model, int directions);

  int width() const override { return 1; }
  int directions() const override { return directions_; }
  void complete(const char* given, double* p) const override;
  void advance(const double* t, double h, long steps, double* x, const double* p) const override;

 private:
  /// One evaluation at a stage: f and, per direction, df/dx y_k + df/dp p_k, laid out like x.
  void rate(double t, const double* y, const double* p) const;

  const Model& model_;
  int directions_;
  std::size_t stride_;
  struct Scratch {
    ParameterValues p;
    std::vector<double> state, f;   ///< values without tangents
    std::vector<double> y, k, sum;  ///< laid out like x
    Eigen::MatrixXd df_dx, df_dp;
  };
  mutable Scratch scratch_;
};

}  // namespace samara::models

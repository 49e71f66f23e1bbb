#include "samara/models/integrators/model_kernel.h"

#include <algorithm>
#include <array>

namespace samara::models {

ModelKernel::ModelKernel(const Model& model, int directions)
    : model_(model), directions_(directions), stride_(static_cast<std::size_t>(directions) + 1) {
  const std::size_t states = model.info().states.size();
  const std::size_t parameters = model.info().parameters.size();
  scratch_.p.value.resize(parameters);
  scratch_.p.given.resize(parameters);
  scratch_.state.resize(states);
  scratch_.f.resize(states);
  for (auto* laid_out : {&scratch_.y, &scratch_.k, &scratch_.sum}) laid_out->resize(states * stride_);
  scratch_.df_dx.resize(static_cast<Eigen::Index>(states), static_cast<Eigen::Index>(states));
  scratch_.df_dp.resize(static_cast<Eigen::Index>(states), static_cast<Eigen::Index>(parameters));
}

void ModelKernel::complete(const char* given, double*) const {
  // The model puts its own defaults at every call, and chains their derivatives.
  std::copy_n(given, scratch_.p.given.size(), scratch_.p.given.begin());
}

void ModelKernel::rate(double t, const double* y, const double* p) const {
  Scratch& s = scratch_;
  for (std::size_t j = 0; j < s.p.value.size(); ++j) s.p.value[j] = p[j * stride_];
  for (std::size_t i = 0; i < s.state.size(); ++i) s.state[i] = y[i * stride_];
  if (directions_ == 0) {
    model_.rhs(t, s.state, s.p, s.k);
    return;
  }
  model_.rhs_with_derivatives(t, s.state, s.p, s.f, s.df_dx, s.df_dp);
  const auto directions = static_cast<std::size_t>(directions_);
  for (std::size_t i = 0; i < s.f.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    s.k[i * stride_] = s.f[i];
    for (std::size_t d = 1; d <= directions; ++d) {
      double tangent = 0.0;
      for (std::size_t l = 0; l < s.state.size(); ++l) {
        tangent += s.df_dx(row, static_cast<Eigen::Index>(l)) * y[l * stride_ + d];
      }
      for (std::size_t j = 0; j < s.p.value.size(); ++j) {
        if (s.p.given[j]) tangent += s.df_dp(row, static_cast<Eigen::Index>(j)) * p[j * stride_ + d];
      }
      s.k[i * stride_ + d] = tangent;
    }
  }
}

void ModelKernel::advance(const double* t, double h, long steps, double* x, const double* p) const {
  constexpr std::array kNode = {0.0, 0.5, 0.5, 1.0};
  constexpr std::array kWeight = {1.0, 2.0, 2.0, 1.0};
  Scratch& s = scratch_;
  for (long step = 0; step < steps; ++step) {
    const double start = *t + static_cast<double>(step) * h;
    std::copy_n(x, s.y.size(), s.y.begin());
    std::ranges::fill(s.sum, 0.0);
    for (std::size_t stage = 0; stage < 4; ++stage) {
      rate(start + kNode[stage] * h, s.y.data(), p);
      for (std::size_t i = 0; i < s.sum.size(); ++i) s.sum[i] = s.sum[i] + kWeight[stage] * s.k[i];
      if (stage == 3) break;
      for (std::size_t i = 0; i < s.y.size(); ++i) s.y[i] = x[i] + kNode[stage + 1] * h * s.k[i];
    }
    for (std::size_t i = 0; i < s.sum.size(); ++i) x[i] = x[i] + h / 6.0 * s.sum[i];
  }
}

}  // namespace samara::models

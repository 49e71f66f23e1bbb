#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <ceres/jet.h>

#include "samara/models/batch/law_kernel.h"
#include "samara/models/model.h"

/// From a law to a Model.
///
/// A law is the physics alone, written once for every scalar type S (double, ceres::Jet, a SIMD pack):
///
///   struct SomeLaw {
///     static constexpr int kStates = ..., kParameters = ...;
///     static ModelInfo info();
///     /// dxdt = f(t, x, p), branch-free; p is complete.
///     template <class S> static void rhs(const S& t, const S* x, const S* p, S* dxdt);
///     /// Puts derived defaults where `given` is false; constant defaults are in place already. May branch
///     on
///     /// values: it never meets packs.
///     template <class S> static void complete(const char* given, S* p);
///     /// Characteristic sizes, finite and positive for every p within its meaning.
///     static Scales scales(const double* p);
///
///     // Where the law has forces to name (ModelInfo::force_terms lists them in this order):
///     template <class S> static void forces(const S& t, const S* x, const S* p, LawWrench<S>* terms);
///     // Where it has an energy:
///     template <class S> static S kinetic_energy(const S& t, const S* x, const S* p);
///     // Where parameters must fit together: a sentence, or empty.
///     static std::string problem(const double* p);
///   };
///
/// The functions may also be members of an object that the law carries (a flow field), info() included.
///
/// Derivatives come from forward automatic differentiation by all states and parameters at once.
/// Include this only in source files: no installed header shows ceres::Jet.
namespace samara::models {

/// A force term as laws write it: body axes, see Wrench.
template <class S>
struct LawWrench {
  S force[3] = {S(0.0), S(0.0), S(0.0)};
  S torque[3] = {S(0.0), S(0.0), S(0.0)};
  S power = S(0.0);
};

template <class Law>
concept HasForces = requires(const Law& law, double t, const double* x, LawWrench<double>* terms) {
  law.template forces<double>(t, x, x, terms);
};

template <class Law>
concept HasKineticEnergy = requires(const Law& law, double t, const double* x) {
  { law.template kinetic_energy<double>(t, x, x) } -> std::same_as<double>;
};

template <class Law>
concept HasProblem = requires(const Law& law, const double* p) {
  { law.problem(p) } -> std::same_as<std::string>;
};

/// Stands for the kernels of a law that has none.
struct NoKernels {
  explicit NoKernels(const auto&) {}
};

/// @tparam kCompiled compile the law to step kernels, scalar and in packs; false for a law that asks others
///   (a flow field) for plain numbers
template <class Law, bool kCompiled = true>
class LawModel final : public Model {
 public:
  explicit LawModel(Law law = {}) : law_(std::move(law)), info_(law_.info()) {
    if (info_.states.size() != kStates || info_.parameters.size() != kParameters) {
      throw std::logic_error("law \"" + info_.name + "\" lists other states or parameters than it has");
    }
    if (HasForces<Law> != !info_.force_terms.empty()) {
      throw std::logic_error("law \"" + info_.name + "\" has force terms and no forces, or the reverse");
    }
    for (std::size_t j = 0; j < kParameters; ++j) {
      defaults_[j] = info_.parameters[j].default_value.value_or(0.0);
    }
  }

  const ModelInfo& info() const override { return info_; }

  void rhs(double t, std::span<const double> x, const ParameterValues& p,
           std::span<double> dxdt) const override {
    // Complete already, as integrators pass them: nothing to copy, nothing to derive.
    if (std::memchr(p.given.data(), 0, kParameters) == nullptr) {
      rate(t, x.data(), p.value.data(), dxdt.data());
    } else {
      rate(t, x.data(), complete(p).data(), dxdt.data());
    }
  }

  void rhs_with_derivatives(double t, std::span<const double> x, const ParameterValues& p,
                            std::span<double> dxdt, Eigen::Ref<Eigen::MatrixXd> df_dx,
                            Eigen::Ref<Eigen::MatrixXd> df_dp) const override {
    // A jet's infinitesimal parts: first one per state, then one per parameter. A parameter that is not given
    // is no variable: it is a constant, or a function of those that are given.
    std::array<Jet, kStates> x_jet;
    std::array<Jet, kParameters> p_jet;
    std::array<Jet, kStates> f;
    for (std::size_t i = 0; i < kStates; ++i) x_jet[i] = Jet(x[i], static_cast<int>(i));
    for (std::size_t j = 0; j < kParameters; ++j) {
      p_jet[j] = p.given[j] ? Jet(p.value[j], static_cast<int>(kStates + j)) : Jet(defaults_[j]);
    }
    law_.template complete<Jet>(p.given.data(), p_jet.data());
    law_.template rhs<Jet>(Jet(t), x_jet.data(), p_jet.data(), f.data());
    for (std::size_t i = 0; i < kStates; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      dxdt[i] = f[i].a;
      df_dx.row(row) = f[i].v.template head<kStates>().transpose();
      df_dp.row(row) = f[i].v.template tail<kParameters>().transpose();
    }
  }

  void forces(double t, std::span<const double> x, const ParameterValues& p,
              std::span<Wrench> terms) const override {
    if constexpr (HasForces<Law>) {
      std::vector<LawWrench<double>> list(terms.size());
      law_.template forces<double>(t, x.data(), complete(p).data(), list.data());
      for (std::size_t k = 0; k < list.size(); ++k) {
        terms[k] = {Eigen::Vector3d(list[k].force), Eigen::Vector3d(list[k].torque), list[k].power};
      }
    }
  }

  std::optional<double> kinetic_energy(double t, std::span<const double> x,
                                       const ParameterValues& p) const override {
    if constexpr (HasKineticEnergy<Law>) {
      return law_.template kinetic_energy<double>(t, x.data(), complete(p).data());
    }
    return std::nullopt;
  }

  std::string problem(const ParameterValues& p) const override {
    if constexpr (HasProblem<Law>) return law_.problem(complete(p).data());
    return "";
  }

  std::vector<double> completed(const ParameterValues& p) const override {
    const std::array<double, kParameters> all = complete(p);
    return {all.begin(), all.end()};
  }

  void complete_into(const ParameterValues& p, std::span<double> all) const override {
    std::ranges::copy(complete(p), all.begin());
  }

  Scales scales(const ParameterValues& p) const override { return law_.scales(complete(p).data()); }

  const StepKernels* step_kernels() const override { return kernels(kernels_); }

 private:
  static constexpr std::size_t kStates = Law::kStates;
  static constexpr std::size_t kParameters = Law::kParameters;
  using Jet = ceres::Jet<double, Law::kStates + Law::kParameters>;

  std::array<double, kParameters> complete(const ParameterValues& p) const {
    std::array<double, kParameters> all;
    for (std::size_t j = 0; j < kParameters; ++j) all[j] = p.given[j] ? p.value[j] : defaults_[j];
    law_.template complete<double>(p.given.data(), all.data());
    return all;
  }

  /// The law with all that it calls in one function: a third less time for a body.
  SAMARA_FLAT void rate(double t, const double* x, const double* p, double* dxdt) const {
    law_.template rhs<double>(t, x, p, dxdt);
  }

  static const StepKernels* kernels(const NoKernels&) { return nullptr; }
  static const StepKernels* kernels(const auto& compiled) { return &compiled.all; }

  Law law_;
  std::conditional_t<kCompiled, LawKernels<Law>, NoKernels> kernels_{law_};
  ModelInfo info_;
  std::array<double, kParameters> defaults_ = {};
};

}  // namespace samara::models

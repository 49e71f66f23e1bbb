#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "samara/base/errors.h"
#include "samara/models/batch/law_kernel.h"
#include "samara/models/interface/model.h"

/// From a law to a Model: equations of your own, compiled, with exact derivatives and steps of many trajectories
/// side by side.
///
/// A law is the physics alone, written once for every scalar type S (double, numbers with derivatives, SIMD packs):
///
///   struct SomeLaw {
///     static constexpr int kStates = ..., kParameters = ...;
///     static ModelInfo info();
///     /// dxdt = f(t, x, p), without branches on values; p is complete. Functions are those of <cmath>, called
///     /// without std:: after `using std::sqrt;` and so on.
///     template <class S> static void rhs(const S& t, const S* x, const S* p, S* dxdt);
///
///     // Where parameters follow from others by default: puts these where `given` is false; constant defaults are
///     // in place already. May branch on values: it is never called with packs.
///     template <class S> static void complete(const char* given, S* p);
///     // Characteristic sizes, finite and positive for every p within its meaning; without it, those that
///     // StateInfo::scale does not say are 1.
///     static Scales scales(const double* p);
///     // Where the law has forces to name (ModelInfo::force_terms lists them in this order):
///     template <class S> static void forces(const S& t, const S* x, const S* p, LawWrench<S>* terms);
///     // Where it has an energy:
///     template <class S> static S kinetic_energy(const S& t, const S* x, const S* p);
///     // Where parameters must fit together: a sentence, or empty.
///     static std::string problem(const double* p);
///   };
///
///   const std::shared_ptr<const Model> model = make_model<SomeLaw>();
///
/// The functions may also be members of an object that the law carries (a flow field), info() included.
///
/// Derivatives come from forward automatic differentiation, a few directions at a time. A source that includes this
/// compiles the law three times over: seconds for a law of a few lines.
namespace samara::models {

/// A force term as laws write it: body axes, see Wrench.
template <class S>
struct LawWrench {
  S force[3] = {S(0.0), S(0.0), S(0.0)};
  S torque[3] = {S(0.0), S(0.0), S(0.0)};
  S power = S(0.0);
};

template <class Law>
concept HasDerivedDefaults = requires(const Law& law, const char* given, double* p) {
  law.template complete<double>(given, p);
};

template <class Law>
concept HasScales = requires(const Law& law, const double* p) {
  { law.scales(p) } -> std::same_as<Scales>;
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
      throw ArgumentError("law \"" + info_.name + "\" lists other states or parameters than it has");
    }
    if (HasForces<Law> != !info_.force_terms.empty()) {
      throw ArgumentError("law \"" + info_.name + "\" has force terms and no forces, or the reverse");
    }
    if (!info_.outputs.empty())
      throw ArgumentError("law \"" + info_.name + "\" lists outputs, expected none: laws have states alone");
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
    std::array<int, kParameters> list;
    std::size_t count = 0;
    for (std::size_t j = 0; j < kParameters; ++j) {
      if (p.given[j]) list[count++] = static_cast<int>(j);
    }
    const std::span<const int> wanted(list.data(), count);
    const auto columns = static_cast<Eigen::Index>(count);
    Columns<Law::kParameters> tangents(static_cast<Eigen::Index>(kParameters), columns);
    completion_tangents(p, wanted, tangents);
    Columns<Law::kStates> df_dq(static_cast<Eigen::Index>(kStates), columns);
    rhs_with_tangents(t, x, complete(p), tangents, dxdt, df_dx, df_dq);
    df_dp.setZero();
    for (std::size_t k = 0; k < count; ++k) df_dp.col(list[k]) = df_dq.col(static_cast<Eigen::Index>(k));
  }

  bool completion_tangents(const ParameterValues& p, std::span<const int> wanted,
                           Eigen::Ref<Eigen::MatrixXd> tangents) const override {
    std::array<Jet, kParameters> all;
    for (std::size_t first = 0; first < wanted.size(); first += kChunk) {
      const std::size_t size = std::min(kChunk, wanted.size() - first);
      // A parameter that is not given is no variable: it is a constant, or a function of those that are.
      for (std::size_t j = 0; j < kParameters; ++j) all[j] = Jet(p.given[j] ? p.value[j] : defaults_[j]);
      for (std::size_t k = 0; k < size; ++k) {
        all[static_cast<std::size_t>(wanted[first + k])].v[k] = 1.0;
      }
      derive(p.given.data(), all.data());
      for (std::size_t j = 0; j < kParameters; ++j) {
        for (std::size_t k = 0; k < size; ++k) {
          tangents(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(first + k)) = all[j].v[k];
        }
      }
    }
    return true;
  }

  /// A few directions at a time, first those of the states: a jet of all of them would not fit into
  /// registers.
  void rhs_with_tangents(double t, std::span<const double> x, std::span<const double> all,
                         const Eigen::Ref<const Eigen::MatrixXd>& tangents, std::span<double> dxdt,
                         Eigen::Ref<Eigen::MatrixXd> df_dx,
                         Eigen::Ref<Eigen::MatrixXd> df_dq) const override {
    std::array<Jet, kStates> x_jet;
    std::array<Jet, kParameters> p_jet;
    for (std::size_t i = 0; i < kStates; ++i) x_jet[i] = Jet(x[i]);
    for (std::size_t j = 0; j < kParameters; ++j) p_jet[j] = Jet(all[j]);
    const std::size_t directions = kStates + static_cast<std::size_t>(tangents.cols());
    for (std::size_t first = 0; first < directions; first += kChunk) {
      const std::size_t size = std::min(kChunk, directions - first);
      for (std::size_t i = 0; i < kStates; ++i) {
        x_jet[i].v.fill(0.0);
        if (i >= first && i < first + size) x_jet[i].v[i - first] = 1.0;
      }
      for (std::size_t k = first < kStates ? std::min(size, kStates - first) : 0; k < size; ++k) {
        for (std::size_t j = 0; j < kParameters; ++j) {
          p_jet[j].v[k] =
              tangents(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(first + k - kStates));
        }
      }
      std::array<Jet, kStates> f;
      law_.template rhs<Jet>(Jet(t), x_jet.data(), p_jet.data(), f.data());
      for (std::size_t i = 0; i < kStates; ++i) dxdt[i] = f[i].a;
      for (std::size_t k = 0; k < size; ++k) {
        const std::size_t direction = first + k;
        for (std::size_t i = 0; i < kStates; ++i) {
          const auto row = static_cast<Eigen::Index>(i);
          const double slope = f[i].v[k];
          if (direction < kStates) {
            df_dx(row, static_cast<Eigen::Index>(direction)) = slope;
          } else {
            df_dq(row, static_cast<Eigen::Index>(direction - kStates)) = slope;
          }
        }
      }
    }
  }

  void rhs_at_points(const Eigen::Ref<const Eigen::VectorXd>& t, const Eigen::Ref<const Eigen::MatrixXd>& x,
                     const Eigen::Ref<const Eigen::MatrixXd>& p,
                     Eigen::Ref<Eigen::MatrixXd> dxdt) const override {
    for (Eigen::Index j = 0; j < x.cols(); ++j)
      rate(t[j], x.col(j).data(), p.col(j).data(), dxdt.col(j).data());
  }

  void jacobians_at_points(const Eigen::Ref<const Eigen::VectorXd>& t,
                           const Eigen::Ref<const Eigen::MatrixXd>& x,
                           const Eigen::Ref<const Eigen::MatrixXd>& p,
                           Eigen::Ref<Eigen::MatrixXd> jacobians) const override {
    const Columns<Law::kParameters> no_tangents(static_cast<Eigen::Index>(kParameters), 0);
    Columns<Law::kStates> no_columns(static_cast<Eigen::Index>(kStates), 0);
    std::array<double, kStates> f;
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      Eigen::Map<Eigen::MatrixXd> df_dx(jacobians.col(j).data(), x.rows(), x.rows());
      rhs_with_tangents(t[j], {x.col(j).data(), kStates}, {p.col(j).data(), kParameters}, no_tangents, f,
                        df_dx, no_columns);
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

  Scales scales(const ParameterValues& p) const override {
    if constexpr (HasScales<Law>) return law_.scales(complete(p).data());
    return {};
  }

  const StepKernels* step_kernels() const override { return kernels(kernels_); }

 private:
  static constexpr std::size_t kStates = Law::kStates;
  static constexpr std::size_t kParameters = Law::kParameters;
  /// Directions of one pass: as many as an evaluation carries at little more than the cost of one.
  static constexpr std::size_t kChunk = 8;
  using Jet = Dual<double, static_cast<int>(kChunk)>;
  /// On the stack. (A column that may hold one number only would have to be a row, for Eigen: hence the 1.)
  template <int rows>
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, rows + 1,
                                static_cast<int>(Law::kParameters) + 1>;

  std::array<double, kParameters> complete(const ParameterValues& p) const {
    std::array<double, kParameters> all;
    for (std::size_t j = 0; j < kParameters; ++j) all[j] = p.given[j] ? p.value[j] : defaults_[j];
    derive(p.given.data(), all.data());
    return all;
  }

  template <class S>
  void derive(const char* given, S* p) const {
    if constexpr (HasDerivedDefaults<Law>) law_.template complete<S>(given, p);
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

/// @throws ArgumentError if what info() lists is not what the law has
template <class Law>
std::shared_ptr<const Model> make_model(Law law = {}) {
  return std::make_shared<LawModel<Law>>(std::move(law));
}

}  // namespace samara::models

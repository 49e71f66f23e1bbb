// What a right-hand side and a step of the immersed body cost, alone and in batches.
#include <array>
#include <vector>

#include "cases.h"
#include "falling_card.h"
#include "samara/models/batch/batch.h"
#include "samara/models/integrators/rk4.h"

namespace samara::benchmarks {

namespace {

using namespace models;

constexpr double kStep = 1e-4;
constexpr double kEnd = 0.1;
constexpr double kSteps = kEnd / kStep;
const std::vector<double> kCoefficients = {0.61, 1.81, 1.21};

/// The textbook's loop over Model::rhs, with the parameters completed once: what a careful user would write.
class PlainRk4 {
 public:
  PlainRk4(const ParametricModel& model, std::span<const double> q)
      : model_(model.model()),
        p_{model.parameters(q), std::vector<char>(model.model().info().parameters.size(), 1)},
        start_(static_cast<std::size_t>(model.state_count())) {
    model.initial(q, start_);
    x_ = y_ = k1_ = k2_ = k3_ = k4_ = start_;
  }

  void run() {
    x_ = start_;
    for (int step = 0; step < static_cast<int>(kSteps); ++step) {
      const double t = step * kStep;
      model_.rhs(t, x_, p_, k1_);
      shift(0.5 * kStep, k1_);
      model_.rhs(t + 0.5 * kStep, y_, p_, k2_);
      shift(0.5 * kStep, k2_);
      model_.rhs(t + 0.5 * kStep, y_, p_, k3_);
      shift(kStep, k3_);
      model_.rhs(t + kStep, y_, p_, k4_);
      for (std::size_t i = 0; i < x_.size(); ++i) {
        x_[i] += kStep / 6.0 * (k1_[i] + 2.0 * k2_[i] + 2.0 * k3_[i] + k4_[i]);
      }
    }
  }

 private:
  void shift(double h, const std::vector<double>& k) {
    for (std::size_t i = 0; i < x_.size(); ++i) y_[i] = x_[i] + h * k[i];
  }

  const Model& model_;
  ParameterValues p_;
  std::vector<double> start_, x_, y_, k1_, k2_, k3_, k4_;
};

/// What a Newton iteration or a sensitivity equation asks for: f with its derivatives by 13 states and 3
/// coefficients. Beside it by all parameters, as where nobody says which are wanted.
void derivatives() {
  const ParametricModel card = oblique_card();
  ParametricModel::Workspace workspace = card.make_workspace();
  RhsDerivatives slopes;
  std::vector<double> x(13), f(13);
  card.initial(kCoefficients, x);
  const double wanted =
      time_of([&] { card.rhs_with_derivatives(0.0, x, kCoefficients, f, slopes, workspace); });
  const std::vector<double> all = card.parameters(kCoefficients);
  const ParameterValues p = {all, std::vector<char>(all.size(), 1)};
  Eigen::MatrixXd df_dx(13, 13), df_dp(13, static_cast<Eigen::Index>(all.size()));
  const double every = time_of([&] { card.model().rhs_with_derivatives(0.0, x, p, f, df_dx, df_dp); });
  print(
      {kModels, "derivatives", "three_coefficients_time", wanted, "s", "by all parameters", every / wanted});
}

}  // namespace

void run_steps(const Options& options) {
  if (options.wants("derivatives")) derivatives();
  const bool body = options.wants("body3d");
  const bool batch = options.wants("batch");
  if (!body && !batch) return;
  const ParametricModel card = oblique_card();
  PlainRk4 plain(card, kCoefficients);
  Rk4Integrator kernel(card, {.step = kStep});
  const double plain_step = time_of([&] { plain.run(); }) / kSteps;
  const double step = time_of([&] { kernel(kCoefficients, std::array{kEnd}); }) / kSteps;
  if (body) {
    ParametricModel::Workspace workspace = card.make_workspace();
    std::vector<double> x(13), f(13);
    card.initial(kCoefficients, x);
    const double rhs = time_of([&] { card.rhs(0.0, x, kCoefficients, f, workspace); });
    print({kModels, "body3d", "rhs_time", rhs, "s"});
    print({kModels, "body3d", "rk4_step_time", step, "s", "loop over Model::rhs", plain_step / step});
  }
  if (batch) {
    // As many as a task of the batch takes, several times over; coefficients near the ones above.
    constexpr int kCount = 512;
    Eigen::MatrixXd points(kCount, 3);
    for (int n = 0; n < kCount; ++n) points.row(n) << 0.61 + 1e-3 * n, 1.81, 1.21;
    const auto per_step = [&](const std::vector<std::string>& tangents) {
      const BatchOptions one_thread = {.step = kStep, .threads = 1, .tangents = tangents};
      return time_of([&] { integrate_batch(card, points, std::array{kEnd}, one_thread); }, 5) / kSteps /
             kCount;
    };
    const double lanes = per_step({});
    print({kModels, "batch", "step_time", lanes, "s", "scalar step", step / lanes});
    print({kModels, "batch", "speedup_per_core", step / lanes, "1"});
    print({kModels, "batch", "step_time_three_tangents", per_step({"C_D90", "C_T", "C_R"}), "s"});
  }
}

}  // namespace samara::benchmarks

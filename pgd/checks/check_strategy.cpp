#include "samara/pgd/checks/check_strategy.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/nonlinear/strategy_trial.h"

namespace samara::pgd {

namespace {

constexpr int kTimePoints = 8;
/// What too few nodes and guards leave to the defect, over the tolerance.
constexpr double kDefectMargin = 3.0;
/// How much less is asked for the second time.
constexpr double kStricter = 1e-2;

/// The system up to a time, from which on its rates are not finite.
class EndingSystem final : public EvolutionSystem {
 public:
  EndingSystem(const EvolutionSystem& system, double end) : system_(system), end_(end) {}
  int state_count() const override { return system_.state_count(); }
  void rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
           Eigen::MatrixXd& f) const override {
    system_.rhs(t, x, q, f);
    end(t, f);
  }
  void jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                Eigen::MatrixXd& jacobian) const override {
    system_.jacobian(t, x, q, jacobian);
    end(t, jacobian);
  }
  bool affine_in_parameters() const override { return system_.affine_in_parameters(); }

 private:
  void end(const Eigen::VectorXd& t, Eigen::MatrixXd& values) const {
    for (Eigen::Index j = 0; j < t.size(); ++j) {
      if (t[j] > end_) values.col(j).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }

  const EvolutionSystem& system_;
  double end_;
};

class StrategyExaminer {
 public:
  StrategyExaminer(Strategy& strategy, const AdaptiveProblem& problem, const CheckStrategyOptions& options)
      : strategy_(strategy),
        options_(options),
        problem_{problem.system,
                 Axis::radau(problem.time, 0.0, options.slabs * options.slab * problem.end, options.slabs,
                             kTimePoints),
                 {},
                 problem.states,
                 problem.scales,
                 problem.initial} {
    for (const AdaptiveAxis& axis : problem.parameters)
      problem_.parameters.push_back(make_axis(axis, axis.nodes.value_or(options.nodes)));
  }

  Check findings() {
    // A problem that does not suit the strategy is the caller's mistake, and is thrown.
    if (const std::optional<Ending> failure = strategy_.prepare(problem_, options_.tolerance)) {
      find("it does not get through its preparation: " + failure->message);
      return found_;
    }
    const std::optional<StrategyTrial> first = trial(problem_, options_.tolerance);
    if (!first) return found_;
    if (first->status != Termination::converged) {
      find(fmt::format("it does not get through {} slabs: {}", options_.slabs, first->message));
      return found_;
    }
    repeat(*first);
    if (!strategy_.is_exact()) return found_;
    look_at_defect(*first);
    meet_what_is_not_finite();
    meet_small_ranks();
    return found_;
  }

 private:
  void find(const std::string& sentence) { found_.findings.push_back(strategy_.name() + ": " + sentence); }

  /// Nothing, and a finding, if something was thrown.
  std::optional<StrategyTrial> trial(const EvolutionProblem& problem, double tolerance, int max_rank = 120) {
    try {
      return try_strategy(problem, strategy_,
                          {.tolerance = tolerance, .max_rank = max_rank, .seed = options_.seed});
    } catch (const std::exception& error) {
      find(fmt::format("it throws \"{}\", where an Ending was expected", error.what()));
      return std::nullopt;
    }
  }

  void repeat(const StrategyTrial& first) {
    const std::optional<StrategyTrial> again = trial(problem_, options_.tolerance);
    if (!again) return;
    bool same = again->pieces.size() == first.pieces.size();
    for (std::size_t p = 0; same && p < first.pieces.size(); ++p) {
      const std::vector<TrainCore>&ours = first.pieces[p].train().cores,
            &theirs = again->pieces[p].train().cores;
      same = ours.size() == theirs.size();
      for (std::size_t k = 0; same && k < ours.size(); ++k) same = ours[k].data == theirs[k].data;
    }
    if (!same) find("a second march gives other numbers: something of the first one is kept");
  }

  void look_at_defect(const StrategyTrial& first) {
    const double loose = first.largest_defect();
    if (loose > kDefectMargin * options_.tolerance) {
      return find(
          fmt::format("it says that it is exact, and leaves a defect of {:.3g} where {:.3g} was asked for",
                      loose, options_.tolerance));
    }
    const std::optional<StrategyTrial> strict = trial(problem_, kStricter * options_.tolerance);
    if (!strict || strict->status != Termination::converged) return;
    if (strict->largest_defect() > std::max(0.5 * loose, kDefectMargin * kStricter * options_.tolerance)) {
      find(fmt::format("asked for {:.3g}, it leaves a defect of {:.3g}, asked for {:.3g} one of {:.3g}",
                       options_.tolerance, loose, kStricter * options_.tolerance, strict->largest_defect()));
    }
  }

  void meet_what_is_not_finite() {
    // In the middle of the last slab, so that the first ones are solved before.
    const double end = (options_.slabs - 0.5) / options_.slabs * problem_.time.upper();
    const EndingSystem ending(*problem_.system, end);
    EvolutionProblem problem = problem_;
    problem.system = &ending;
    const std::optional<StrategyTrial> met = trial(problem, options_.tolerance);
    if (met && met->status == Termination::converged) find("it converges where rates are not finite");
  }

  void meet_small_ranks() {
    const std::optional<StrategyTrial> met = trial(problem_, options_.tolerance, 1);
    if (!met || met->status != Termination::converged) return;
    if (met->largest_defect() > kDefectMargin * options_.tolerance)
      find(fmt::format("with ranks of one it converges, and leaves a defect of {:.3g}",
                       met->largest_defect()));
  }

  Strategy& strategy_;
  const CheckStrategyOptions& options_;
  EvolutionProblem problem_;
  Check found_;
};

}  // namespace

Check check_strategy(Strategy& strategy, const AdaptiveProblem& problem,
                     const CheckStrategyOptions& options) {
  check_problem(problem);
  require(options.tolerance > 0.0, "CheckStrategyOptions::tolerance", options.tolerance, "a positive number");
  require(options.slabs > 0, "CheckStrategyOptions::slabs", options.slabs, "a positive number");
  require(options.slab > 0.0 && options.slab * options.slabs <= 1.0, "CheckStrategyOptions::slab",
          options.slab, "a positive part of all time, with all slabs at most 1");
  require(options.nodes > 1, "CheckStrategyOptions::nodes", options.nodes, "at least 2");
  return StrategyExaminer(strategy, problem, options).findings();
}

}  // namespace samara::pgd

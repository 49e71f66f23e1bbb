#include "samara/pgd/checks/check_system.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "samara/base/parallel.h"
#include "samara/base/require.h"
#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

namespace {

/// Two ways to the same rate may differ by rounding, relative to the size of its terms.
constexpr double kSameRate = 1e-9;
constexpr double kStep = 6e-6;

struct SystemPoints {
  Eigen::VectorXd t;
  Eigen::MatrixXd x, q;
};

SystemPoints random_system_points(const AdaptiveProblem& problem, int count, Random& random) {
  const auto states = static_cast<Eigen::Index>(problem.states.size());
  const auto parameters = static_cast<Eigen::Index>(problem.parameters.size());
  SystemPoints at{Eigen::VectorXd(count), Eigen::MatrixXd(states, count), Eigen::MatrixXd(parameters, count)};
  for (Eigen::Index j = 0; j < count; ++j) {
    at.t[j] = problem.end * random.uniform();
    for (Eigen::Index k = 0; k < parameters; ++k) {
      const AdaptiveAxis& axis = problem.parameters[static_cast<std::size_t>(k)];
      at.q(k, j) = axis.lower + (axis.upper - axis.lower) * random.uniform();
    }
    for (Eigen::Index s = 0; s < states; ++s) {
      const InitialValue& initial = problem.initial[static_cast<std::size_t>(s)];
      const double start = initial.axis < 0 ? initial.value : at.q(initial.axis, j);
      at.x(s, j) = start + problem.scales[static_cast<std::size_t>(s)] * (2.0 * random.uniform() - 1.0);
    }
  }
  return at;
}

Eigen::MatrixXd rates_of(const EvolutionSystem& system, const SystemPoints& at) {
  Eigen::MatrixXd f;
  system.rhs(at.t, at.x, at.q, f);
  return f;
}

Eigen::MatrixXd jacobian_of(const EvolutionSystem& system, const SystemPoints& at) {
  Eigen::MatrixXd jacobian;
  system.jacobian(at.t, at.x, at.q, jacobian);
  return jacobian;
}

SystemPoints one_of(const SystemPoints& at, Eigen::Index j) {
  return {at.t.segment(j, 1), at.x.col(j), at.q.col(j)};
}

class SystemExaminer {
 public:
  SystemExaminer(const AdaptiveProblem& problem, const CheckSystemOptions& options)
      : problem_(problem), system_(*problem.system), options_(options), random_(options.seed) {
    at_ = random_system_points(problem, options.points, random_);
  }

  Check findings() {
    if (!has_shapes()) return found_;
    compare_batches();
    compare_differences();
    ask_from_threads();
    if (system_.affine_in_parameters()) look_for_curvature();
    if (system_.polynomial() != nullptr) compare_polynomial();
    return found_;
  }

 private:
  void find(const std::string& sentence) { found_.findings.push_back(sentence); }

  bool has_shapes() {
    const auto n = static_cast<Eigen::Index>(problem_.states.size());
    f_ = rates_of(system_, at_);
    jacobian_ = jacobian_of(system_, at_);
    if (f_.rows() != n || f_.cols() != at_.t.size())
      find(fmt::format("rhs() gives {} x {} numbers for {} states and {} points", f_.rows(), f_.cols(), n,
                       at_.t.size()));
    if (jacobian_.rows() != n * n || jacobian_.cols() != at_.t.size()) {
      find(fmt::format("jacobian() gives {} x {} numbers for {} states and {} points", jacobian_.rows(),
                       jacobian_.cols(), n, at_.t.size()));
    }
    if (!found_.passed()) return false;
    for (Eigen::Index j = 0; j < at_.t.size(); ++j) {
      if (f_.col(j).allFinite() && jacobian_.col(j).allFinite()) continue;
      find(fmt::format("{} not finite {}", f_.col(j).allFinite() ? "a derivative is" : "a rate is",
                       described(j)));
      return false;
    }
    return true;
  }

  void compare_batches() {
    for (Eigen::Index j = 0; j < at_.t.size(); ++j) {
      // Results of a call before must not stay.
      Eigen::MatrixXd f = Eigen::MatrixXd::Constant(f_.rows(), 1, 1.0),
                      jacobian = Eigen::MatrixXd::Constant(3, 2, 1.0);
      const SystemPoints one = one_of(at_, j);
      system_.rhs(one.t, one.x, one.q, f);
      system_.jacobian(one.t, one.x, one.q, jacobian);
      if (f.rows() != f_.rows() || f.cols() != 1 || f != f_.col(j))
        return find("rhs() of one point and of many differ " + described(j));
      if (jacobian.rows() != jacobian_.rows() || jacobian.cols() != 1 || jacobian != jacobian_.col(j))
        return find("jacobian() of one point and of many differ " + described(j));
    }
  }

  void compare_differences() {
    const Eigen::Index n = f_.rows();
    double largest = 0.0;
    std::string where;
    for (Eigen::Index k = 0; k < n; ++k) {
      const double scale = problem_.scales[static_cast<std::size_t>(k)];
      SystemPoints above = at_, below = at_;
      above.x.row(k).array() += kStep * scale;
      below.x.row(k).array() -= kStep * scale;
      const Eigen::MatrixXd difference =
          (rates_of(system_, above) - rates_of(system_, below)) / (2.0 * kStep * scale);
      for (Eigen::Index j = 0; j < at_.t.size(); ++j) {
        for (Eigen::Index m = 0; m < n; ++m) {
          const double entry = jacobian_(m + n * k, j);
          const double size = std::abs(entry) + f_.col(j).cwiseAbs().maxCoeff() / scale;
          const double error = std::abs(entry - difference(m, j)) / std::max(size, 1e-300);
          if (error <= largest) continue;
          largest = error;
          where = fmt::format("d {}' / d {} is {:.9g}, by differences {:.9g} {}", name(m), name(k), entry,
                              difference(m, j), described(j));
        }
      }
    }
    if (!(largest <= options_.tolerance)) find(where);
  }

  void ask_from_threads() {
    constexpr int kCalls = 64;
    std::vector<char> same(kCalls, 0);
    parallel_for(kCalls, [&](int i) {
      same[static_cast<std::size_t>(i)] =
          rates_of(system_, at_) == f_ && jacobian_of(system_, at_) == jacobian_;
    });
    if (std::find(same.begin(), same.end(), 0) != same.end())
      find("asked from many threads at once, the system gives other numbers");
  }

  void look_for_curvature() {
    SystemPoints other = random_system_points(problem_, options_.points, random_), mean = at_;
    other.t = at_.t;
    other.x = at_.x;
    mean.q = 0.5 * (at_.q + other.q);
    const Eigen::MatrixXd f_other = rates_of(system_, other);
    const Eigen::MatrixXd curvature = rates_of(system_, mean) - 0.5 * (f_ + f_other);
    const Eigen::MatrixXd size = f_.cwiseAbs() + f_other.cwiseAbs();
    for (Eigen::Index j = 0; j < at_.t.size(); ++j) {
      if (!(curvature.col(j).cwiseAbs().maxCoeff() <= kSameRate * size.col(j).maxCoeff()))
        return find("the system says that it is affine in the parameters, and is not " + described(j));
    }
  }

  void compare_polynomial() {
    const Eigen::MatrixXd difference = rates_of(*system_.polynomial(), at_) - f_;
    for (Eigen::Index j = 0; j < at_.t.size(); ++j) {
      if (!(difference.col(j).cwiseAbs().maxCoeff() <= kSameRate * f_.col(j).cwiseAbs().maxCoeff()))
        return find("polynomial() is not the system's f " + described(j));
    }
  }

  const std::string& name(Eigen::Index state) const {
    return problem_.states[static_cast<std::size_t>(state)].name;
  }

  std::string described(Eigen::Index j) const {
    std::string text = fmt::format("at t = {:.6g}", at_.t[j]);
    for (Eigen::Index s = 0; s < at_.x.rows(); ++s)
      text += fmt::format(", {} = {:.6g}", name(s), at_.x(s, j));
    for (Eigen::Index k = 0; k < at_.q.rows(); ++k)
      text += fmt::format(", {} = {:.6g}", problem_.parameters[static_cast<std::size_t>(k)].label.name,
                          at_.q(k, j));
    return text;
  }

  const AdaptiveProblem& problem_;
  const EvolutionSystem& system_;
  const CheckSystemOptions& options_;
  Random random_;
  SystemPoints at_;
  Eigen::MatrixXd f_, jacobian_;
  Check found_;
};

}  // namespace

Check check_system(const AdaptiveProblem& problem, const CheckSystemOptions& options) {
  check_problem(problem);
  require(options.points > 0, "CheckSystemOptions::points", options.points, "a positive number");
  require(options.tolerance > 0.0, "CheckSystemOptions::tolerance", options.tolerance, "a positive number");
  return SystemExaminer(problem, options).findings();
}

}  // namespace samara::pgd

#include "samara/codebooks/build/time_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "samara/base/require.h"

namespace samara::codebooks {

namespace {

struct Element {
  double begin, end;

  std::pair<Element, Element> halves() const {
    const double middle = 0.5 * (begin + end);
    return {{begin, middle}, {middle, end}};
  }
};

/// Refinement in passes: every pass asks the pilots for the open elements and some generations of halves.
class TimeRefinement {
 public:
  TimeRefinement(const pgd::Axis::Label& label, const TimeMeshOptions& options)
      : label_(label), options_(options) {}

  Outcome<TimeMesh> run(double end, const PilotTrajectories& pilots) {
    constexpr int kGenerations = 4;
    std::vector<Element> open = {{0.0, 0.5 * end}, {0.5 * end, end}};
    int passes = 0;
    while (!open.empty()) {
      if (std::optional<Ending> ending = ask(open, kGenerations, pilots)) return std::move(*ending);
      ++passes;
      std::vector<Element> rough;
      for (const Element& element : open) settle(element, kGenerations, rough);
      open.clear();
      const bool too_many =
          settled_.size() + 2 * rough.size() > static_cast<std::size_t>(options_.max_elements);
      for (const Element& element : rough) {
        if (too_many) {
          settled_[element.begin] = error_of(element);
        } else {
          const auto [first, second] = element.halves();
          open.insert(open.end(), {first, second});
        }
      }
    }
    Eigen::VectorXd borders(static_cast<Eigen::Index>(settled_.size()) + 1);
    Eigen::Index e = 0;
    double worst = 0.0;
    for (const auto& [begin, error] : settled_) {
      borders[e++] = begin;
      worst = std::max(worst, relative(error));
    }
    borders[e] = end;
    return TimeMesh{pgd::Axis::chebyshev(label_, borders, options_.degree), worst, scale(),
                    worst <= options_.tolerance, passes};
  }

 private:
  pgd::Axis axis_of(const Element& element) const {
    return pgd::Axis::chebyshev(label_, Eigen::Vector2d(element.begin, element.end), options_.degree);
  }

  /// Points between the nodes, as many as nodes and more.
  std::vector<double> tests_of(const Element& element) const {
    const int count = 2 * options_.degree + 1;
    std::vector<double> tests;
    for (int i = 0; i < count; ++i)
      tests.push_back(element.begin + (element.end - element.begin) * (i + 0.5) / count);
    return tests;
  }

  void collect(const Element& element, int generations, std::vector<double>& times) const {
    const pgd::Axis axis = axis_of(element);
    const std::vector<double> tests = tests_of(element);
    times.insert(times.end(), axis.nodes().begin(), axis.nodes().end());
    times.insert(times.end(), tests.begin(), tests.end());
    if (generations == 0) return;
    const auto [first, second] = element.halves();
    collect(first, generations - 1, times);
    collect(second, generations - 1, times);
  }

  std::optional<Ending> ask(const std::vector<Element>& open, int generations,
                            const PilotTrajectories& pilots) {
    times_.clear();
    for (const Element& element : open) collect(element, generations, times_);
    std::sort(times_.begin(), times_.end());
    times_.erase(std::unique(times_.begin(), times_.end()), times_.end());
    Outcome<std::vector<Eigen::MatrixXd>> answers = pilots(times_);
    if (!answers) return answers.ending();
    states_ = std::move(*answers);
    for (const Eigen::MatrixXd& states : states_) {
      const Eigen::VectorXd low = states.colwise().minCoeff().transpose();
      const Eigen::VectorXd high = states.colwise().maxCoeff().transpose();
      smallest_ = smallest_.size() == 0 ? low : smallest_.cwiseMin(low).eval();
      largest_ = largest_.size() == 0 ? high : largest_.cwiseMax(high).eval();
    }
    return std::nullopt;
  }

  Eigen::Index row_of(double time) const {
    return std::lower_bound(times_.begin(), times_.end(), time) - times_.begin();
  }

  Eigen::VectorXd error_of(const Element& element) const {
    const pgd::Axis axis = axis_of(element);
    pgd::InterpolationStencil stencil = axis.make_stencil();
    std::vector<Eigen::Index> nodes;
    for (const double t : axis.nodes()) nodes.push_back(row_of(t));
    Eigen::VectorXd error = Eigen::VectorXd::Zero(smallest_.size());
    for (const double t : tests_of(element)) {
      axis.interpolate(t, stencil, false);
      for (const Eigen::MatrixXd& states : states_) {
        const Eigen::VectorXd interpolated = states(nodes, Eigen::all).transpose() * stencil.value;
        error = error.cwiseMax((interpolated - states.row(row_of(t)).transpose()).cwiseAbs());
      }
    }
    return error;
  }

  Eigen::VectorXd scale() const { return pgd::error_scales(smallest_, largest_, options_.measure); }

  double relative(const Eigen::VectorXd& error) const { return error.cwiseQuotient(scale()).maxCoeff(); }

  /// Takes the element, or else its halves, if their errors allow; what is still rough after some generations
  /// is left to the next pass.
  void settle(const Element& element, int generations, std::vector<Element>& rough) {
    Eigen::VectorXd error = error_of(element);
    if (relative(error) <= options_.tolerance) {
      settled_[element.begin] = std::move(error);
    } else if (generations == 0) {
      rough.push_back(element);
    } else {
      const auto [first, second] = element.halves();
      settle(first, generations - 1, rough);
      settle(second, generations - 1, rough);
    }
  }

  const pgd::Axis::Label& label_;
  const TimeMeshOptions& options_;
  /// By the beginnings of the elements that stay: error per output, in its unit.
  std::map<double, Eigen::VectorXd> settled_;
  std::vector<double> times_;  ///< of the present pass
  std::vector<Eigen::MatrixXd> states_;
  Eigen::VectorXd smallest_, largest_;
};

}  // namespace

Outcome<TimeMesh> mesh_time(const pgd::Axis::Label& label, double end, const PilotTrajectories& pilots,
                            const TimeMeshOptions& options) {
  require(end > 0.0, "the end of time [s]", end, "more than 0", "mesh_time");
  require(options.tolerance > 0.0, "tolerance", options.tolerance, "more than 0", "mesh_time");
  require(options.degree >= 2, "degree", options.degree, "at least 2", "mesh_time");
  require(options.max_elements >= 2, "max_elements", options.max_elements, "at least 2", "mesh_time");
  return TimeRefinement(label, options).run(end, pilots);
}

}  // namespace samara::codebooks

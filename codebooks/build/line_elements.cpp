#include "samara/codebooks/build/line_elements.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "samara/pgd/tensors/train_points.h"

namespace samara::codebooks {

namespace {

using Eigen::Index;

class LineRefinement {
 public:
  using Values = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& points)>;

  LineRefinement(Index coordinate, const pgd::Axis::Label& label, double lower, double upper,
                 const Values& values, const LineElementsOptions& options)
      : coordinate_(coordinate), label_(label), values_(values), options_(options) {
    borders_ = {lower, upper};
    if (options.borders.size() == 0) borders_.insert(middle_of({lower, upper}));
    borders_.insert(options.borders.begin(), options.borders.end());
  }

  std::optional<LineElements> run(const std::function<Eigen::MatrixXd()>& fresh_bases) {
    bases_ = fresh_bases();
    steepest_ = bases_;
    slopes_.setZero(bases_.cols());
    bool is_first = true;
    for (std::vector<Part> rough = rough_of(all_parts(), is_first); !rough.empty();) {
      while (!rough.empty()) {
        if (!halve(rough)) return {};
        rough = rough_of(std::exchange(halves_, {}), is_first);
      }
      is_first = false;
      bases_ = fresh_bases();
      rough = rough_of(all_parts(), is_first);
    }
    return LineElements{pgd::Axis::chebyshev(label_, borders(), options_.degree), std::move(steepest_)};
  }

 private:
  using Part = std::pair<double, double>;

  pgd::Axis axis_over(const Part& part) const {
    return pgd::Axis::chebyshev(label_, Eigen::Vector2d(part.first, part.second), options_.degree);
  }

  double middle_of(const Part& part) const { return axis_over(part).nodes()[options_.degree / 2]; }

  std::vector<Part> all_parts() const {
    std::vector<Part> parts;
    for (auto end = std::next(borders_.begin()); end != borders_.end(); ++end)
      parts.emplace_back(*std::prev(end), *end);
    return parts;
  }

  Eigen::VectorXd borders() const {
    const std::vector<double> all(borders_.begin(), borders_.end());
    return Eigen::VectorXd::Map(all.data(), static_cast<Index>(all.size()));
  }

  /// @returns whether nodes and points allow it
  bool halve(const std::vector<Part>& rough) {
    for (const Part& part : rough) {
      const double middle = middle_of(part);
      borders_.insert(middle);
      halves_.insert(halves_.end(), {{part.first, middle}, {middle, part.second}});
    }
    return static_cast<Index>(borders_.size() - 1) * options_.degree + 1 <= options_.max_nodes &&
           points_ <= options_.max_points;
  }

  std::vector<Part> rough_of(const std::vector<Part>& parts, bool is_first) {
    std::vector<Part> rough;
    for (const Part& part : parts) {
      if (error_of(part, is_first) > options_.tolerance) rough.push_back(part);
    }
    return rough;
  }

  /// Largest error between the nodes, of which there is one test in each gap.
  double error_of(const Part& part, bool is_first) {
    constexpr Index kTogether = 8;  // lines
    const pgd::Axis axis = axis_over(part);
    const Index nodes = axis.size(), tests = nodes - 1, count = nodes + tests;
    Eigen::VectorXd places(count);
    places.head(nodes) = axis.nodes();
    places.tail(tests) = 0.5 * (axis.nodes().head(tests) + axis.nodes().tail(tests));
    const Eigen::MatrixXd between = pgd::interpolation_matrix(axis, places.tail(tests)).transpose();
    double error = 0.0;
    for (Index first = 0; first < bases_.cols(); first += kTogether) {
      Eigen::MatrixXd points(bases_.rows(), kTogether * count);
      for (Index line = 0; line < kTogether; ++line) {
        points.middleCols(line * count, count) = bases_.col(first + line).replicate(1, count);
        points.block(coordinate_, line * count, 1, count) = places.transpose();
      }
      points_ += points.cols();
      const Eigen::MatrixXd values = values_(points);
      for (Index line = 0; line < kTogether; ++line) {
        const auto at_nodes = values.middleCols(line * count, nodes);
        const auto exact = values.middleCols(line * count + nodes, tests);
        error = std::max(error, (at_nodes * between - exact).cwiseAbs().maxCoeff());
        if (is_first) look_for_steepest(first + line, places.head(nodes), at_nodes);
      }
    }
    return error;
  }

  void look_for_steepest(Index line, const Eigen::VectorXd& nodes,
                         const Eigen::Ref<const Eigen::MatrixXd>& values) {
    for (Index i = 0; i + 1 < nodes.size(); ++i) {
      const double slope =
          (values.col(i + 1) - values.col(i)).cwiseAbs().maxCoeff() / (nodes[i + 1] - nodes[i]);
      if (!(slope > slopes_[line])) continue;
      slopes_[line] = slope;
      steepest_(coordinate_, line) = 0.5 * (nodes[i] + nodes[i + 1]);
    }
  }

  const Index coordinate_;
  const pgd::Axis::Label& label_;
  const Values& values_;
  const LineElementsOptions& options_;
  std::set<double> borders_;
  std::vector<Part> halves_;
  Eigen::MatrixXd bases_, steepest_;
  Eigen::VectorXd slopes_;
  long points_ = 0;
};

}  // namespace

std::optional<LineElements> elements_along(
    Index coordinate, const pgd::Axis::Label& label, double lower, double upper,
    const std::function<Eigen::MatrixXd(const Eigen::MatrixXd& points)>& values,
    const std::function<Eigen::MatrixXd()>& fresh_bases, const LineElementsOptions& options) {
  return LineRefinement(coordinate, label, lower, upper, values, options).run(fresh_bases);
}

Eigen::MatrixXd points_by_elements(const std::vector<pgd::Axis>& axes, int count, pgd::Random& random) {
  Eigen::MatrixXd points(static_cast<Index>(axes.size()), count);
  for (Index j = 0; j < points.cols(); ++j) {
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const int element = random.below(axes[k].elements());
      const double lower = axes[k].borders()[element], upper = axes[k].borders()[element + 1];
      points(static_cast<Index>(k), j) = lower + (upper - lower) * random.uniform();
    }
  }
  return points;
}

}  // namespace samara::codebooks

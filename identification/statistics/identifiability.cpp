#include "samara/identification/statistics/identifiability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::identification {

namespace {

const double kUndetermined = 1.0 / std::sqrt(3.0);
constexpr double kWeak = 0.25;
/// A smaller part in what is not determined is rounding.
constexpr double kNoPart = 1e-2;
/// Cosine between two coefficients within what is not determined, above which they are coupled.
constexpr double kCoupled = 0.05;
/// Factors of a combination closer than this to 1 are called a sum, a difference, a ratio or a product.
constexpr double kEqualFactors = 0.05;
/// Eigenvalues below this part of the largest are rounding of J^T J.
constexpr double kRounding = 1e-14;

using Coefficients = std::vector<InformedCoefficient>;

void check(const Coefficients& coefficients, const Eigen::MatrixXd& information, double dispersion) {
  const auto count = static_cast<Eigen::Index>(coefficients.size());
  if (information.rows() != count || information.cols() != count) {
    throw ArgumentError(
        fmt::format("the information matrix is {} x {}; {} x {} was expected, for {} coefficients",
                    information.rows(), information.cols(), count, count, count));
  }
  if (!information.allFinite())
    throw ArgumentError("the information matrix holds a number that is not finite");
  if (!(dispersion > 0.0 && std::isfinite(dispersion))) {
    throw ArgumentError(fmt::format("dispersion is {}; a positive number was expected", dispersion));
  }
  for (const InformedCoefficient& c : coefficients) {
    if (!(c.scale > 0.0 && std::isfinite(c.scale))) {
      throw ArgumentError(
          fmt::format("the scale of \"{}\" is {}; a positive number was expected", c.name, c.scale));
    }
    if (!std::isfinite(c.value) || (c.log_scaled && c.value <= 0.0)) {
      throw ArgumentError(fmt::format("the value of \"{}\" is {}; a {} number was expected", c.name, c.value,
                                      c.log_scaled ? "positive" : "finite"));
    }
  }
}

DirectionKind kind_of(double standard_error) {
  if (standard_error > kUndetermined) return DirectionKind::undetermined;
  return standard_error > kWeak ? DirectionKind::weak : DirectionKind::determined;
}

std::vector<InformationDirection> directions_of(const Coefficients& coefficients,
                                                const Eigen::MatrixXd& information, double dispersion) {
  const auto count = static_cast<Eigen::Index>(coefficients.size());
  Eigen::VectorXd scale(count);
  for (Eigen::Index k = 0; k < count; ++k) scale[k] = coefficients[static_cast<std::size_t>(k)].scale;
  const Eigen::MatrixXd symmetric = 0.5 * (information + information.transpose());
  const Eigen::MatrixXd scaled = scale.asDiagonal() * symmetric * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen((scaled / dispersion).eval());
  const double rounding = kRounding * std::max(0.0, eigen.eigenvalues()[count - 1]);
  std::vector<InformationDirection> directions;
  for (Eigen::Index j = 0; j < count; ++j) {
    InformationDirection direction;
    const double value = eigen.eigenvalues()[j];
    direction.eigenvalue = value > rounding ? value : 0.0;
    direction.standard_error = direction.eigenvalue > 0.0 ? 1.0 / std::sqrt(direction.eigenvalue)
                                                          : std::numeric_limits<double>::infinity();
    direction.kind = kind_of(direction.standard_error);
    direction.vector = eigen.eigenvectors().col(j);
    Eigen::Index largest = 0;
    direction.vector.cwiseAbs().maxCoeff(&largest);
    if (direction.vector[largest] < 0.0) direction.vector = -direction.vector;
    directions.push_back(std::move(direction));
  }
  return directions;
}

/// Sum of v v^T over the directions of one kind: 1 for a coefficient that is known not at all.
Eigen::MatrixXd projection_on(const std::vector<InformationDirection>& directions, DirectionKind kind,
                              Eigen::Index count) {
  Eigen::MatrixXd projection = Eigen::MatrixXd::Zero(count, count);
  for (const InformationDirection& d : directions) {
    if (d.kind == kind) projection += d.vector * d.vector.transpose();
  }
  return projection;
}

/// Coefficients whose own error, from undetermined directions alone, is weak or worse.
std::vector<int> touched(const std::vector<InformationDirection>& directions, Eigen::Index count) {
  std::vector<int> members;
  for (Eigen::Index k = 0; k < count; ++k) {
    double largest = 0.0;
    for (const InformationDirection& d : directions) {
      const double part = std::abs(d.vector[k]);
      if (d.kind == DirectionKind::undetermined && part > kNoPart)
        largest = std::max(largest, part * d.standard_error);
    }
    if (largest > kWeak) members.push_back(static_cast<int>(k));
  }
  return members;
}

/// Splits the members where undetermined directions do not couple them.
std::vector<std::vector<int>> coupled_sets(const Eigen::MatrixXd& projection,
                                           const std::vector<int>& members) {
  std::vector<int> label(members.size());
  std::iota(label.begin(), label.end(), 0);
  for (std::size_t i = 0; i < members.size(); ++i) {
    for (std::size_t k = i + 1; k < members.size(); ++k) {
      const double sizes = projection(members[i], members[i]) * projection(members[k], members[k]);
      const double cosine = projection(members[i], members[k]) / std::sqrt(sizes);
      if (std::abs(cosine) <= kCoupled) continue;
      const int from = label[k];
      const int to = label[i];
      std::ranges::replace(label, from, to);
    }
  }
  std::vector<std::vector<int>> sets;
  for (int wanted = 0; wanted < static_cast<int>(members.size()); ++wanted) {
    std::vector<int> set;
    for (std::size_t k = 0; k < members.size(); ++k) {
      if (label[k] == wanted) set.push_back(members[k]);
    }
    if (!set.empty()) sets.push_back(std::move(set));
  }
  return sets;
}

bool equal(double factor, double wanted) {
  return std::abs(factor - wanted) < kEqualFactors;
}

/// "2.5 x", "x", with a sign in front for all but the first.
std::string term(double factor, const std::string& name, bool first) {
  const std::string sign = factor < 0.0 ? (first ? "-" : " - ") : (first ? "" : " + ");
  return equal(std::abs(factor), 1.0) ? fmt::format("{}{}", sign, name)
                                      : fmt::format("{}{:.2g} {}", sign, std::abs(factor), name);
}

/// What is known of the members: sum_k factor_k x_k, where x is the logarithm for log-scaled ones. The factor
/// of the first is 1.
struct Combination {
  std::vector<const InformedCoefficient*> members;
  std::vector<double> factors;

  bool all_logarithms() const {
    return std::ranges::all_of(members, [](const InformedCoefficient* c) { return c->log_scaled; });
  }

  std::string formula() const {
    std::string text;
    for (std::size_t k = 0; k < members.size(); ++k) {
      if (all_logarithms()) {
        text += k == 0 ? "" : " * ";
        text += equal(factors[k], 1.0) ? members[k]->name
                                       : fmt::format("{}^{:.2g}", members[k]->name, factors[k]);
      } else {
        const std::string name =
            members[k]->log_scaled ? fmt::format("log({})", members[k]->name) : members[k]->name;
        text += term(factors[k], name, k == 0);
      }
    }
    return text;
  }
};

/// The relative change of a member that goes with a change of its coordinate.
double relative(const InformedCoefficient& c, double change) {
  return c.log_scaled ? change : change / c.value;
}

std::string pair_phrase(const Combination& known) {
  const InformedCoefficient& a = *known.members[0];
  const InformedCoefficient& b = *known.members[1];
  const double factor = known.factors[1];
  if (!a.log_scaled && !b.log_scaled) {
    if (equal(factor, 1.0)) return fmt::format("{} and {} only as a sum", a.name, b.name);
    if (equal(factor, -1.0)) return fmt::format("{} and {} only as a difference", a.name, b.name);
  }
  // Along the unknown direction, (factor, -1), the relative changes are equal (ratio) or opposite (product).
  if ((a.log_scaled || a.value != 0.0) && (b.log_scaled || b.value != 0.0)) {
    const double ratio = relative(b, -1.0) / relative(a, factor);
    if (equal(ratio, 1.0)) return fmt::format("{} only relative to {} (ratio)", a.name, b.name);
    if (equal(ratio, -1.0)) return fmt::format("{} and {} only as a product", a.name, b.name);
  }
  return fmt::format("{} and {} only as {}", a.name, b.name, known.formula());
}

/// The one combination of the members that is known: orthogonal to all that is not, hence the eigenvector of
/// the smallest eigenvalue of the projection, in scaled coordinates.
Combination known_combination(const Coefficients& coefficients, const Eigen::MatrixXd& projection,
                              const std::vector<int>& members) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(projection(members, members).eval());
  Eigen::VectorXd factors = eigen.eigenvectors().col(0);
  Combination known;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const InformedCoefficient& c = coefficients[static_cast<std::size_t>(members[k])];
    known.members.push_back(&c);
    known.factors.push_back(factors[static_cast<Eigen::Index>(k)] / c.scale);
  }
  const double first = known.factors[0];
  for (double& factor : known.factors) factor /= first;
  return known;
}

std::string names_of(const Coefficients& coefficients, const std::vector<int>& members) {
  std::string text;
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (k > 0) text += k + 1 == members.size() ? " and " : ", ";
    text += coefficients[static_cast<std::size_t>(members[k])].name;
  }
  return text;
}

std::string phrase_of(const Coefficients& coefficients, const Eigen::MatrixXd& projection,
                      const std::vector<int>& members) {
  const Eigen::MatrixXd part = projection(members, members);
  const auto unknown = static_cast<int>(std::lround(part.trace()));
  const int known = static_cast<int>(members.size()) - unknown;
  if (known <= 0) return fmt::format("{} not at all", names_of(coefficients, members));
  if (unknown > 0 && known == 1) {
    const Combination combination = known_combination(coefficients, projection, members);
    if (members.size() == 2) return pair_phrase(combination);
    return fmt::format("{} only as {}", names_of(coefficients, members), combination.formula());
  }
  return fmt::format("{} in {} combination{} only", names_of(coefficients, members), known,
                     known == 1 ? "" : "s");
}

/// "C_A only weakly", "C_A and C_R weakly along C_A - 0.5 C_R".
std::string weak_phrase(const Coefficients& coefficients, const InformationDirection& direction) {
  std::vector<int> members;
  const double largest = direction.vector.cwiseAbs().maxCoeff();
  for (Eigen::Index k = 0; k < direction.vector.size(); ++k) {
    if (std::abs(direction.vector[k]) >= 0.25 * largest) members.push_back(static_cast<int>(k));
  }
  const std::string names = names_of(coefficients, members);
  if (members.size() == 1) return fmt::format("{} only roughly", names);
  std::string changes;
  for (const int k : members) {
    const InformedCoefficient& c = coefficients[static_cast<std::size_t>(k)];
    const double change = direction.vector[k] * c.scale * direction.standard_error;
    changes += fmt::format("{}{} by {:+.2g}{}", changes.empty() ? "" : ", ", c.name,
                           c.log_scaled ? 100.0 * std::expm1(change) : change, c.log_scaled ? " %" : "");
  }
  return fmt::format("{} only roughly along one line ({}: one standard error)", names, changes);
}

}  // namespace

std::string to_string(DirectionKind kind) {
  switch (kind) {
    case DirectionKind::determined:
      return "determined";
    case DirectionKind::weak:
      return "weak";
    case DirectionKind::undetermined:
      return "undetermined";
  }
  throw ArgumentError("a direction of no known kind");
}

Identifiability identifiability(const std::vector<InformedCoefficient>& coefficients,
                                const Eigen::MatrixXd& information, double dispersion) {
  check(coefficients, information, dispersion);
  Identifiability result;
  for (const InformedCoefficient& c : coefficients) result.names.push_back(c.name);
  if (coefficients.empty()) return result;
  result.directions = directions_of(coefficients, information, dispersion);

  const Eigen::MatrixXd projection =
      projection_on(result.directions, DirectionKind::undetermined, information.rows());
  for (const std::vector<int>& members :
       coupled_sets(projection, touched(result.directions, information.rows())))
    result.phrases.push_back(phrase_of(coefficients, projection, members));
  for (const InformationDirection& direction : result.directions) {
    if (direction.kind == DirectionKind::undetermined) ++result.undetermined_count;
    if (direction.kind == DirectionKind::weak) result.phrases.push_back(weak_phrase(coefficients, direction));
  }
  return result;
}

}  // namespace samara::identification

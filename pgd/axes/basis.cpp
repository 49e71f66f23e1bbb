#include "samara/pgd/axes/basis.h"

#include <algorithm>
#include <array>
#include <utility>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/axes/enum_names.h"
#include "samara/pgd/axes/quadrature.h"

namespace samara::pgd {

namespace {

Eigen::VectorXd ends(int) {
  return Eigen::Vector2d(-1.0, 1.0);
}

Eigen::VectorXd ends_and_middle(int) {
  return Eigen::Vector3d(-1.0, 0.0, 1.0);
}

Eigen::VectorXd chebyshev_element(int degree) {
  return chebyshev_lobatto_nodes(degree + 1);
}

Eigen::VectorXd legendre_element(int degree) {
  return legendre_lobatto_nodes(degree + 1);
}

Eigen::VectorXd radau_element(int degree) {
  Eigen::VectorXd nodes(degree + 1);
  nodes << -1.0, gauss_radau_right(degree).nodes;
  return nodes;
}

Axis p1_axis(AxisLabel label, double lower, double upper, int nodes) {
  return Axis::p1(std::move(label), lower, upper, nodes);
}

Axis p2_axis(AxisLabel label, double lower, double upper, int nodes) {
  return Axis::p2(std::move(label), lower, upper, nodes / 2);
}

// In the order of the enumerators: name and family; whether a file can hold it, highest coefficients tell the
// resolution, numbers of nodes are odd; nodes of an element, and the axis over an interval.
constexpr std::array<BasisTraits, 8> kBases = {{
    {Basis::p1, "p1", AxisFamily::elements, true, false, false, ends, p1_axis},
    {Basis::chebyshev, "chebyshev", AxisFamily::elements, true, true, false, chebyshev_element,
     Axis::chebyshev},
    {Basis::radau, "radau", AxisFamily::elements, true, true, false, radau_element, nullptr},
    {Basis::p2, "p2", AxisFamily::elements, true, false, true, ends_and_middle, p2_axis},
    {Basis::legendre, "legendre", AxisFamily::elements, true, true, false, legendre_element, Axis::legendre},
    {Basis::fourier, "fourier", AxisFamily::periodic, true, true, true, nullptr, Axis::fourier},
    {Basis::discrete, "discrete", AxisFamily::list, true, false, false, nullptr, nullptr},
    {Basis::imported, "imported", AxisFamily::list, false, false, false, nullptr, nullptr},
}};

constexpr std::array<const char*, kBases.size()> names_of_bases() {
  std::array<const char*, kBases.size()> names{};
  for (std::size_t i = 0; i < kBases.size(); ++i) names[i] = kBases[i].name;
  return names;
}

}  // namespace

const BasisTraits& basis_traits(Basis basis) {
  return kBases.at(static_cast<std::size_t>(basis));
}

std::vector<std::string> parameter_basis_names() {
  std::vector<std::string> names;
  for (const bool chosen : {true, false}) {
    for (const BasisTraits& traits : kBases) {
      if (traits.discretises_parameters() && traits.tells_resolution == chosen)
        names.emplace_back(traits.name);
    }
  }
  return names;
}

std::string to_string(Basis basis) {
  return basis_traits(basis).name;
}

Basis basis_from_string(const std::string& name) {
  return from_name<Basis>("basis", name, names_of_bases());
}

}  // namespace samara::pgd

#include "models/added_mass/panel_integrals.h"

#include <cmath>
#include <numbers>
#include <random>

#include <boost/math/quadrature/gauss.hpp>
#include <catch2/catch.hpp>

using namespace samara::models::added_mass;
using Catch::Matchers::WithinAbs;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Int g(y) dS over a triangle by a product rule collapsed at a corner, 30 x 30 points.
template <class Function>
auto integral(const Panel& p, const Function& g) {
  using Rule = boost::math::quadrature::gauss<double, 30>;
  const auto node = [](int i) {
    const std::size_t k = static_cast<std::size_t>(i < 15 ? 14 - i : i - 15);
    return std::pair(0.5 + 0.5 * (i < 15 ? -Rule::abscissa()[k] : Rule::abscissa()[k]),
                     0.5 * Rule::weights()[k]);
  };
  decltype(g(p.centroid)) sum = g(p.centroid) * 0.0;
  for (int i = 0; i < 30; ++i) {
    for (int j = 0; j < 30; ++j) {
      const auto [s, w_s] = node(i);
      const auto [t, w_t] = node(j);
      const Vector3d y =
          p.corner[0] + s * ((1.0 - t) * (p.corner[1] - p.corner[0]) + t * (p.corner[2] - p.corner[0]));
      sum += g(y) * (2.0 * p.area * s * w_s * w_t);
    }
  }
  return sum;
}

const Panel kPanel({0.1, 0.2, -0.1}, {1.3, 0.1, 0.2}, {0.4, 0.9, 0.1});

}  // namespace

TEST_CASE("integrals over a panel equal quadrature at points around it") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-2.0, 2.0);
  int points = 0;
  while (points < 50) {
    const Vector3d x(place(random), place(random), place(random));
    // The rule is exact to round-off for points a panel's size away.
    if ((x - kPanel.centroid).norm() < 1.5) continue;
    ++points;
    const PanelIntegrals exact = integrate_panel(kPanel, x);
    const double d = (x - kPanel.centroid).dot(kPanel.normal);
    CHECK_THAT(exact.source,
               WithinAbs(integral(kPanel, [&](const Vector3d& y) { return 1.0 / (x - y).norm(); }), 1e-12));
    const Vector3d moment =
        integral(kPanel, [&](const Vector3d& y) -> Vector3d { return y / (x - y).norm(); });
    CHECK((exact.source_moment - moment).norm() < 1e-12);
    for (std::size_t k = 0; k < 3; ++k) {
      const double dipole = integral(kPanel, [&](const Vector3d& y) {
        const double psi = 1.0 / 3.0 + kPanel.gradient[k].dot(y - kPanel.centroid);
        return psi * d / std::pow((x - y).norm(), 3);
      });
      CHECK_THAT(exact.dipole[k], WithinAbs(dipole, 1e-12));
    }
    CHECK_THAT(exact.dipole[0] + exact.dipole[1] + exact.dipole[2], WithinAbs(exact.solid_angle, 1e-13));
  }
}

TEST_CASE("integrals over a panel stay finite in its plane, on its sides and at its corners") {
  const Vector3d on_side = 0.3 * kPanel.corner[0] + 0.7 * kPanel.corner[1];
  const Vector3d beyond = 2.0 * kPanel.corner[1] - kPanel.corner[0];
  for (const Vector3d& x : {kPanel.centroid, on_side, kPanel.corner[2], beyond}) {
    const PanelIntegrals at = integrate_panel(kPanel, x);
    CHECK(std::isfinite(at.source));
    CHECK(at.source > 0.0);
    CHECK(at.source_moment.allFinite());
    // The source's potential is continuous across the plane, with a slope of at most 2 pi.
    const double h = 1e-7;
    CHECK_THAT(integrate_panel(kPanel, x + h * kPanel.normal).source, WithinAbs(at.source, 10.0 * h));
  }
}

TEST_CASE("a panel is seen under 2 pi from its own face, with the sign of the side") {
  // At the height h the sides take away O(h/size).
  for (const double side : {1.0, -1.0}) {
    const PanelIntegrals at = integrate_panel(kPanel, kPanel.centroid + side * 1e-9 * kPanel.normal);
    CHECK_THAT(at.solid_angle, WithinAbs(side * 2.0 * pi, 1e-7));
    for (const double dipole : at.dipole) CHECK_THAT(dipole, WithinAbs(side * 2.0 * pi / 3.0, 1e-7));
  }
}

TEST_CASE("the second moment of a panel is that of quadrature") {
  const Eigen::Matrix3d moment = integral(kPanel, [](const Vector3d& y) -> Eigen::Matrix3d {
    return (y - kPanel.centroid) * (y - kPanel.centroid).transpose();
  });
  CHECK((kPanel.second_moment * kPanel.area - moment).norm() < 1e-14);
}

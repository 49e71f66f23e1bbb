#include "samara/models/added_mass/ellipsoid.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <boost/math/special_functions/ellint_rd.hpp>
#include <catch2/catch.hpp>

#include "models/added_mass/ellipsoid_integrals.h"
#include "samara/base/errors.h"
#include "samara/models/batch/dual.h"

using namespace samara::models;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;

namespace {

struct CheckValue {
  Vector3d semi_axes;
  Vector3d ABC;
  Vector3d M;  ///< over m_f
  Vector3d J;  ///< over m_f
};

/// By high-order quadrature of the integrals with 30 digits.
const std::vector<CheckValue> kTable = {
    {{1, 1, 1}, {2.0 / 3, 2.0 / 3, 2.0 / 3}, {0.5, 0.5, 0.5}, {0, 0, 0}},
    {{2, 1, 1},
     {0.34712799506792846, 0.82643600246603577, 0.82643600246603577},
     {0.2100150489766414, 0.70421042585035317, 0.70421042585035317},
     {0, 0.23942389319515449, 0.23942389319515449}},
    {{1, 1, 0.5},
     {0.47279971743743016, 0.47279971743743016, 1.0544005651251397},
     {0.30958592847042602, 0.30958592847042602, 1.1150604856956984},
     {0.08464448260669703, 0.08464448260669703, 0}},
    {{4, 2, 1},
     {0.22470088315100774, 0.56956096338567391, 1.2057381534633184},
     {0.12657071758692307, 0.39817213373437774, 1.5180612775507823},
     {0.40619816083618723, 3.3137263923705189, 0.58072194276019189}},
    {{3, 2, 0.5},
     {0.1874863231935683, 0.33012891981865992, 1.4823847569877718},
     {0.10343994949815266, 0.19769724964804438, 2.8638738464522995},
     {1.2450358215853631, 3.5906287375148341, 0.087557569009561709}},
    {{10, 1, 1},
     {0.040571760603127648, 0.97971411969843618, 0.97971411969843618},
     {0.020705918077212136, 0.96023490926764965, 0.96023490926764965},
     {0, 17.847475965746341, 17.847475965746341}},
    {{3.5, 2, 0.04},
     {0.014884900277398323, 0.03436505220907775, 1.9507500475135239},
     {0.0074982555316204721, 0.017482926953297658, 39.609176233199322},
     {18.670453154477253, 74.529590718876055, 0.016385480761143784}},
    {{3.5, 2, 0.01},
     {0.0037692198431553324, 0.0087373436695409581, 1.9874934364873037},
     {0.001888168382444831, 0.0043878408716017001, 158.91603112794811},
     {74.862510133615323, 299.20373356079334, 0.0041188550937128815}},
    {{7.3, 4.2, 0.03},
     {0.0054246362411332286, 0.012438398136723501, 1.9821369656221433},
     {0.0027196947980497754, 0.0062581195596971153, 110.96306056933016},
     {230.851898058701, 907.26212630489047, 0.025179749462774923}},
    {{1, 1, 0.01},
     {0.015510293087130802, 0.015510293087130802, 1.9689794138257384},
     {0.0078157588991776997, 0.0078157588991776997, 63.473314229614386},
     {8.4666995133437509, 8.4666995133437509, 0}},
    {{1, 1, 1e-4},
     {1.5705963503541751e-4, 1.5705963503541751e-4, 1.9996858807299292},
     {7.853598493427422e-5, 7.853598493427422e-5, 6366.0083008565274},
     {848.80647275622168, 848.80647275622168, 0}},
};

DiagonalAddedMass over_mf(const Vector3d& s) {
  return ellipsoid_added_mass(s, 3.0 / (4.0 * std::numbers::pi * s.prod()));
}

void check_each(const Vector3d& value, const Vector3d& expected, double relative) {
  for (int i = 0; i < 3; ++i) CHECK_THAT(value[i], WithinRel(expected[i], relative));
}

}  // namespace

TEST_CASE("the added mass of ellipsoids has twelve digits from spheres to thin leaves, (5.9)-(5.11)") {
  for (const CheckValue& row : kTable) {
    INFO(row.semi_axes.transpose());
    const DiagonalAddedMass K = over_mf(row.semi_axes);
    check_each(ellipsoid_shape_integrals(row.semi_axes), row.ABC, 1e-12);
    check_each(K.mass, row.M, 1e-12);
    check_each(K.inertia, row.J, 1e-12);
  }
}

TEST_CASE("the order of the semi-axes is free") {
  for (const CheckValue& row : kTable) {
    for (const auto& order : {Eigen::Vector3i(1, 2, 0), Eigen::Vector3i(2, 0, 1), Eigen::Vector3i(2, 1, 0),
                              Eigen::Vector3i(0, 2, 1), Eigen::Vector3i(1, 0, 2)}) {
      const DiagonalAddedMass K = over_mf(row.semi_axes(order));
      check_each(K.mass, row.M(order), 1e-12);
      check_each(K.inertia, row.J(order), 1e-12);
    }
  }
}

TEST_CASE("the three integrals of an ellipsoid sum to two, and equal those of Boost.Math") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-6.0, 0.0);
  for (int i = 0; i < 300; ++i) {
    const Vector3d s(std::pow(10.0, exponent(random)), std::pow(10.0, exponent(random)), 1.0);
    INFO(s.transpose());
    const Vector3d ABC = ellipsoid_shape_integrals(s);
    CHECK_THAT(ABC.sum(), WithinAbs(2.0, 1e-14));
    const Vector3d q = s.cwiseProduct(s);
    for (int k = 0; k < 3; ++k) {
      const double R_D = boost::math::ellint_rd(q[(k + 1) % 3], q[(k + 2) % 3], q[k]);
      CHECK_THAT(ABC[k], WithinRel(2.0 / 3.0 * s.prod() * R_D, 1e-13));
    }
  }
}

TEST_CASE("a thin disc has 8/3 rho a^3 broadside and 16/45 rho a^5 about a diameter in the limit") {
  struct Disc {
    double c, mass, inertia;
  };
  for (const Disc& disc :
       {Disc{1e-2, 2.65876396910337, 0.35465227988364}, Disc{1e-4, 2.66658732142167, 0.355547223884055},
        Disc{1e-6, 2.66666587318224, 0.355555472309127}}) {
    const DiagonalAddedMass K = ellipsoid_added_mass({1.0, 1.0, disc.c}, 1.0);
    // The values are printed to 15 digits.
    CHECK_THAT(K.mass[2], WithinRel(disc.mass, 1e-13));
    CHECK_THAT(K.inertia[0], WithinRel(disc.inertia, 1e-13));
    CHECK_THAT(K.inertia[1], WithinRel(disc.inertia, 1e-13));
    // The first correction is of the order c/a.
    CHECK_THAT(K.mass[2], WithinRel(8.0 / 3.0, disc.c));
    CHECK_THAT(K.inertia[0], WithinRel(16.0 / 45.0, disc.c));
    CHECK(K.mass[0] < 5.0 * disc.c * disc.c);
  }
}

TEST_CASE("prolate spheroids have their closed form") {
  for (const double b : {0.9, 0.5, 0.1, 0.01}) {
    const double e2 = (1.0 - b) * (1.0 + b), e = std::sqrt(e2);
    const double A = 2.0 * (1.0 - e2) / (e2 * e) * (std::atanh(e) - e);
    // atanh(e) - e loses a factor 3/e^2 of its digits: at most 16 here.
    CHECK_THAT(ellipsoid_shape_integrals({1.0, b, b})[0], WithinRel(A, 1e-13));
  }
}

TEST_CASE("an elliptic cylinder is the limit of long ellipsoids") {
  // Strip theory: M_z per unit length pi rho b^2 of a section with half chord b, integrated over the
  // sections b^2 (1-x^2/a^2) of the ellipsoid, 4/3 pi rho a b^2; end effects are of the order
  // (b/a)^2 log(a/b) = 2e-7.
  const double a = 1e4, b = 2.0, c = 0.5;
  const DiagonalAddedMass K = ellipsoid_added_mass({a, b, c}, 1.0);
  CHECK_THAT(K.mass[2], WithinRel(4.0 / 3.0 * std::numbers::pi * a * b * b, 1e-6));
  CHECK_THAT(K.mass[1], WithinRel(4.0 / 3.0 * std::numbers::pi * a * c * c, 1e-6));
  // pi/8 rho (b^2-c^2)^2 per unit length, integrated with (1-x^2/a^2)^2: a factor 16/15 a.
  const double d = b * b - c * c;
  CHECK_THAT(K.inertia[0], WithinRel(std::numbers::pi / 8.0 * d * d * 16.0 / 15.0 * a, 1e-6));
}

TEST_CASE("added inertia over m_f scales with the square of the length; the printed (5.11) does not") {
  // (5.11) as printed: the last bracket squared once more than it should be.
  const auto printed_J_x = [](const Vector3d& s) {
    const Vector3d ABC = ellipsoid_shape_integrals(s);
    const double b2 = s[1] * s[1], c2 = s[2] * s[2];
    return 0.2 * (b2 - c2) * (b2 - c2) * (ABC[2] - ABC[1]) /
           (2.0 * (b2 - c2) + (b2 + c2) * (b2 + c2) * (ABC[1] - ABC[2]));
  };
  const Vector3d s(4.0, 2.0, 1.0);
  const Vector3d J = over_mf(s).inertia;
  for (const double scale : {0.01, 3.0, 1e4})
    check_each(over_mf(scale * s).inertia, scale * scale * J, 1e-14);

  CHECK_THAT(printed_J_x(s), WithinRel(-0.11562, 1e-4));  // the wrong sign
  CHECK_THAT(printed_J_x(0.01 * s), WithinRel(1.909e-5, 1e-3));
  CHECK_THAT(over_mf(0.01 * s).inertia[0], WithinRel(4.062e-5, 1e-3));
}

TEST_CASE("the added inertia passes smoothly through equal axes") {
  // J_x/m_f = 1/5 (b^2-c^2)^2 D_bc/(A + 2 (B - c^2 D_bc)) with D_bc and the denominator smooth in b: for
  // c = b (1+h) it is h^2 times a function whose relative slope is of order 1.
  for (const double a : {0.001, 1.0, 100.0}) {
    const auto J_over_h2 = [&](double h) { return over_mf({a, 1.0, 1.0 + h}).inertia[0] / (h * h); };
    const double limit = J_over_h2(1e-3);
    for (const double h : {1e-4, -1e-4, 1e-6, 1e-8, -1e-10}) {
      // 1 + h itself is rounded: h has a relative error of eps/h.
      CHECK_THAT(J_over_h2(h), WithinRel(limit, 4e-3 + 4e-16 / std::abs(h)));
    }
  }
}

TEST_CASE("the scalar of the added mass carries derivatives by the semi-axes") {
  using Jet = Dual<double, 3>;
  const auto values = [](const Vector3d& s) {
    Eigen::Matrix<double, 6, 1> K;
    added_mass::ellipsoid_added_mass(s[0], s[1], s[2], K.data(), K.data() + 3);
    return K;
  };
  for (const Vector3d& s : {Vector3d(4, 2, 1), Vector3d(7.3, 4.2, 0.03), Vector3d(0.5, 1, 1),
                            Vector3d(1, 1, 1), Vector3d(1, 1.0005, 0.01), Vector3d(0.1, 10, 2)}) {
    INFO(s.transpose());
    Jet K[6];
    added_mass::ellipsoid_added_mass(Jet(s[0], 0), Jet(s[1], 1), Jet(s[2], 2), K, K + 3);
    const auto plain = values(s);
    for (int i = 0; i < 3; ++i) {
      // Central differences of sixth order: truncation h^6 and round-off eps/h relative to value/semi-axis,
      // h = 3e-3 of the axis.
      const auto at = [&](int n) {
        Vector3d moved = s;
        moved[i] *= 1.0 + 3e-3 * n;
        return values(moved);
      };
      const auto difference =
          ((45.0 * (at(1) - at(-1)) - 9.0 * (at(2) - at(-2)) + (at(3) - at(-3))) / (60.0 * 3e-3 * s[i]))
              .eval();
      for (int k = 0; k < 6; ++k) {
        CHECK_THAT(K[k].a, WithinAbs(plain[k], 1e-15 * std::abs(plain[k])));
        CHECK_THAT(K[k].v[i], WithinAbs(difference[k],
                                        1e-10 * (plain[k] + s.squaredNorm() * (k < 3 ? 0.0 : 1.0)) / s[i]));
      }
    }
  }
}

TEST_CASE("the added mass of an ellipsoid as a matrix is diagonal, linear motions first") {
  const DiagonalAddedMass K = ellipsoid_added_mass({3, 2, 1}, 1000.0);
  CHECK(K.matrix().diagonal().head<3>() == K.mass);
  CHECK(K.matrix().diagonal().tail<3>() == K.inertia);
  CHECK(K.matrix().isDiagonal());
}

TEST_CASE("ellipsoids without extent and fluids without density are refused by name") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(ellipsoid_added_mass({1, 0, 1}, 1.0), Contains("semi-axis b [m] is 0"));
  CHECK_THROWS_WITH(ellipsoid_added_mass({1, 1, -2}, 1.0), Contains("semi-axis c [m] is -2"));
  CHECK_THROWS_WITH(ellipsoid_shape_integrals({nan, 1, 1}), Contains("semi-axis a [m] is nan"));
  CHECK_THROWS_AS(ellipsoid_added_mass({1, 1, 1}, 0.0), samara::ArgumentError);
  CHECK_THROWS_AS(ellipsoid_added_mass({1, 1, 1}, std::numeric_limits<double>::infinity()),
                  samara::ArgumentError);
}

TEST_CASE("axes that leave the range of doubles are refused, not answered with infinities") {
  for (const Eigen::Vector3d& axes : {Eigen::Vector3d(1.0, 1.0, 1e-300), Eigen::Vector3d(1.0, 1e-150, 1e-300),
                                      Eigen::Vector3d(1e160, 1.0, 1.0)}) {
    CHECK_THROWS_WITH(samara::models::ellipsoid_added_mass(axes, 1.2), Catch::Contains("range of doubles"));
  }
}

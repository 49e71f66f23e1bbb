#include <catch2/catch.hpp>

#include "bodies_in_flow.h"
#include "samara/base/errors.h"
#include "samara/models/added_mass/reference_point.h"
#include "samara/models/bodies/kirchhoff_parameters.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

using Values = std::map<std::string, double>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kFluidMass = 33.510321638291124;  // 4/3 pi 4 2 1

/// The check problem: ellipsoid 4:2:1 of density 2 in a fluid of density 1, u = w = (1, 1, 1).
KirchhoffBodyData ellipsoid_421() {
  KirchhoffBodyData body;
  body.mass = 2.0 * kFluidMass;
  body.displaced_mass = kFluidMass;
  body.inertia = (body.mass / 5.0 * Eigen::Vector3d(5.0, 17.0, 20.0)).asDiagonal();
  Eigen::Matrix<double, 6, 1> added;
  added << 0.12657071758692307, 0.39817213373437774, 1.5180612775507823, 0.40619816083618723,
      3.3137263923705189, 0.58072194276019189;
  body.added_mass = (kFluidMass * added).asDiagonal();
  return body;
}

BodyState all_ones() {
  BodyState start;
  start.u = {1.0, 1.0, 1.0};
  start.w = {1.0, 1.0, 1.0};
  return start;
}

Values without_gravity(const KirchhoffBodyData& body) {
  Values values = kirchhoff_parameters(body);
  values["g"] = 0.0;
  return values;
}

Matrix6 total_inertia(const KirchhoffBodyData& body) {
  const Eigen::Matrix3d r = cross_matrix(body.centre_of_mass);
  Matrix6 matrix = body.added_mass;
  matrix.topLeftCorner<3, 3>() += body.mass * Eigen::Matrix3d::Identity();
  matrix.topRightCorner<3, 3>() -= body.mass * r;
  matrix.bottomLeftCorner<3, 3>() += body.mass * r;
  matrix.bottomRightCorner<3, 3>() += body.inertia - body.mass * r * r;
  return matrix;
}

struct Invariants {
  double energy, P_squared, P_dot_L;
  Eigen::Vector3d world_P, world_L;
};

Invariants invariants(const Matrix6& inertia, const BodyState& state) {
  Eigen::Matrix<double, 6, 1> v;
  v << state.u, state.w;
  const Eigen::Matrix<double, 6, 1> momentum = inertia * v;
  const Eigen::Vector3d P = momentum.head<3>();
  const Eigen::Vector3d L = momentum.tail<3>();
  const Eigen::Vector3d world_P = state.R() * P;
  return {0.5 * v.dot(momentum), P.squaredNorm(), P.dot(L), world_P,
          state.R() * L + state.position.cross(world_P)};
}

void check_conserved(const Invariants& before, const Invariants& after, double relative) {
  CHECK_THAT(after.energy, WithinRel(before.energy, relative));
  CHECK_THAT(after.P_squared, WithinRel(before.P_squared, relative));
  CHECK_THAT(after.P_dot_L, WithinRel(before.P_dot_L, relative));
  CHECK((after.world_P - before.world_P).norm() < relative * before.world_P.norm());
  CHECK((after.world_L - before.world_L).norm() < relative * before.world_L.norm());
}

/// A symmetric positive definite matrix without zeros, of the size of the body's inertia.
Matrix6 random_added_mass(std::mt19937& random, double size) {
  std::normal_distribution<double> normal;
  Matrix6 root;
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = normal(random);
  return size / 6.0 * root * root.transpose();
}

/// The data of the body about the point `r` of it.
KirchhoffBodyData about(const KirchhoffBodyData& body, const Eigen::Vector3d& r) {
  KirchhoffBodyData moved = body;
  moved.centre_of_mass -= r;
  moved.centre_of_buoyancy -= r;
  moved.added_mass = added_mass_about(body.added_mass, r);
  return moved;
}

}  // namespace

TEST_CASE("the Kirchhoff check problem has its published invariants and states, and conserves them") {
  const KirchhoffBodyData body = ellipsoid_421();
  const Matrix6 inertia = total_inertia(body);
  const Invariants start = invariants(inertia, all_ones());
  CHECK_THAT(start.energy, WithinRel(488.3032020440, 1e-12));
  CHECK_THAT(start.P_squared, WithinRel(25434.951644526, 1e-13));
  CHECK_THAT(start.P_dot_L, WithinRel(66881.184358071, 1e-13));
  CHECK((start.world_P - Eigen::Vector3d(71.26206873, 80.36351955, 117.89136495)).norm() < 2e-8);
  CHECK((start.world_L - Eigen::Vector3d(80.6324743, 338.91422437, 287.54275219)).norm() < 2e-7);

  std::vector<double> times;
  for (int k = 1; k <= 20; ++k) times.push_back(0.5 * k);
  const Eigen::MatrixXd states =
      motion(find_model("kirchhoff_body"), without_gravity(body), all_ones(), times, 1e-13);
  const BodyState one(states.row(1));
  CHECK((one.u - Eigen::Vector3d(-0.02619392, 1.86850287, 0.45549713)).norm() < 1e-8);
  CHECK((one.w - Eigen::Vector3d(0.81178935, 1.34751761, -0.1018983)).norm() < 1e-8);
  const BodyState ten(states.row(19));
  CHECK((ten.u - Eigen::Vector3d(-1.00957568, 1.30092497, 0.81928126)).norm() < 2e-8);
  CHECK((ten.w - Eigen::Vector3d(-0.61312995, 1.23152154, 0.70891937)).norm() < 2e-8);
  for (Eigen::Index k = 0; k < states.rows(); ++k) {
    check_conserved(start, invariants(inertia, BodyState(states.row(k))), 1e-10);
  }
}

TEST_CASE("the printed form (4.4) does not conserve energy") {
  // (4.4) as printed, M u' + u x (M w) = 0 for M u' + w x (M u) = 0; rotation as in (5.13). RK4, h = 1e-3.
  const Eigen::Vector3d M =
      kFluidMass * Eigen::Vector3d(2.12657071758692307, 2.39817213373437774, 3.5180612775507823);
  const Eigen::Vector3d J =
      kFluidMass * Eigen::Vector3d(2.40619816083618723, 10.1137263923705189, 8.58072194276019189);
  using Rates = Eigen::Matrix<double, 6, 1>;
  const auto printed = [&](const Rates& v) {
    const Eigen::Vector3d u = v.head<3>();
    const Eigen::Vector3d w = v.tail<3>();
    Rates rate;
    rate << (-u.cross(M.cwiseProduct(w))).cwiseQuotient(M),
        (J.cwiseProduct(w).cross(w) + M.cwiseProduct(u).cross(u)).cwiseQuotient(J);
    return rate;
  };
  Rates v = Rates::Ones();
  std::vector<double> energies;
  const double h = 1e-3;
  for (int step = 0; step <= 2000; ++step) {
    if (step == 0 || step == 500 || step == 1000 || step == 2000) {
      energies.push_back(0.5 * (v.head<3>().dot(M.cwiseProduct(v.head<3>())) +
                                v.tail<3>().dot(J.cwiseProduct(v.tail<3>()))));
    }
    const Rates k1 = printed(v);
    const Rates k2 = printed(v + h / 2.0 * k1);
    const Rates k3 = printed(v + h / 2.0 * k2);
    const Rates k4 = printed(v + h * k3);
    v += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  CHECK_THAT(energies[0], WithinAbs(488.303, 5e-4));
  CHECK_THAT(energies[1], WithinAbs(490.009, 1e-3));
  CHECK_THAT(energies[2], WithinAbs(506.876, 1e-3));
  CHECK_THAT(energies[3], WithinAbs(496.575, 1e-3));
}

TEST_CASE("a body of any added mass conserves energy and both impulses") {
  std::mt19937 random(31);
  for (int k = 0; k < 5; ++k) {
    KirchhoffBodyData body;
    body.mass = 2.0;
    body.inertia = random_added_mass(random, 1.0).topLeftCorner<3, 3>();
    body.centre_of_mass = random_vector(random, 0.3);
    body.added_mass = random_added_mass(random, 2.0);
    BodyState start;
    start.position = random_vector(random, 1.0);
    start.q = random_attitude(random);
    start.u = random_vector(random, 1.0);
    start.w = random_vector(random, 1.0);
    const Matrix6 inertia = total_inertia(body);
    const Eigen::MatrixXd states =
        motion(find_model("kirchhoff_body"), without_gravity(body), start, {1.0, 5.0}, 1e-13);
    for (Eigen::Index row = 0; row < states.rows(); ++row) {
      check_conserved(invariants(inertia, start), invariants(inertia, BodyState(states.row(row))), 1e-9);
    }
    const auto model = find_model("kirchhoff_body");
    const ParameterValues p = parameter_values(*model, without_gravity(body));
    CHECK_THAT(*model->kinetic_energy(0.0, start.vector(), p),
               WithinRel(invariants(inertia, start).energy, 1e-13));
  }
}

TEST_CASE("moving the reference point leaves the motion as it is") {
  std::mt19937 random(37);
  KirchhoffBodyData body = ellipsoid_421();
  body.mass /= kFluidMass;
  body.displaced_mass = 1.0;
  body.inertia /= kFluidMass;
  body.added_mass = random_added_mass(random, 1.0);
  body.centre_of_buoyancy = {0.1, 0.0, 0.2};
  BodyState start;
  start.q = random_attitude(random);
  start.u = random_vector(random, 1.0);
  start.w = random_vector(random, 1.0);
  const Eigen::Vector3d r(0.3, -0.5, 0.2);
  BodyState moved = start;
  moved.position += start.R() * r;
  moved.u += start.w.cross(r);
  const std::vector<double> times = {0.5, 1.0, 2.0};
  const auto model = find_model("kirchhoff_body");
  const Eigen::MatrixXd first = motion(model, kirchhoff_parameters(body), start, times);
  const Eigen::MatrixXd second = motion(model, kirchhoff_parameters(about(body, r)), moved, times);
  for (Eigen::Index row = 0; row < first.rows(); ++row) {
    const BodyState a(first.row(row));
    const BodyState b(second.row(row));
    CHECK((a.position + a.R() * r - b.position).norm() < 1e-8 * (1.0 + a.position.norm()));
    CHECK((a.R() - b.R()).norm() < 1e-8);
    CHECK((a.w - b.w).norm() < 1e-8 * (1.0 + a.w.norm()));
  }
}

TEST_CASE("the added mass about another point is that about the first, and back") {
  std::mt19937 random(41);
  const Matrix6 K = random_added_mass(random, 1.0);
  const Eigen::Vector3d r(0.3, -0.5, 0.2);
  CHECK((added_mass_about(added_mass_about(K, r), -r) - K).norm() < 1e-14 * K.norm());
  // A sphere: K = m_a on the velocity of its centre, so about r from the centre (u, w) -> m_a |u + r x w|^2.
  Matrix6 sphere = Matrix6::Zero();
  sphere.topLeftCorner<3, 3>() = 0.5 * Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 6, 1> v;
  v << 0.1, 0.2, -0.4, 1.0, 2.0, 3.0;
  const Eigen::Vector3d centre = v.head<3>() + r.cross(v.tail<3>());
  CHECK_THAT(v.dot(added_mass_about(sphere, r) * v), WithinRel(0.5 * centre.squaredNorm(), 1e-14));
}

TEST_CASE("under gravity the sum of energies is conserved, and the terms sum to the rate of momentum") {
  const KirchhoffBodyData body = [] {
    KirchhoffBodyData data = ellipsoid_421();
    data.centre_of_mass = {0.1, 0.2, -0.1};
    data.centre_of_buoyancy = {0.0, -0.1, 0.3};
    return data;
  }();
  const auto model = find_model("kirchhoff_body");
  const ParameterValues p = parameter_values(*model, kirchhoff_parameters(body));
  const auto energy = [&](const BodyState& state) {
    const double height_c = (state.position + state.R() * body.centre_of_mass).z();
    const double height_b = (state.position + state.R() * body.centre_of_buoyancy).z();
    return *model->kinetic_energy(0.0, state.vector(), p) +
           9.81 * (body.mass * height_c - body.displaced_mass * height_b);
  };
  const Eigen::MatrixXd states = motion(model, kirchhoff_parameters(body), all_ones(), {1.0, 3.0});
  const double fallen = 9.81 * kFluidMass * std::abs(states(1, 2));
  for (Eigen::Index k = 0; k < 2; ++k) {
    CHECK_THAT(energy(BodyState(states.row(k))), WithinAbs(energy(all_ones()), 1e-8 * fallen));
  }

  std::vector<double> f(13);
  const std::vector<double> x = all_ones().vector();
  model->rhs(0.0, x, p, f);
  std::vector<Wrench> terms(2);
  model->forces(0.0, x, p, terms);
  Eigen::Matrix<double, 6, 1> sum, rate;
  sum << terms[0].force + terms[1].force, terms[0].torque + terms[1].torque;
  for (int i = 0; i < 6; ++i) rate[i] = f[static_cast<std::size_t>(7 + i)];
  CHECK((total_inertia(body) * rate - sum).norm() < 1e-13 * sum.norm());
}

TEST_CASE("a heavy body with its weight below swings about the vertical and never turns over") {
  KirchhoffBodyData body = ellipsoid_421();
  body.mass = body.displaced_mass;
  body.centre_of_buoyancy = {0.0, 0.0, 0.2};
  BodyState start;
  start.q = Eigen::AngleAxisd(0.2, Eigen::Vector3d(1.0, 1.0, 0.0).normalized());
  std::vector<double> times;
  for (int k = 1; k <= 200; ++k) times.push_back(0.1 * k);
  for (const double side : {1.0, -1.0}) {
    body.centre_of_buoyancy.z() = 0.2 * side;
    const Eigen::MatrixXd states =
        motion(find_model("kirchhoff_body"), kirchhoff_parameters(body), start, times, 1e-9);
    double least_up = 1.0;
    for (Eigen::Index k = 0; k < states.rows(); ++k) {
      least_up = std::min(least_up, BodyState(states.row(k)).R()(2, 2));
    }
    if (side > 0.0) {
      CHECK(least_up > std::cos(0.2) - 1e-6);
    } else {
      CHECK(least_up < -0.5);
    }
  }
}

TEST_CASE("without added mass and fluid a body falls freely about its centre of mass") {
  KirchhoffBodyData body;
  body.mass = 0.3;
  body.inertia = Eigen::Vector3d(0.01, 0.02, 0.025).asDiagonal();
  body.centre_of_mass = {0.1, -0.2, 0.05};
  BodyState start = all_ones();
  const BodyState end(motion(find_model("kirchhoff_body"), kirchhoff_parameters(body), start, {0.7}).row(0));
  const Eigen::Vector3d velocity = start.u + start.w.cross(body.centre_of_mass);
  const Eigen::Vector3d centre =
      body.centre_of_mass + 0.7 * velocity + Eigen::Vector3d(0.0, 0.0, -0.5 * 9.81 * 0.49);
  CHECK((end.position + end.R() * body.centre_of_mass - centre).norm() < 1e-9);
}

TEST_CASE("the immersed body without forces of the flow is the Kirchhoff body") {
  const Values ellipsoid = {
      {"a", 4.0},    {"b", 2.0},     {"c", 1.0},   {"density", 2.0}, {"fluid_density", 1.0},
      {"C_D0", 0.0}, {"C_D90", 0.0}, {"C_T", 0.0}, {"C_R", 0.0},     {"C_w", 0.0}};
  const Eigen::MatrixXd quasi_steady = motion(find_model("immersed_body"), ellipsoid, all_ones(), {1.0});
  const Eigen::MatrixXd kirchhoff =
      motion(find_model("kirchhoff_body"), kirchhoff_parameters(ellipsoid_421()), all_ones(), {1.0});
  CHECK((quasi_steady - kirchhoff).norm() < 1e-8);
}

TEST_CASE("data that make no body are refused") {
  KirchhoffBodyData body = ellipsoid_421();
  body.mass = 0.0;
  CHECK_THROWS_WITH(kirchhoff_parameters(body),
                    "the mass of the Kirchhoff body is 0; a positive finite number was expected");
  body = ellipsoid_421();
  body.displaced_mass = -1.0;
  CHECK_THROWS_AS(kirchhoff_parameters(body), samara::ArgumentError);
  body = ellipsoid_421();
  body.added_mass(2, 2) = -1e6;
  CHECK_THROWS_WITH(kirchhoff_parameters(body),
                    "the inertia of the Kirchhoff body, added mass included, is not positive definite");
  body.added_mass(2, 2) = std::nan("");
  CHECK_THROWS_AS(kirchhoff_parameters(body), samara::ArgumentError);
}

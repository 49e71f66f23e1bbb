#include "printed_equations.h"

#include <random>

#include <catch2/catch.hpp>

#include "samara/models/interface/model.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;
using printed::Equations;
using printed::Quantity;

namespace {

/// Of a model: the names of its states and parameters with a value each.
struct Point {
  std::vector<double> x;
  ParameterValues p;
};

double drawn(std::mt19937& random, double lower, double upper) {
  return std::uniform_real_distribution<double>(lower, upper)(random);
}

/// All parameters given, floors as large as everything else. Those that may be negative shrink until the
/// model accepts them all.
Point random_point(const Model& model, std::mt19937& random) {
  const ModelInfo& info = model.info();
  Point point;
  point.p.given.assign(info.parameters.size(), 1);
  for (double spread = 1.5;; spread *= 0.9) {
    REQUIRE(spread > 1e-6);
    point.p.value.clear();
    for (const ParameterInfo& parameter : info.parameters) {
      const bool is_signed = parameter.lower < 0.0;
      const double upper = std::min(parameter.upper, 2.0);
      point.p.value.push_back(is_signed ? drawn(random, -spread, spread) : drawn(random, 0.3 * upper, upper));
    }
    if (model.problem(point.p).empty()) break;
  }
  for (std::size_t i = 0; i < info.states.size(); ++i) point.x.push_back(drawn(random, -1.5, 1.5));
  for (const StateGroup& group : info.groups) {
    if (group.kind != StateGroupKind::quaternion) continue;
    Eigen::Map<Eigen::Vector4d> q(point.x.data() + group.first);
    q.normalize();
  }
  return point;
}

Eigen::MatrixXd crossing(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Quantity constant(const Eigen::MatrixXd& m) {
  return {m, Eigen::MatrixXd::Zero(m.rows(), m.cols())};
}

/// The turn of a quaternion, which is quadratic in it.
Quantity turn(Equations& e) {
  const auto q = [&](const char* name) { return e.lookup(name); };
  const Quantity all = printed::column({q("qw"), q("qx"), q("qy"), q("qz")});
  const auto matrix = [](const Eigen::Vector4d& a) -> Eigen::MatrixXd {
    return Eigen::Quaterniond(a[0], a[1], a[2], a[3]).toRotationMatrix() +
           (a.squaredNorm() - 1.0) * Eigen::Matrix3d::Identity();
  };
  const Eigen::Vector4d a = all.value, b = all.rate;
  return {matrix(a), 0.5 * (matrix(a + b) - matrix(a - b))};
}

printed::Supplied diagonal(const std::string& name) {
  return [name](Equations& e) {
    Eigen::Vector3d entries;
    for (int k = 0; k < 3; ++k) entries[k] = e.lookup(name + "_" + "xyz"[k]).number();
    return constant(entries.asDiagonal());
  };
}

/// Of a mass at a place with moments of inertia about the origin.
Eigen::MatrixXd inertia_of(double mass, const Eigen::Vector3d& place, const Eigen::Matrix3d& about_origin) {
  Eigen::MatrixXd m(6, 6);
  m << mass * Eigen::Matrix3d::Identity(), -mass * crossing(place), mass * crossing(place), about_origin;
  return m;
}

Eigen::Matrix3d of_point(double mass, const Eigen::Vector3d& place) {
  return -mass * crossing(place) * crossing(place);
}

/// What a text says in words: clauses as they stand there, and what they mean.
struct Words {
  std::set<std::string> prose = {};
  std::map<std::string, printed::Supplied> supplied = {};
};

const std::map<std::string, printed::Supplied> kEllipsoid = {
    {"R", turn}, {"M", diagonal("M")}, {"I", diagonal("I")}, {"J", diagonal("J")}};

Words in_ambient_flow(const printed::Supplied& material_rate, const printed::Supplied& gradient) {
  Words words{
      {"dw_air/dt along the path of the body, Dw_air/Dt along that of the fluid, W the gradient of w_air"},
      kEllipsoid};
  words.supplied["Dw_air/Dt"] = material_rate;
  words.supplied["W"] = gradient;
  return words;
}

Quantity symmetric_K(Equations& e) {
  Eigen::MatrixXd K(6, 6);
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      K(i, j) = K(j, i) = e.lookup("K_" + std::to_string(i + 1) + std::to_string(j + 1)).number();
    }
  }
  return constant(K);
}

Quantity kirchhoff_mass(Equations& e) {
  const auto at = [&](const char* name) { return e.lookup(name).number(); };
  Eigen::Matrix3d inertia;
  inertia << at("I_xx"), at("I_xy"), at("I_xz"), at("I_xy"), at("I_yy"), at("I_yz"), at("I_xz"), at("I_yz"),
      at("I_zz");
  const Eigen::Vector3d centre = e.lookup("r_c").value;
  return constant(inertia_of(at("mass"), centre, inertia + of_point(at("mass"), centre)));
}

Quantity mass_with_offset(Equations& e) {
  const double mass = e.lookup("mass").number(), offset_mass = e.lookup("offset_mass").number();
  const Eigen::Vector3d offset = e.lookup("offset").value;
  return constant(inertia_of(mass, e.lookup("r_c").value, diagonal("I")(e).value) +
                  inertia_of(offset_mass, offset, of_point(offset_mass, offset)));
}

Quantity axes_of_flow(Equations& e) {
  return constant((Eigen::AngleAxisd(-e.lookup("alpha").number(), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(e.lookup("beta").number(), Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix());
}

Quantity turned_spin(Equations& e) {
  const Eigen::Vector3d axis = e.lookup("spin_frame").value;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
  const auto state = [&](const char* name) { return e.lookup(name); };
  const Quantity w = printed::column({state("wx"), state("wy"), state("wz")});
  return {R * w.value, R * w.rate};
}

Quantity rate_of_linear_wind(Equations& e) {
  const double up = e.lookup("wind_z").number();
  return constant(Eigen::Vector3d(up * e.lookup("shear_x").number(), up * e.lookup("shear_y").number(), 0.0));
}

Quantity gradient_of_linear_wind(Equations& e) {
  Eigen::Matrix3d W = Eigen::Matrix3d::Zero();
  W.col(2) << e.lookup("shear_x").number(), e.lookup("shear_y").number(), 0.0;
  return constant(W);
}

/// Rates are taken at t = 0.
Quantity time_itself(Equations&) {
  return {0.0, 1.0};
}

Quantity gradient_of_gust(Equations& e) {
  Eigen::Matrix3d W;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      W(i, j) = e.lookup(std::string("gust_gradient_") + "xyz"[i] + "xyz"[j]).number();
  }
  return constant(W);
}

/// What gusts in space say in words.
void add_gust(Words& words) {
  words.prose.insert("W has the rows (gust_gradient_xx, gust_gradient_xy, gust_gradient_xz) and so on");
  words.supplied["W"] = gradient_of_gust;
  words.supplied["t"] = time_itself;
}

/// A change of these clauses must be followed by a change here.
Words words_of(const std::string& model) {
  if (model == "immersed_body") {
    return in_ambient_flow([](Equations&) { return constant(Eigen::Vector3d::Zero()); },
                           [](Equations&) { return constant(Eigen::Matrix3d::Zero()); });
  }
  if (model == "immersed_body_in_wind") return in_ambient_flow(rate_of_linear_wind, gradient_of_linear_wind);
  if (model == "immersed_body_in_gusts") {
    const std::string material_rate = "(gust_rate_x, gust_rate_y, gust_rate_z) - W R u_r";
    Words words = in_ambient_flow([=](Equations& e) { return e.evaluate(material_rate); }, {});
    words.prose.insert("Dw_air/Dt is " + material_rate);
    add_gust(words);
    return words;
  }
  if (model == "falling_plate_in_gusts") return {{}, {{"t", time_itself}}};
  if (model == "sphere_flight_in_gusts" || model == "coefficient_body_in_gusts" ||
      model == "kirchhoff_body_in_gusts") {
    Words words = words_of(model.substr(0, model.find("_in_gusts")));
    add_gust(words);
    return words;
  }
  if (model == "immersed_body_with_wake") return {{}, kEllipsoid};
  if (model == "kirchhoff_body") return {{}, {{"R", turn}, {"K", symmetric_K}, {"M_body", kirchhoff_mass}}};
  if (model == "coefficient_body") {
    return {{"E: the axes of flow, body x, y, z turned by beta about z, then by -alpha about y"},
            {{"R", turn}, {"E", axes_of_flow}, {"M_body", mass_with_offset}}};
  }
  if (model == "sphere_flight_turned_spin") {
    // The turn is constant, so that w' = -spin_decay w holds for the turned spin too.
    return {{"everywhere but in w': R w for w, R the turn by (spin_frame_x, spin_frame_y, spin_frame_z)"},
            {{"w", turned_spin}}};
  }
  return {};
}

Equations equations_of(const ModelInfo& info) {
  const Words words = words_of(info.name);
  Equations equations(info.equations, words.prose);
  for (const auto& [symbol, supplied] : words.supplied) equations.supply(symbol, supplied);
  return equations;
}

void set_parameters(Equations& equations, const ModelInfo& info, const std::vector<double>& values) {
  for (std::size_t k = 0; k < values.size(); ++k) equations.set(info.parameters[k].name, values[k]);
}

/// Largest difference between the sides of an equation, over their size.
double violation(Equations& equations, const ModelInfo& info, const Point& point,
                 const std::vector<double>& dxdt) {
  for (std::size_t i = 0; i < point.x.size(); ++i) equations.set(info.states[i].name, {point.x[i], dxdt[i]});
  double worst = 0.0;
  for (const auto& [left, right] : equations.motion()) {
    const double size = left.value.norm() + right.value.norm();
    if (size > 0.0) worst = std::max(worst, (left.value - right.value).norm() / size);
  }
  return worst;
}

}  // namespace

TEST_CASE("every model computes the equations that it prints") {
  for (const std::string& name : model_names()) {
    const auto model = find_model(name);
    const ModelInfo& info = model->info();
    Equations equations = equations_of(info);
    std::mt19937 random(1);
    INFO(name);
    for (int k = 0; k < 50; ++k) {
      const Point point = random_point(*model, random);
      std::vector<double> dxdt(point.x.size());
      model->rhs(0.0, point.x, point.p, dxdt);
      set_parameters(equations, info, point.p.value);
      // Round-off, where the terms of an equation cancel to a hundredth.
      CHECK(violation(equations, info, point, dxdt) < 1e-12);
      // And they say what every state does: another rate of any one of them violates them.
      for (std::size_t i = 0; i < dxdt.size(); ++i) {
        std::vector<double> other = dxdt;
        other[i] += 0.1 * (1.0 + std::abs(dxdt[i]));
        INFO(info.states[i].name);
        CHECK(violation(equations, info, point, other) > 1e-6);
      }
    }
  }
}

TEST_CASE("every default that follows from other parameters is what its formula says") {
  const std::set<std::string> in_words = {
      "that of an ellipsoid, 4/3 pi fluid_density a b c A/(2 - A) and so on",
      "that of an ellipsoid, dissertation (5.11) corrected"};
  int compared = 0;
  for (const std::string& name : model_names()) {
    const auto model = find_model(name);
    const ModelInfo& info = model->info();
    std::mt19937 random(2);
    for (int k = 0; k < 10; ++k) {
      Point point = random_point(*model, random);
      for (std::size_t i = 0; i < info.parameters.size(); ++i) {
        const std::string& formula = info.parameters[i].derived;
        if (formula.empty() || in_words.contains(formula)) continue;
        INFO(name << ": " << info.parameters[i].name << " = " << formula);
        point.p.given[i] = 0;
        Equations equations = equations_of(info);
        set_parameters(equations, info, point.p.value);
        CHECK(model->completed(point.p)[i] == Approx(equations.evaluate(formula).number()).epsilon(1e-12));
        point.p.given[i] = 1;
        ++compared;
      }
    }
  }
  CHECK(compared > 100);
}

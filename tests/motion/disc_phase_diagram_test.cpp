// The measured phase diagram.
#include "samara/motion/patterns/disc_phase_diagram.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "samara/io/delimited_table.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/records/motion_record.h"
#include "tests/error_text.h"
#include "tests/identification/measured_data.h"

using namespace samara::motion;

TEST_CASE("discs fall as the diagram has them in the middle of its regimes") {
  CHECK(regime(40.0, 1e-3).regime == Regime::steady);
  CHECK(regime(2000.0, 1e-3).regime == Regime::periodic);
  CHECK(regime(2000.0, 0.02).regime == Regime::chaotic);
  CHECK(regime(2000.0, 0.2).regime == Regime::tumbling);
  CHECK_FALSE(regime(1e6, 1e-3).measured);
  CHECK(regime(2000.0, 1e-3).measured);
}

TEST_CASE("the distance to the next boundary is where the answer changes") {
  for (const double Re : {50.0, 120.0, 300.0, 3000.0, 20000.0}) {
    for (const double I : {5e-4, 5e-3, 0.012, 0.03, 0.1}) {
      INFO("Re " << Re << ", I* " << I);
      const RegimeAnswer here = regime(Re, I);
      bool changes = false;
      for (int k = 0; k < 720; ++k) {
        const double angle = k * 3.14159265358979 / 360.0;
        const auto at = [&](double distance) {
          return regime(Re * std::exp(distance * std::cos(angle)), I * std::exp(distance * std::sin(angle)))
              .regime;
        };
        CHECK(at(0.99 * here.distance) == here.regime);
        changes = changes || at(1.01 * here.distance + 1e-4) == here.beyond;
      }
      CHECK(changes);
      CHECK(here.beyond != here.regime);
    }
  }
}

TEST_CASE("what is periodic borders on tumbling from the lowest tumbling disc up") {
  for (const double I : {0.038, 0.045, 0.056}) {
    const RegimeAnswer above = regime(156.0, I), below = regime(154.0, I);
    CHECK(above.beyond == Regime::periodic);
    CHECK(above.distance < 0.01);
    CHECK(below.beyond == Regime::tumbling);
    CHECK(below.distance < 0.01);
  }
}

TEST_CASE("97 of 100 measured discs lie on the right side of the boundaries, the others near one") {
  const auto folder = measured_data("disk-phase-diagram-field1997");
  if (folder.empty()) return;
  const auto table = samara::io::DelimitedTable::read(folder / "points.csv");
  const auto series = table.texts("series");
  const Eigen::VectorXd Re = table.numbers("re"), I = table.numbers("istar"), code = table.numbers("code");
  int right = 0, all = 0;
  for (std::size_t k = 0; k < table.rows(); ++k) {
    if (series[k].starts_with("l")) continue;
    const auto n = static_cast<Eigen::Index>(k);
    const RegimeAnswer answer = regime(Re[n], I[n]);
    ++all;
    if (static_cast<int>(answer.regime) + 1 == static_cast<int>(code[n])) {
      ++right;
    } else {
      CHECK(answer.distance < 0.15);
    }
  }
  CHECK(all == 347);
  CHECK(right >= 0.97 * all);
}

TEST_CASE("a body's numbers are those of the model sheet, and all three I* are told apart") {
  const samara::models::ParametricModel disc(samara::models::find_model("immersed_body"),
                                             {{"a", 0.01},
                                              {"b", 0.01},
                                              {"c", 0.00075},
                                              {"density", 2700.0},
                                              {"fluid_density", 1000.0},
                                              {"nu", 1e-6}},
                                             {});
  const FallNumbers n = fall_numbers(disc.model(), disc.parameters({}));
  CHECK(n.I_disc == Approx(0.009940195505498954));
  CHECK(n.Re == Approx(3163.26).epsilon(1e-5));
  CHECK(n.I_ellipse == Approx(2.7 * 0.075));
  CHECK(n.I_plate > 5.0 * n.I_disc);
  // One length of a body, whatever the model says of it: here the area of a coin.
  const samara::models::ParametricModel coin(
      samara::models::find_model("vertical_fall"),
      {{"area", 4.7e-4}, {"thickness", 2.55e-3}, {"density", 6338.6}, {"C_D", 1.2}}, {});
  CHECK(fall_numbers(coin.model(), coin.parameters({})).length ==
        Approx(2.0 * std::sqrt(4.7e-4 / std::numbers::pi)));
  CHECK(MotionStates::body_length(coin.model(), coin.parameters({})) ==
        fall_numbers(coin.model(), coin.parameters({})).length);
  CHECK(error_text<samara::ArgumentError>([] {
          const auto model = samara::models::find_model("falling_plate_nd");
          fall_numbers(*model, samara::models::ParametricModel(model, {}, {}).parameters({}));
        }).find("model \"falling_plate_nd\" does not say length") == 0);
  CHECK(error_text<samara::ArgumentError>([] { regime(-1.0, 0.1); }).find("Re is -1") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([] { regime(100.0, NAN); }).find("I_disc is nan") !=
        std::string::npos);
}

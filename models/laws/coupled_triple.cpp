#include "samara/models/laws/law_model.h"

namespace samara::models::laws {

namespace {

struct CoupledTriple {
  static constexpr int kStates = 3;
  static constexpr int kParameters = 3;

  static ModelInfo info() {
    return {
        .name = "coupled_triple",
        .title = "Three rates coupled by products, like those of a turning body",
        .equations = "u1' = c1 - u2 u3,  u2' = c2 - u1 u3,  u3' = c3 - u1 u2",
        .frames = "none: dimensionless",
        .source = "dissertation, eq. (6.22): c = (1, 2, 3)",
        .validity = "exact; a test case with products of states. Some initial values blow up in finite time",
        .states = {{.name = "u1", .unit = "1", .description = "first state"},
                   {.name = "u2", .unit = "1", .description = "second state"},
                   {.name = "u3", .unit = "1", .description = "third state"}},
        .parameters = {{.name = "c1", .unit = "1", .default_value = 1.0, .description = "drive of u1"},
                       {.name = "c2", .unit = "1", .default_value = 2.0, .description = "drive of u2"},
                       {.name = "c3", .unit = "1", .default_value = 3.0, .description = "drive of u3"}},
        .affine_in = {"c1", "c2", "c3"},
    };
  }

  template <class S>
  static void rhs(const S&, const S* x, const S* p, S* dxdt) {
    dxdt[0] = p[0] - x[1] * x[2];
    dxdt[1] = p[1] - x[0] * x[2];
    dxdt[2] = p[2] - x[0] * x[1];
  }

  template <class S>
  static void complete(const char*, S*) {}

  static Scales scales(const double*) { return {}; }
};

}  // namespace

std::shared_ptr<const Model> coupled_triple() {
  return std::make_shared<LawModel<CoupledTriple>>();
}

}  // namespace samara::models::laws

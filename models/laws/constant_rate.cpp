#include "samara/models/laws/law_model.h"

namespace samara::models::laws {

namespace {

struct ConstantRate {
  static constexpr int kStates = 1;
  static constexpr int kParameters = 2;
  enum Parameter { kK, kRate };

  static ModelInfo info() {
    return {
        .name = "constant_rate",
        .title = "A rate that depends on a parameter alone",
        .equations = "k (u' + 1) = rate",
        .frames = "none: dimensionless",
        .source = "dissertation, eq. (6.18): k (u' + 1) = 10; exact solution u(0) + (rate/k - 1) t",
        .validity = "exact; a test case whose separated solution has rank one",
        .symmetries = {"translation of u"},
        .states = {{.name = "u", .unit = "1", .default_initial = 0.0, .description = "the state"}},
        .parameters =
            {
                {.name = "k", .unit = "1", .description = "divisor of the rate", .lower = 0.0},
                {.name = "rate",
                 .unit = "1",
                 .default_value = 10.0,
                 .description = "right-hand side of (6.18), which has 10"},
            },
    };
  }

  template <class S>
  static void rhs(const S&, const S*, const S* p, S* dxdt) {
    dxdt[0] = p[kRate] / p[kK] - S(1.0);
  }

  template <class S>
  static void complete(const char*, S*) {}

  static Scales scales(const double*) { return {}; }
};

}  // namespace

std::shared_ptr<const Model> constant_rate() {
  return std::make_shared<LawModel<ConstantRate>>();
}

}  // namespace samara::models::laws

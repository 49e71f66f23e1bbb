// A user's program: builds a small codebook, asks it, and compares with the exact solution.
#include <cmath>
#include <cstdio>

#include <samara/codebooks/build/build.h>
#include <samara/codebooks/file/save.h>
#include <samara/codebooks/query/query.h>
#include <samara/identification/fit/fit.h>

int main(int argc, char** argv) {
  const auto plan = samara::codebooks::parse_plan(
      "model = \"constant_rate\"\n[box]\nk = [1.0, 10.0]\n[time]\nend = 10.0\n[tolerance]\nrelative = 1e-9\n",
      "plan");
  const auto result = samara::codebooks::build(plan);
  samara::codebooks::Query query(result.book);
  Eigen::VectorXd u(1);
  const double point[] = {7.0, 4.0};  // t, k
  query.values(point, u);
  if (argc > 1) samara::codebooks::save(result.book, argv[1]);
  const double exact = (10.0 / 4.0 - 1.0) * 7.0;
  std::printf("u = %.15g, exact %.15g, fit: %s\n", u[0], exact,
              samara::identification::FitResult{}.message.c_str());
  return result.met && std::abs(u[0] - exact) < 1e-9 ? 0 : 1;
}

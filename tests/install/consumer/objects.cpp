// A user's program that is compiled for a machine of its own: Eigen's objects cross to the library and back,
// and each side changes and frees what the other has allocated.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include <samara/models/bodies/mesh_file.h>
#include <samara/models/integrators/integrate.h>
#include <samara/models/laws/registry.h>
#include <samara/pgd/fields/separated_field.h>

namespace {

int failures = 0;

void check(bool good, const char* what) {
  if (good) return;
  std::printf("wrong: %s\n", what);
  ++failures;
}

void integrate_and_change(int frames) {
  const samara::models::ParametricModel model(samara::models::find_model("constant_rate"), {}, {"k"});
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(frames, 0.0, 1.0);
  const double k = 4.0;
  samara::models::Trajectory trajectory =
      samara::models::integrate(model, {&k, 1}, {times.data(), static_cast<std::size_t>(frames)}, {}, true);
  check(std::abs(trajectory.states(frames - 1, 0) - 1.5) < 1e-8, "integrate()");
  trajectory.states.conservativeResize(2 * frames, 1);
  trajectory.states.bottomRows(frames) = trajectory.states.topRows(frames);
  trajectory.times = trajectory.times.head(frames / 2).eval();
  trajectory.sensitivities.emplace_back(Eigen::MatrixXd::Ones(frames, 3));
  check(std::abs(trajectory.states(2 * frames - 1, 0) - 1.5) < 1e-8, "what integrate() returned, resized");
}

void read_a_mesh(const std::string& folder) {
  const std::string path = folder + "/corner.obj";
  std::ofstream(path) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  samara::models::TriangleMesh mesh = samara::models::read_mesh(path, 1.0);
  check(mesh.vertices.cols() == 4 && mesh.triangles.cols() == 4, "read_mesh()");
  mesh.vertices.conservativeResize(3, 2);
  mesh.triangles.resize(3, 100);
}

/// Given away, and taken back.
void evaluate_a_field(int nodes, int terms) {
  using samara::pgd::Axis;
  std::vector<Axis> axes = {Axis::chebyshev({"x", "1", samara::pgd::AxisRole::parameter}, 0.0, 1.0, nodes),
                            Axis::chebyshev({"y", "1", samara::pgd::AxisRole::parameter}, 0.0, 1.0, nodes)};
  std::vector<Eigen::MatrixXd> factors(2, Eigen::MatrixXd::Ones(nodes, terms));
  Eigen::MatrixXd weights = Eigen::MatrixXd::Ones(1, terms);
  samara::pgd::SeparatedField field(std::move(axes), {{"u", "1"}}, std::move(factors), std::move(weights));
  const double point[] = {0.3, 0.7};
  Eigen::VectorXd value(1);
  samara::pgd::SeparatedField::Workspace workspace = field.make_workspace();
  field.evaluate(point, value, workspace);
  check(std::abs(value[0] - terms) < 1e-10 * terms, "a field");
  std::vector<Eigen::MatrixXd> copies = field.factors();
  for (Eigen::MatrixXd& copy : copies) copy.conservativeResize(nodes / 2, terms);
}

/// The program's own algebra still finds its blocks aligned as its instructions need them.
void multiply(int n) {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(n, n), b = Eigen::MatrixXd::Random(n, n);
  const Eigen::MatrixXd product = a * b;
  double worst = 0.0;
  for (int j = 0; j < n; ++j) worst = std::max(worst, std::abs(product(0, j) - a.row(0).dot(b.col(j))));
  check(worst < 1e-12 * n, "a product");
  const Eigen::VectorXd x = a.partialPivLu().solve(b.col(0));
  check((a * x - b.col(0)).norm() < 1e-6, "a linear system");
}

}  // namespace

int main(int argc, char** argv) {
  for (int n = 4; n < 60; n += 5) {
    integrate_and_change(n);
    evaluate_a_field(n, n);
    multiply(n);
  }
  multiply(300);  // in blocks on the heap
  if (argc > 1) read_a_mesh(argv[1]);
  std::printf("objects cross with %s\n", Eigen::SimdInstructionSetsInUse());
  return failures == 0 ? 0 : 1;
}

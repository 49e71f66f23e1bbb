// Asks the codebook of a falling plate (plate.toml): a point, its end for many coefficients, frames
// of a camera.
#include <cstdio>
#include <vector>

#include <samara/codebooks/file/load.h>
#include <samara/codebooks/query/query.h>
#include <samara/codebooks/query/trajectory_query.h>

using namespace samara::codebooks;

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const Codebook book = load(argv[1]);

  // All outputs at a point, and their derivatives by all coordinates.
  Query query(book);  // one per thread; copies share what was prepared
  Eigen::VectorXd values(book.output_count());
  Eigen::MatrixXd gradient(book.output_count(), book.coordinate_count());
  const std::vector<double> point = {5.0, 1.1, 2.7, 1.3};  // t, C_T, C_R, A
  query.values(point, values, gradient);
  const int y = book.output_index("y");
  std::printf("y = %.3f, dy/dC_T = %.2f\n", values[y], gradient(y, 1));

  // What is known before is paid for once: outputs, coordinates that are held.
  Query end(book,
            {.outputs = {"x", "y"}, .fixed = {{"t", 5.0}}, .precision = Precision::automatic});
  const Eigen::MatrixXd many = Eigen::Vector3d(1.1, 2.7, 1.3).replicate(1, 1000);  // C_T, C_R, A
  Eigen::MatrixXd places(2, 1000);
  end.batch(many, places, /*threads=*/2);
  std::printf("%d places, the last at y = %.3f\n", static_cast<int>(places.cols()), places(1, 999));

  // Frames of a camera, and what a fit to them asks for, row by row as Ceres wants it.
  const std::vector<double> times = {1.0, 2.0, 3.0, 4.0, 5.0};
  TrajectoryQuery frames(book, times, QueryOptions{.outputs = {"x", "y", "theta"}});
  const std::vector<double> q = {1.1, 2.7, 1.3};
  Eigen::MatrixXd path(5, 3), slopes(5, 3 * 3);
  frames.values(q, path, slopes);  // column o + 3 k: output o by coordinate k
  const std::vector<double> observed(15, 0.0), scales(15, 0.1);
  std::vector<double> residuals(15), jacobian(15 * 3);
  frames.residuals(q, observed, scales, residuals, jacobian);
  std::printf("y at the end %.3f, its residual %.2f\n", path(4, 1), residuals[9]);
  return 0;
}

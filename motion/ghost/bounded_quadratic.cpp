#include "samara/motion/ghost/bounded_quadratic.h"

#include <algorithm>
#include <vector>

#include <Eigen/Cholesky>

namespace samara::motion {

namespace {

enum class At { inside, lower, upper };

/// The minimum over the variables inside, the others where they are.
Eigen::VectorXd minimum_inside(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Eigen::VectorXd& z,
                               const std::vector<Eigen::Index>& inside) {
  Eigen::VectorXd target = z;
  if (inside.empty()) return target;
  const Eigen::VectorXd slope = g - H * z;
  const Eigen::VectorXd step =
      Eigen::MatrixXd(H(inside, inside)).ldlt().solve(Eigen::VectorXd(slope(inside)));
  for (std::size_t k = 0; k < inside.size(); ++k) target[inside[k]] += step[static_cast<Eigen::Index>(k)];
  return target;
}

}  // namespace

Eigen::VectorXd bounded_minimum(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                                const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                                const Eigen::VectorXd& start) {
  const Eigen::Index n = g.size();
  Eigen::VectorXd z = start;
  std::vector<At> at(static_cast<std::size_t>(n), At::inside);
  // Each round fixes a variable or frees the one with the largest multiplier; sets do not come back, but for round-off.
  for (Eigen::Index round = 0; round < 20 * n + 20; ++round) {
    std::vector<Eigen::Index> inside;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (at[static_cast<std::size_t>(i)] == At::inside) inside.push_back(i);
    }
    const Eigen::VectorXd target = minimum_inside(H, g, z, inside);
    double share = 1.0;
    Eigen::Index first = -1;
    for (const Eigen::Index i : inside) {
      const double bound = target[i] < lower[i] ? lower[i] : upper[i];
      if (target[i] >= lower[i] && target[i] <= upper[i]) continue;
      const double reach = target[i] == z[i] ? 0.0 : (bound - z[i]) / (target[i] - z[i]);
      if (reach >= share && first >= 0) continue;
      share = std::max(0.0, std::min(1.0, reach));
      first = i;
    }
    z += share * (target - z);
    if (first >= 0) {
      const bool is_low = target[first] < lower[first];
      z[first] = is_low ? lower[first] : upper[first];
      at[static_cast<std::size_t>(first)] = is_low ? At::lower : At::upper;
      continue;
    }
    const Eigen::VectorXd slope = g - H * z;  // downhill
    Eigen::Index freed = -1;
    double most = 1e-12 * (1e-300 + g.cwiseAbs().maxCoeff());
    for (Eigen::Index i = 0; i < n; ++i) {
      const At place = at[static_cast<std::size_t>(i)];
      const double inward = place == At::lower ? slope[i] : place == At::upper ? -slope[i] : 0.0;
      if (inward > most) {
        most = inward;
        freed = i;
      }
    }
    if (freed < 0) break;
    at[static_cast<std::size_t>(freed)] = At::inside;
  }
  return z.cwiseMax(lower).cwiseMin(upper);
}

}  // namespace samara::motion

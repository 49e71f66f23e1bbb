#include "samara/codebooks/build/stepped_skeleton.h"

#include <algorithm>
#include <utility>

#include "samara/pgd/cross/max_volume.h"

namespace samara::codebooks {

Skeleton find_skeleton(const std::function<Eigen::MatrixXd(int count)>& some,
                       const std::vector<double>& times, const Eigen::VectorXd& scale, int fewest,
                       int max_rows, double bound) {
  constexpr int kMost = 6400;
  const auto states = static_cast<int>(scale.size());
  for (int count = fewest;; count *= 2) {
    pgd::MaxVolume volume = pgd::max_volume(some(count), std::min(count, max_rows), bound);
    const auto found = static_cast<int>(volume.rows.size());
    if (3 * found > count && count < kMost) continue;
    Skeleton skeleton{std::move(volume.rows), std::move(volume.coefficients), {}, {}, Eigen::VectorXd(found)};
    std::vector<int> used;
    for (const int row : skeleton.rows) used.push_back(row / states);
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const int time : used) skeleton.times.push_back(times[static_cast<std::size_t>(time)]);
    for (int m = 0; m < found; ++m) {
      const int row = skeleton.rows[static_cast<std::size_t>(m)];
      const auto time = std::ranges::lower_bound(used, row / states) - used.begin();
      skeleton.places.push_back(row % states + states * time);
      skeleton.scale[m] = scale[row % states];
    }
    return skeleton;
  }
}

}  // namespace samara::codebooks

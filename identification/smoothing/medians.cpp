#include "samara/identification/smoothing/medians.h"

#include <algorithm>
#include <limits>

namespace samara::identification {

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double median_interval(const Eigen::VectorXd& times) {
  std::vector<double> intervals;
  for (Eigen::Index k = 1; k < times.size(); ++k) intervals.push_back(times[k] - times[k - 1]);
  return median(intervals);
}

}  // namespace samara::identification

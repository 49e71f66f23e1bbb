#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

/// What is said of a motion's next moments as a distribution: a mixture of normal distributions at each time.
namespace samara::identification {

/// One way on: a hypothesis of an ambiguous attitude, or a baseline that has a share.
struct ForecastComponent {
  double weight = 1.0;        ///< of all components 1 together
  Eigen::MatrixXd mean = {};  ///< times x outputs, in the outputs' units; NaN: nothing is said
  std::vector<Eigen::MatrixXd> covariance = {};  ///< a time each: outputs x outputs
};

struct Forecast {
  Eigen::VectorXd times = {};  ///< s
  std::vector<std::string> outputs = {};
  std::vector<ForecastComponent> components = {};
};

}  // namespace samara::identification

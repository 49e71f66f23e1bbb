#pragma once

#include <string>
#include <vector>

#include "samara/models/interface/model.h"

/// Where a law is not smooth: values of a state at which a rate, or its slope along that state, changes within a
/// distance that is small against the scale of the state. What marches along in time must resolve that distance,
/// and interpolation over parameters loses its order there.
///
///   for (const Kink& kink : find_kinks(my_model)) std::cerr << described(kink) << "\n";
///
/// The change is the largest less the smallest value within a distance; of a smooth function it falls with the
/// distance, at a kink it stays until the distance is that of the kink. |w| w has none: its second derivative
/// jumps, not its slope.
namespace samara::models {

struct Kink {
  std::string state;  ///< along which
  double at = 0.0;    ///< its value there [its unit]
  std::string unit;
  double scale = 0.0;  ///< of the state
  /// To either side, within which half of the change happens; 0: too small to be told from none.
  double distance = 0.0;
  std::string rate;         ///< state whose rate changes most
  bool is_of_rate = false;  ///< the rate itself changes; else its slope
  /// Change of the rate, or of its slope times the scale, over the largest |rate| within the scale.
  double jump = 0.0;
  std::string term = {};  ///< force term that changes most there; empty: the model does not list its forces
  /// Parameter of the unit of the state to which the distance is proportional; empty: none.
  std::string floor = {};
};

/// In one sentence.
std::string described(const Kink& kink);

/// Time, states and parameters, as Model::rhs() takes them.
struct ModelPoint {
  double t = 0.0;
  std::vector<double> x;
  ParameterValues p;
};

/// Kinks at zero of each state, all other states as they are at one of the points: one per state at most, that of
/// the largest jump.
std::vector<Kink> kinks_at_zero(const Model& model, const std::vector<ModelPoint>& points);

struct FindKinksOptions {
  unsigned seed = 1;
  int points = 20;  ///< random points within the meaning of the parameters
};

/// Along every state through random points, half of the other states zero: at zero of the state, and where rates
/// change most abruptly elsewhere. One per state at most, that of the largest jump.
/// @throws ArgumentError if an option is outside its meaning; what the model throws passes through.
std::vector<Kink> find_kinks(const Model& model, const FindKinksOptions& options = {});

}  // namespace samara::models

#pragma once

#include <string>
#include <vector>

#include "samara/base/check.h"
#include "samara/models/trajectories/trajectory_family.h"

/// The test for a family of trajectories of your own.
///
///   const auto check = samara::models::check_family(my_family);
///   for (const std::string& finding : check.findings) std::cerr << finding << "\n";
///
/// It looks at what a family says of itself (names, box, end), and at random points of its box
///  - asks twice, with other points in between and from a new source: the bits must be the same;
///  - asks for one output, and for derivatives by one coordinate: they must be those of the whole;
///  - compares derivatives with central differences of the values;
///  - compares batches with single trajectories, and batches on one and on several threads, to the bit;
///  - asks from several threads at once, a source each: the bits must be those of one thread;
///  - gives points that are not finite or have a wrong size, times that decrease, are negative or not finite,
///    and outputs that there are not: each must be refused by an exception of base/errors.h;
///  - looks at outcomes, inside the box and far outside: done means finite values, anything else a message.
///    Exceptions of base/errors.h are as good outside the box.
namespace samara::models {

struct CheckFamilyOptions {
  unsigned seed = 1;
  int points = 6;
  /// s; empty: eleven from 0 to the end of the family, or to 1 s where it has none.
  std::vector<double> times = {};
  /// Of central differences, as a share of the box of the coordinate.
  double difference = 1e-4;
  /// Largest |derivative - central difference| over (largest |derivative| + largest |value| / width of the
  /// box), over all times.
  double derivative_tolerance = 1e-4;
  /// Largest difference between batches, single outputs, and whole trajectories, over the largest |value| of
  /// the output, for families that may differ by round-off.
  double round_off = 1e-10;
  int threads = 4;
};

/// @throws ArgumentError if an option is outside its meaning.
Check check_family(const TrajectoryFamily& family, const CheckFamilyOptions& options = {});

}  // namespace samara::models

#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"
#include "samara/pgd/evolution/march_context.h"
#include "samara/pgd/evolution/slab_cell.h"

namespace samara::pgd {

/// How long the slabs of a cell and their elements are.
class TimeStepper {
 public:
  explicit TimeStepper(MarchContext& context) : context_(context) {}

  /// Marches the guard points element by element, each as long as polynomials in time follow
  /// all of them: the elements of the next slab. @param start states x guard points
  /// @returns why the march ends there, if it does
  std::optional<Ending> probe(SlabCell& cell, const Eigen::MatrixXd& start);

  /// Half as many elements, or one of half the length. @returns false, and leaves the slab as it is, if elements
  /// cannot be shorter
  bool halve(SlabCell& cell) const;

  /// The same for a slab that was not solved. @returns why the march ends there, if elements cannot be shorter
  std::optional<Ending> shorten(SlabCell& cell, const Ending& why);

 private:
  struct WorstPoint {
    double error = 0.0;
    Eigen::Index point = 0;
  };
  WorstPoint error_in_time(const SlabPoints& element, double begin, double end, const Eigen::MatrixXd& q);
  Ending give_up(const SlabCell& cell, double length, const SlabPoints& points,
                 const Eigen::MatrixXd& q) const;
  Ending give_up_on_time(const SlabCell& cell, double length, const Eigen::VectorXd& start,
                         const Eigen::VectorXd& q) const;
  Eigen::RowVectorXd growth_of(const Eigen::MatrixXd& values) const;
  bool goes_too_far(const Eigen::MatrixXd& values) const;
  bool moves_by_its_size(double t, const Eigen::VectorXd& start, const Eigen::VectorXd& q,
                         double length) const;

  MarchContext& context_;
};

}  // namespace samara::pgd

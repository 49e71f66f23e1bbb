#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "samara/codebooks/book/codebook.h"
#include "samara/models/interface/following_model.h"

/// How the coefficients of a motion change: at knots they set out for new values, and rest when they are there.
namespace samara::motion {

/// From `t` on the coefficients go from where they are to `values`, by a smoothstep of the duration `ramp`.
struct CourseKnot {
  double t = 0.0;              ///< s
  std::vector<double> values;  ///< one per coefficient
  double ramp = 0.0;           ///< s, more than 0
};

/// c(t) = c_k + (v_k - c_k) (3 s^2 - 2 s^3), s = (t - t_k)/ramp_k within [0, 1], from knot k on, where c_k is what
/// the course has reached at t_k. Continuous, and a cubic between two neighbouring instants of instants(). The same
/// course as models::Stepper::ramp at the knots, but not held over steps.
class CoefficientCourse final : public models::ParameterCourse {
 public:
  /// @param first values before the first knot
  /// @throws ArgumentError for no name or one twice, values that are not finite or not one per name, knots before 0 or
  /// not increasing, or ramps that are not positive.
  CoefficientCourse(std::vector<std::string> names, std::vector<double> first,
                    std::vector<CourseKnot> knots = {});

  const std::vector<std::string>& followed() const override { return names_; }
  void values(double t, std::span<const double> own, std::span<double> followed) const override;

  const std::vector<double>& first() const { return first_; }
  const std::vector<CourseKnot>& knots() const { return knots_; }
  /// Where ramps begin and end, between 0 and `end`, both included, increasing.
  std::vector<double> instants(double end) const;

 private:
  std::vector<std::string> names_;
  std::vector<double> first_;
  std::vector<CourseKnot> knots_;
  std::vector<std::vector<double>> from_;  ///< per knot, what the course has reached
};

/// The course from 0 to `end` as a codebook of one axis, t, without error: what `samara simulate --coefficients`
/// replays.
/// @param fixed the other parameters and the initial values of the motion, SI: they go into the file
/// @throws ArgumentError if a coefficient is no parameter of the model, or `end` is not positive.
codebooks::Codebook course_codebook(const CoefficientCourse& course, const models::ModelInfo& model,
                                    const std::map<std::string, double>& fixed, double end);

}  // namespace samara::motion

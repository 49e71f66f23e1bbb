#include "samara/identification/design/capture_rows.h"

#include "samara/identification/statistics/determined_inverse.h"

namespace samara::identification {

Eigen::MatrixXd CaptureRows::normal() const {
  return by_unknowns.transpose() * by_unknowns;
}

Eigen::MatrixXd CaptureRows::normal(const std::function<bool(int frame, int output)>& keeps) const {
  const auto beforehand = by_unknowns.bottomRows(by_unknowns.rows() - seen());
  Eigen::MatrixXd sum = beforehand.transpose() * beforehand;
  for (int row = 0; row < seen(); ++row) {
    const auto at = static_cast<std::size_t>(row);
    if (keeps(frames[at], outputs[at])) sum += by_unknowns.row(row).transpose() * by_unknowns.row(row);
  }
  return sum;
}

Eigen::MatrixXd eliminated(const Eigen::MatrixXd& normal, int coefficients) {
  const Eigen::Index own = normal.cols() - coefficients;
  const DeterminedInverse inverse =
      invert_determined(normal.bottomRightCorner(own, own), Eigen::VectorXd::Zero(own));
  const auto across = normal.bottomLeftCorner(own, coefficients);
  return normal.topLeftCorner(coefficients, coefficients) - across.transpose() * inverse.inverse * across;
}

NextCapture::NextCapture(const models::TrajectoryFamily& family, const Experiment& experiment,
                         const KnownSoFar& known)
    : errors_(known.errors),
      own_count_(experiment.own_count),
      problem_(make_problem(family.info(), std::vector{experiment.capture}, experiment.options)),
      residual_(family, problem_, problem_.segments.front()) {}

bool NextCapture::is_inside(const Eigen::VectorXd& own) const {
  for (std::size_t k = 0; k < own_count_; ++k) {
    const models::FamilyCoordinate& c = problem_.own[k];
    const double value = own[static_cast<Eigen::Index>(k)];
    if (!(value >= c.lower && value <= c.upper)) return false;
  }
  return true;
}

bool NextCapture::evaluate(const Eigen::VectorXd& coefficients, const std::vector<double>& release,
                           CaptureRows& rows) {
  Eigen::VectorXd own = Eigen::VectorXd::Zero(problem_.own_count());
  for (std::size_t k = 0; k < own_count_; ++k) own[static_cast<Eigen::Index>(k)] = release[k];
  if (problem_.own_attitude) {
    const auto first = static_cast<Eigen::Index>(*problem_.own_attitude);
    own.segment<4>(first) = unit_attitude(own.segment<4>(first));
  }
  if (!is_inside(own)) return false;
  Motion& motion = problem_.motions.front();
  for (std::size_t k = 0; k < motion.known.size(); ++k) motion.known[k] = release[own_count_ + k];
  Segment& segment = problem_.segments.front();
  if (!segment.attitudes.empty()) {
    // Turns are taken from what was measured, which is expected to be what the model says.
    if (!residual_.evaluate(coefficients.data(), own.data(), nullptr, false)) return false;
    for (AttitudeObservation& attitude : segment.attitudes)
      Eigen::Map<Eigen::Vector4d>(attitude.q_WB.data()) = residual_.attitude(attitude.frame);
  }
  if (!residual_.evaluate(coefficients.data(), own.data(), nullptr, true)) return false;

  const Eigen::Index shared = problem_.shared_count();
  rows.coefficients = problem_.shared_count();
  rows.by_unknowns.resize(residual_.size(), shared + problem_.own_chart.directions());
  rows.by_unknowns.leftCols(shared) = residual_.by_shared() * errors_.asDiagonal();
  rows.by_unknowns.rightCols(problem_.own_chart.directions()) =
      residual_.by_own() * problem_.own_chart.plus_jacobian(own.data());
  rows.frames.clear();
  rows.outputs.clear();
  for (const Observation& o : segment.observations) {
    rows.frames.push_back(o.frame);
    rows.outputs.push_back(o.output);
  }
  for (const AttitudeObservation& attitude : segment.attitudes) {
    rows.frames.insert(rows.frames.end(), 3, attitude.frame);
    rows.outputs.insert(rows.outputs.end(), 3, static_cast<int>(problem_.outputs.size()));
  }
  return rows.by_unknowns.allFinite();
}

}  // namespace samara::identification

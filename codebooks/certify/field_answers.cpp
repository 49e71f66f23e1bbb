#include "samara/codebooks/certify/field_answers.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::codebooks {

FieldAnswers::FieldAnswers(const Codebook& book, std::vector<double> times, Eigen::VectorXd places)
    : query_(book),
      times_(std::move(times)),
      places_(std::move(places)),
      space_(book.space().value()),
      first_(book.has_time() ? 1 : 0) {
  // All points at once would take the memory of as many numbers as there are coordinates for each.
  constexpr Eigen::Index kMostPoints = 1 << 14;
  places_at_once_ = std::clamp<Eigen::Index>(kMostPoints / rows(), 1, places_.size());
  points_.resize(book.coordinate_count(), rows() * places_at_once_);
  if (book.has_time())
    points_.row(0) =
        Eigen::Map<const Eigen::RowVectorXd>(times_.data(), rows()).replicate(1, places_at_once_);
  values_.resize(1, rows() * places_.size());
}

Eigen::Index FieldAnswers::rows() const {
  return std::max<Eigen::Index>(1, static_cast<Eigen::Index>(times_.size()));
}

void FieldAnswers::ask() {
  for (Eigen::Index first = 0; first < places_.size(); first += places_at_once_) {
    const Eigen::Index count = std::min(places_at_once_, places_.size() - first);
    for (Eigen::Index j = 0; j < count; ++j)
      points_.row(space_).segment(j * rows(), rows()).setConstant(places_[first + j]);
    query_.batch(points_.leftCols(count * rows()), values_.middleCols(first * rows(), count * rows()));
  }
}

PointErrors FieldAnswers::compare(std::span<const double> q, const FieldReference& reference) {
  rest_.clear();
  for (Eigen::Index k = first_; k < points_.rows(); ++k) {
    if (k == space_) continue;
    const double value = q[static_cast<std::size_t>(k - first_)];
    points_.row(k).setConstant(value);
    rest_.push_back(value);
  }
  Eigen::MatrixXd expected;
  try {
    expected = reference.values(rest_, times_, places_);
  } catch (const NoResultError& error) {
    PointErrors errors;
    errors.failure = error.what();
    return errors;
  }
  if (expected.rows() != rows() || expected.cols() != places_.size()) {
    throw ArgumentError(
        fmt::format("the reference of a field gave {} x {} values, expected {} times x {} places",
                    expected.rows(), expected.cols(), rows(), places_.size()));
  }
  ask();
  PointErrors errors = compared_rows(values_.transpose(), expected.reshaped());
  const int worst = errors.worst_time.front();
  errors.worst_time.front() = static_cast<int>(worst % rows());
  errors.worst_place = places_[worst / rows()];
  return errors;
}

}  // namespace samara::codebooks

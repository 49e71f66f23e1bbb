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
  // All at once would take the memory of many numbers for each time and place.
  constexpr Eigen::Index kMostValues = 1 << 18, kMostPoints = 1 << 14;
  times_at_once_ = std::clamp<Eigen::Index>(kMostValues / places_.size(), 1, rows());
  places_at_once_ = std::clamp<Eigen::Index>(kMostPoints / times_at_once_, 1, places_.size());
  points_.resize(book.coordinate_count(), times_at_once_ * places_at_once_);
  values_.resize(1, times_at_once_ * places_.size());
}

Eigen::Index FieldAnswers::rows() const {
  return std::max<Eigen::Index>(1, static_cast<Eigen::Index>(times_.size()));
}

void FieldAnswers::compare_block(Eigen::Index first_time, const Eigen::Ref<const Eigen::MatrixXd>& expected,
                                 PointErrors& errors) {
  const Eigen::Index times = expected.rows();
  if (!times_.empty()) {
    const Eigen::Map<const Eigen::RowVectorXd> now(&times_[static_cast<std::size_t>(first_time)], times);
    points_.row(0).head(times * places_at_once_) = now.replicate(1, places_at_once_);
  }
  for (Eigen::Index first = 0; first < places_.size(); first += places_at_once_) {
    const Eigen::Index count = std::min(places_at_once_, places_.size() - first);
    for (Eigen::Index j = 0; j < count; ++j)
      points_.row(space_).segment(j * times, times).setConstant(places_[first + j]);
    query_.batch(points_.leftCols(count * times), values_.middleCols(first * times, count * times));
  }
  PointErrors block =
      compared_rows(values_.leftCols(times * places_.size()).transpose(), expected.reshaped());
  const int worst = block.worst_time.front();
  block.worst_time.front() = static_cast<int>(first_time + worst % times);
  block.worst_place = places_[worst / times];
  if (!errors.usable) {
    errors = std::move(block);
    return;
  }
  if (block.max_error[0] > errors.max_error[0]) {
    errors.max_error = block.max_error;
    errors.worst_time = block.worst_time;
    errors.worst_place = block.worst_place;
  }
  errors.sum_error2 += block.sum_error2;
  errors.sum_value2 += block.sum_value2;
  errors.smallest = errors.smallest.cwiseMin(block.smallest).eval();
  errors.largest = errors.largest.cwiseMax(block.largest).eval();
}

PointErrors FieldAnswers::compare(std::span<const double> q, const FieldReference& reference) {
  rest_.clear();
  for (Eigen::Index k = first_; k < points_.rows(); ++k) {
    if (k == space_) continue;
    const double value = q[static_cast<std::size_t>(k - first_)];
    points_.row(k).setConstant(value);
    rest_.push_back(value);
  }
  PointErrors errors;
  try {
    if (!reference.time_by_time) {
      const Eigen::MatrixXd all = reference.values(rest_, times_, places_);
      check_size(all.rows(), all.cols());
      for (Eigen::Index first = 0; first < rows(); first += times_at_once_)
        compare_block(first, all.middleRows(first, std::min(times_at_once_, rows() - first)), errors);
      return errors;
    }
    Eigen::Index told = 0;
    expected_.resize(times_at_once_, places_.size());
    reference.time_by_time(rest_, times_, places_, [&](std::size_t time, const auto& values) {
      if (static_cast<Eigen::Index>(time) != told || told == rows() || values.size() != places_.size()) {
        throw ArgumentError(fmt::format(
            "the reference of a field gave {} values as those of time {}, expected {} of time {} of {}",
            values.size(), time, places_.size(), told, rows()));
      }
      const Eigen::Index row = told % times_at_once_;
      expected_.row(row) = values.transpose();
      ++told;
      if (row + 1 == times_at_once_ || told == rows())
        compare_block(told - row - 1, expected_.topRows(row + 1), errors);
    });
    check_size(told, places_.size());
  } catch (const NoResultError& error) {
    errors = {};
    errors.failure = error.what();
  }
  return errors;
}

void FieldAnswers::check_size(Eigen::Index rows_given, Eigen::Index places_given) const {
  if (rows_given == rows() && places_given == places_.size()) return;
  throw ArgumentError(
      fmt::format("the reference of a field gave {} x {} values, expected {} times x {} places", rows_given,
                  places_given, rows(), places_.size()));
}

}  // namespace samara::codebooks

#include "samara/codebooks/capi/answers.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "samara/base/errors.h"
#include "samara/codebooks/query/query_choice.h"

namespace samara::codebooks {

namespace {

/// The stored outputs that options ask for; nothing where one of them is not stored.
std::vector<pgd::OutputLabel> stored_outputs(const Codebook& book, const QueryOptions& options) {
  if (options.outputs.empty()) return book.outputs();
  std::vector<pgd::OutputLabel> outputs;
  for (const std::string& name : options.outputs) {
    const auto stored = std::ranges::find(book.outputs(), name, &pgd::OutputLabel::name);
    if (stored == book.outputs().end()) return {};
    outputs.push_back(*stored);
  }
  return outputs;
}

std::span<const double> numbers(const double* x, std::size_t count) {
  return {x, count};
}

/// A matrix row by row, as C has it.
void put_rows(const Eigen::MatrixXd& gradient, double* rows) {
  Eigen::Map<Eigen::MatrixXd>(rows, gradient.cols(), gradient.rows()) = gradient.transpose();
}

}  // namespace

PointAnswers::PointAnswers(const Codebook& book, const QueryOptions& options)
    : outputs_(stored_outputs(book, options)), precision_(options.precision) {
  if (outputs_.empty()) {
    derived_ = std::make_unique<DerivedQuery>(book, options);
    outputs_ = derived_->outputs();
    precision_ = derived_->precision();
  } else {
    stored_ = std::make_unique<Query>(book, options);
    precision_ = stored_->precision();
  }
  gradient_.resize(std::ssize(outputs_), std::ssize(coordinates()));
}

const std::vector<Coordinate>& PointAnswers::coordinates() const {
  return stored_ ? stored_->coordinates() : derived_->coordinates();
}

void PointAnswers::values(const double* x, double* values) {
  Eigen::Map<Eigen::VectorXd> answer(values, std::ssize(outputs_));
  const auto point = numbers(x, coordinates().size());
  stored_ ? stored_->values(point, answer) : derived_->values(point, answer);
}

void PointAnswers::values(const double* x, double* values, double* gradient) {
  Eigen::Map<Eigen::VectorXd> answer(values, std::ssize(outputs_));
  const auto point = numbers(x, coordinates().size());
  stored_ ? stored_->values(point, answer, gradient_) : derived_->values(point, answer, gradient_);
  put_rows(gradient_, gradient);
}

void PointAnswers::batch(Eigen::Index count, const double* points, double* values, double* gradients,
                         int threads) {
  const Eigen::Index d = std::ssize(coordinates()), outputs = std::ssize(outputs_);
  if (stored_ && gradients == nullptr)
    return stored_->batch(Eigen::Map<const Eigen::MatrixXd>(points, d, count),
                          Eigen::Map<Eigen::MatrixXd>(values, outputs, count), threads);
  if (stored_) {
    // In blocks: what the library answers stands in another order, and need not be there for all points at once.
    constexpr Eigen::Index kBlock = 8192;
    Eigen::MatrixXd slopes(outputs * d, std::min(count, kBlock));
    for (Eigen::Index begin = 0; begin < count; begin += kBlock) {
      const Eigen::Index size = std::min(count - begin, kBlock);
      stored_->batch(Eigen::Map<const Eigen::MatrixXd>(points + d * begin, d, size),
                     Eigen::Map<Eigen::MatrixXd>(values + outputs * begin, outputs, size),
                     slopes.leftCols(size), threads);
      for (Eigen::Index j = 0; j < size; ++j) {
        Eigen::Map<Eigen::MatrixXd>(gradients + outputs * d * (begin + j), d, outputs) =
            slopes.col(j).reshaped(outputs, d).transpose();
      }
    }
    return;
  }
  if (threads < 0)
    throw ArgumentError("a batch on " + std::to_string(threads) + " threads, expected 0 or more");
  for (Eigen::Index j = 0; j < count; ++j) {
    if (gradients == nullptr) {
      this->values(points + d * j, values + outputs * j);
    } else {
      this->values(points + d * j, values + outputs * j, gradients + outputs * d * j);
    }
  }
}

FrameAnswers::FrameAnswers(const Codebook& book, std::vector<double> times, const QueryOptions& options)
    : times_(std::move(times)) {
  if (!stored_outputs(book, options).empty()) {
    stored_ = std::make_unique<TrajectoryQuery>(book, times_, options);
    outputs_ = stored_->output_count();
    parameters_ = stored_->parameter_count();
    return;
  }
  const std::string& time = book.time("a query of trajectories").name;
  if (options.fixed.contains(time))
    throw ArgumentError("a query at given times cannot hold time at another one");
  // Times outside the box are refused here, not at the first trajectory.
  TrajectoryQuery(book, times_, {{}, options.fixed});
  derived_ = std::make_unique<PointAnswers>(book, options);
  outputs_ = std::ssize(derived_->outputs());
  parameters_ = std::ssize(derived_->coordinates()) - 1;
  point_.resize(derived_->coordinates().size());
  row_.resize(static_cast<std::size_t>(outputs_));
  slopes_.resize(row_.size() * point_.size());
}

void FrameAnswers::values(const double* q, double* values, double* derivatives) {
  Eigen::Map<Eigen::MatrixXd> answer(values, times(), outputs_);
  const auto parameters = numbers(q, static_cast<std::size_t>(parameters_));
  if (stored_) {
    if (derivatives == nullptr) return stored_->values(parameters, answer);
    return stored_->values(parameters, answer,
                           Eigen::Map<Eigen::MatrixXd>(derivatives, times(), outputs_ * parameters_));
  }
  std::ranges::copy(parameters, point_.begin() + 1);
  for (Eigen::Index i = 0; i < times(); ++i) {
    point_[0] = times_[static_cast<std::size_t>(i)];
    if (derivatives == nullptr) {
      derived_->values(point_.data(), row_.data());
    } else {
      derived_->values(point_.data(), row_.data(), slopes_.data());
    }
    for (Eigen::Index o = 0; o < outputs_; ++o) {
      answer(i, o) = row_[static_cast<std::size_t>(o)];
      for (Eigen::Index k = 0; derivatives != nullptr && k < parameters_; ++k)
        derivatives[(k * outputs_ + o) * times() + i] =
            slopes_[static_cast<std::size_t>(o * (1 + parameters_) + 1 + k)];
    }
  }
}

void FrameAnswers::batch(Eigen::Index count, const double* points, double* values, double* derivatives,
                         int threads) {
  const Eigen::Index rows = times() * outputs_;
  if (stored_) {
    const Eigen::Map<const Eigen::MatrixXd> columns(points, parameters_, count);
    Eigen::Map<Eigen::MatrixXd> answers(values, rows, count);
    if (derivatives == nullptr) return stored_->batch(columns, answers, threads);
    return stored_->batch(columns, answers,
                          Eigen::Map<Eigen::MatrixXd>(derivatives, rows * parameters_, count), threads);
  }
  if (threads < 0)
    throw ArgumentError("a batch on " + std::to_string(threads) + " threads, expected 0 or more");
  for (Eigen::Index j = 0; j < count; ++j)
    this->values(points + parameters_ * j, values + rows * j,
                 derivatives == nullptr ? nullptr : derivatives + rows * parameters_ * j);
}

}  // namespace samara::codebooks

#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "flat_eval_variant.h"
#include "samara/codebooks/capi/samara_eval.h"
#include "samara/codebooks/file/flat_file.h"
#include "samara/codebooks/query/query.h"

/// By loops without vectors, as for compilers that are neither GCC nor Clang.
extern const FlatEval kFlatEvalPlain;
/// By the vectors of all machines that the tests may run on.
extern const FlatEval kFlatEvalOneMachine;

/// A flat file, asked through samara_eval.h and compared with the library.
class FlatAnswers {
 public:
  /// samara_eval.h in C, as a program has it that is compiled like the tests.
  static constexpr FlatEval kLinked = {&samara_eval_open_memory, &samara_eval_work_size, &samara_eval_point,
                                       &samara_eval_close};

  explicit FlatAnswers(const samara::codebooks::Codebook& book, const FlatEval& eval = kLinked)
      : eval_(eval), book_(nullptr, eval.close) {
    const std::string bytes = format_flat(book);
    samara_eval* opened = nullptr;
    const char* why = "";
    if (eval_.open_memory(bytes.data(), bytes.size(), &opened, &why) != SAMARA_EVAL_DONE)
      throw std::runtime_error(why);
    book_.reset(opened);
    work_.resize(eval_.work_size(opened));
  }

  const samara_eval* book() const { return book_.get(); }
  samara_eval_status at(const double* x, double* values, double* gradient) {
    return eval_.point(book_.get(), work_.data(), x, values, gradient);
  }

  /// The largest difference of values and derivatives from those of a query, each divided by the largest of its output
  /// and, of derivatives, coordinate over all points (`scales` is of that size), which is what sums of terms of
  /// different signs are accurate to.
  double largest_difference(samara::codebooks::Query& query, const Eigen::MatrixXd& points) {
    const Eigen::Index d = points.rows(), outputs = query.output_count();
    Eigen::MatrixXd wanted(outputs * (1 + d), points.cols()), given(outputs * (1 + d), points.cols());
    Eigen::VectorXd values(outputs), answer(outputs), again(outputs), slopes(outputs * d);
    Eigen::MatrixXd gradient(outputs, d);
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      const double* const x = points.col(j).data();
      query.values({x, static_cast<std::size_t>(d)}, values, gradient);
      if (at(x, answer.data(), slopes.data()) != SAMARA_EVAL_DONE) throw std::runtime_error("refused");
      if (at(x, again.data(), nullptr) != SAMARA_EVAL_DONE || again != answer)
        throw std::runtime_error("values without a gradient differ");
      wanted.col(j) << values, gradient.transpose().reshaped();
      given.col(j) << answer, slopes;
    }
    double largest = 0.0;
    for (Eigen::Index i = 0; i < wanted.rows(); ++i) {
      double scale = 0.0, difference = 0.0;
      for (Eigen::Index j = 0; j < wanted.cols(); ++j) {
        if (std::isnan(wanted(i, j)) && std::isnan(given(i, j))) continue;
        const double apart = std::abs(wanted(i, j) - given(i, j));
        difference = std::isnan(apart) ? INFINITY : std::max(difference, apart);
        scale = std::max(scale, std::abs(wanted(i, j)));
      }
      if (difference > 0.0) largest = std::max(largest, difference / scale);
    }
    return largest;
  }

 private:
  FlatEval eval_;
  std::unique_ptr<samara_eval, decltype(FlatEval::close)> book_;
  std::vector<double> work_;
};

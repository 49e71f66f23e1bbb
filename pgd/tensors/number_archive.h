#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include "samara/base/errors.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/tensor_train.h"

/// A solver's state as one list of numbers, none of them infinite, and back. A function
///
///   template <class Archive> void transfer(Archive& archive, Thing& thing) { archive(thing.a, thing.b); }
///
/// says once what belongs to the state, for both directions.
namespace samara::pgd {

/// What both directions know about compound values.
template <class Self>
class NumberArchive {
 public:
  template <class... Values>
  void operator()(Values&... values) {
    (self().value(values), ...);
  }

  template <class Item>
  void value(std::vector<Item>& items) {
    auto count = static_cast<Eigen::Index>(items.size());
    self().size(count);
    items.resize(static_cast<std::size_t>(count));
    for (Item& item : items) self().value(item);
  }
  template <class Scalar, int Rows, int Columns>
  void value(Eigen::Matrix<Scalar, Rows, Columns>& matrix) {
    Eigen::Index rows = matrix.rows(), columns = matrix.cols();
    self().size(rows);
    if constexpr (Columns != 1) self().size(columns, std::max<Eigen::Index>(rows, 1));
    matrix.resize(rows, columns);
    for (Scalar& number : matrix.reshaped()) self().value(number);
  }
  void value(TrainCore& core) { (*this)(core.left, core.size, core.right, core.data); }
  void value(TensorTrain& train) { value(train.cores); }
  /// Any bits, as two numbers that a double holds.
  void value(Random& random) {
    auto high = static_cast<std::uint32_t>(random.state() >> 32);
    auto low = static_cast<std::uint32_t>(random.state());
    (*this)(high, low);
    random = Random(std::uint64_t{high} << 32 | low);
  }

 private:
  Self& self() { return static_cast<Self&>(*this); }
};

class NumberWriter : public NumberArchive<NumberWriter> {
 public:
  using NumberArchive::value;
  static constexpr bool kReads = false;

  const std::vector<double>& numbers() const { return numbers_; }

  /// Infinity is stored as the largest number.
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void value(Number& number) {
    const auto stored = static_cast<double>(number);
    numbers_.push_back(stored > std::numeric_limits<double>::max() ? std::numeric_limits<double>::max()
                                                                   : stored);
  }
  void size(Eigen::Index& size, Eigen::Index = 1) { value(size); }

 private:
  std::vector<double> numbers_;
};

class NumberReader : public NumberArchive<NumberReader> {
 public:
  using NumberArchive::value;
  static constexpr bool kReads = true;

  explicit NumberReader(std::span<const double> numbers) : left_(numbers) {}

  std::span<const double> rest() const { return left_; }

  /// @throws ArgumentError where the list ends too early, or holds what the number cannot be
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void value(Number& number) {
    if (left_.empty()) throw ArgumentError("the stored state of a solver ends too early");
    const double stored = left_.front();
    left_ = left_.subspan(1);
    if constexpr (std::is_floating_point_v<Number>) {
      number =
          stored == std::numeric_limits<double>::max() ? std::numeric_limits<double>::infinity() : stored;
    } else {
      // Whole numbers up to 2^53 are doubles.
      constexpr double kMost = std::min(0x1p53, static_cast<double>(std::numeric_limits<Number>::max()));
      constexpr double kLeast = std::max(-0x1p53, static_cast<double>(std::numeric_limits<Number>::min()));
      if (!(stored >= kLeast && stored <= kMost) || stored != std::trunc(stored))
        throw ArgumentError("the stored state of a solver has another number where a whole one belongs");
      number = static_cast<Number>(stored);
    }
  }
  /// Of a list of items of so many numbers: never more than what is left.
  void size(Eigen::Index& size, Eigen::Index numbers = 1) {
    value(size);
    if (size < 0 || size > static_cast<Eigen::Index>(left_.size()) / numbers)
      throw ArgumentError("the stored state of a solver has a list longer than itself");
  }

 private:
  std::span<const double> left_;
};

}  // namespace samara::pgd

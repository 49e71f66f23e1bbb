#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <pybind11/pybind11.h>

#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "shelf.h"

namespace samara::python {

namespace py = pybind11;

/// What is asked of a codebook, beside the point.
struct Choice {
  std::vector<std::string> outputs = {};
  std::map<std::string, double> held = {};
  codebooks::Precision precision = codebooks::Precision::double_precision;

  bool operator==(const Choice&) const = default;
  codebooks::QueryOptions options() const {
    return {.outputs = outputs, .fixed = held, .precision = precision};
  }
};

/// A codebook with queries that are prepared for what was asked of it lately, without the interpreter's lock, which the
/// caller holds. Safe to share between threads.
class Book {
 public:
  explicit Book(codebooks::Codebook book)
      : book_(std::make_shared<const codebooks::Codebook>(std::move(book))) {}

  const codebooks::Codebook& operator*() const { return *book_; }
  const codebooks::Codebook* operator->() const { return book_.get(); }
  const std::shared_ptr<const codebooks::Codebook>& shared() const { return book_; }

  using PointQueries = Shelf<Choice, codebooks::Query>;
  struct Frames {
    std::vector<double> times;
    Choice choice;
    bool operator==(const Frames&) const = default;
  };
  using FrameQueries = Shelf<Frames, codebooks::TrajectoryQuery>;

  PointQueries::Loan query(const Choice& choice) const {
    return points_.take(choice, [&] {
      const py::gil_scoped_release release;
      return codebooks::Query(*book_, choice.options());
    });
  }
  FrameQueries::Loan query(const Frames& frames) const {
    return frames_.take(frames, [&] {
      const py::gil_scoped_release release;
      return codebooks::TrajectoryQuery(*book_, frames.times, frames.choice.options());
    });
  }

 private:
  std::shared_ptr<const codebooks::Codebook> book_;
  mutable PointQueries points_;
  mutable FrameQueries frames_;
};

}  // namespace samara::python

#include "samara/codebooks/query/query.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/argument_checks.h"
#include "samara/codebooks/query/query_choice.h"

namespace samara::codebooks {

struct Query::Impl {
  Prepared prepared;
  PreparedFields::Workspace workspace;
  BatchRun batch;
  std::vector<double*> columns;

  explicit Impl(Prepared fields)
      : prepared(std::move(fields)),
        workspace(prepared.fields->make_workspace()),
        batch(*prepared.fields),
        columns(static_cast<std::size_t>(
            kernels::PackedField<double>::column_count(prepared.fields->coordinate_count(), 2))) {}

  const PreparedFields& fields() const { return *prepared.fields; }

  /// The piece that answers for a point.
  int piece_at(std::span<const double> x) const {
    if (x.size() == fields().coordinates().size() &&
        std::ranges::all_of(x, [](double value) { return std::isfinite(value); })) {
      const int piece = fields().finder().find(x.data());
      if (piece >= 0) return piece;
    }
    require_inside(fields().coordinates(), x);
    throw OutsideBoxError(
        "the point lies in a gap between the pieces of the codebook or the values of a discrete axis");
  }

  void answer(std::span<const double> x, int order) {
    fields().point(piece_at(x), x.data(), order, workspace, columns.data());
    if (prepared.attitude) prepared.attitude->restore(columns.data(), order, fields().coordinate_count(), 1);
  }

  void run(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
           Eigen::Index begin, Eigen::Index end) {
    const Eigen::Index d = points.rows();
    for (Eigen::Index first = begin; first < end; first += kBatchChunk) {
      const Eigen::Index count = std::min<Eigen::Index>(kBatchChunk, end - first);
      batch.places().clear();
      for (Eigen::Index j = 0; j < count; ++j) {
        const double* const x = points.col(first + j).data();
        batch.places().push_back({piece_at({x, static_cast<std::size_t>(d)}), static_cast<int>(j)});
      }
      batch.run(points.col(first).data(), workspace, values.col(first).data(), values.outerStride());
      for (Eigen::Index j = 0; prepared.attitude && j < count; ++j) {
        double* const column = values.col(first + j).data();
        prepared.attitude->restore(&column, 0, 0, 1);
      }
    }
  }
};

Query::Query(const Codebook& book, const QueryOptions& options)
    : impl_(std::make_unique<Impl>(prepare(book, options, std::nullopt))) {}
Query::~Query() = default;
Query::Query(const Query& other) : impl_(std::make_unique<Impl>(other.impl_->prepared)) {}
Query::Query(Query&&) noexcept = default;
Query& Query::operator=(const Query& other) {
  impl_ = std::make_unique<Impl>(other.impl_->prepared);
  return *this;
}
Query& Query::operator=(Query&&) noexcept = default;

const std::vector<Coordinate>& Query::coordinates() const {
  return impl_->fields().coordinates();
}
int Query::output_count() const {
  return impl_->fields().rows();
}
Precision Query::precision() const {
  return impl_->prepared.precision;
}

void Query::values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values) {
  require_size("values", size_of(values), {output_count(), 1});
  impl_->columns[0] = values.data();
  impl_->answer(x, 0);
}

void Query::values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                   Eigen::Ref<Eigen::MatrixXd> gradient) {
  const int d = impl_->fields().coordinate_count();
  require_size("values", size_of(values), {output_count(), 1});
  require_size("derivatives", size_of(gradient), {output_count(), d});
  impl_->columns[0] = values.data();
  for (int k = 0; k < d; ++k) impl_->columns[static_cast<std::size_t>(1 + k)] = gradient.col(k).data();
  impl_->answer(x, 1);
}

void Query::values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                   Eigen::Ref<Eigen::MatrixXd> gradient, Eigen::Ref<Eigen::MatrixXd> hessian) {
  const int d = impl_->fields().coordinate_count();
  require_size("values", size_of(values), {output_count(), 1});
  require_size("derivatives", size_of(gradient), {output_count(), d});
  require_size("second derivatives", size_of(hessian), {output_count(), d * d});
  impl_->columns[0] = values.data();
  for (int k = 0; k < d; ++k) impl_->columns[static_cast<std::size_t>(1 + k)] = gradient.col(k).data();
  std::size_t next = static_cast<std::size_t>(1 + d);
  for (int k = 0; k < d; ++k)
    for (int j = 0; j <= k; ++j) impl_->columns[next++] = hessian.col(j + d * k).data();
  impl_->answer(x, 2);
  for (int k = 0; k < d; ++k)
    for (int j = 0; j < k; ++j) hessian.col(k + d * j) = hessian.col(j + d * k);
}

void Query::batch(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
                  int threads) {
  const int d = impl_->fields().coordinate_count();
  require_size("points", size_of(points), {d, points.cols()});
  require_size("values", size_of(values), {output_count(), points.cols()});
  if (points.outerStride() != d) return batch(Eigen::MatrixXd(points), values, threads);
  if (threads == 1) return impl_->run(points, values, 0, points.cols());
  in_ranges(points.cols(), threads, [&](Eigen::Index begin, Eigen::Index end) {
    Impl(impl_->prepared).run(points, values, begin, end);
  });
}

namespace {

/// Calls answer(query, point) for all points, in each range of them with a query of its own.
template <class Answer>
void point_by_point(Query& query, Eigen::Index count, int threads, const Answer& answer) {
  const auto run = [&](Query& own, Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j) answer(own, j);
  };
  if (threads == 1) return run(query, 0, count);
  in_ranges(count, threads, [&](Eigen::Index begin, Eigen::Index end) {
    Query own(query);
    run(own, begin, end);
  });
}

std::span<const double> point_of(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Index j) {
  return {points.col(j).data(), static_cast<std::size_t>(points.rows())};
}

/// A column of a matrix as a matrix of so many rows.
Eigen::Map<Eigen::MatrixXd> unfolded(Eigen::Ref<Eigen::MatrixXd>& columns, Eigen::Index j,
                                     Eigen::Index rows) {
  return {columns.col(j).data(), rows, rows > 0 ? columns.rows() / rows : 0};
}

}  // namespace

void Query::batch(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
                  Eigen::Ref<Eigen::MatrixXd> gradients, int threads) {
  const Eigen::Index d = impl_->fields().coordinate_count(), outputs = output_count();
  require_size("points", size_of(points), {d, points.cols()});
  require_size("values", size_of(values), {outputs, points.cols()});
  require_size("derivatives", size_of(gradients), {outputs * d, points.cols()});
  point_by_point(*this, points.cols(), threads, [&](Query& query, Eigen::Index j) {
    query.values(point_of(points, j), values.col(j), unfolded(gradients, j, outputs));
  });
}

void Query::batch(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
                  Eigen::Ref<Eigen::MatrixXd> gradients, Eigen::Ref<Eigen::MatrixXd> hessians, int threads) {
  const Eigen::Index d = impl_->fields().coordinate_count(), outputs = output_count();
  require_size("points", size_of(points), {d, points.cols()});
  require_size("values", size_of(values), {outputs, points.cols()});
  require_size("derivatives", size_of(gradients), {outputs * d, points.cols()});
  require_size("second derivatives", size_of(hessians), {outputs * d * d, points.cols()});
  point_by_point(*this, points.cols(), threads, [&](Query& query, Eigen::Index j) {
    query.values(point_of(points, j), values.col(j), unfolded(gradients, j, outputs),
                 unfolded(hessians, j, outputs));
  });
}

}  // namespace samara::codebooks

#include "samara/codebooks/query/trajectory_query.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/argument_checks.h"
#include "samara/codebooks/query/kernels/residual_rows.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/query_choice.h"

namespace samara::codebooks {

namespace {

Prepared prepare_at(const Codebook& book, const std::vector<double>& times, const QueryOptions& options) {
  book.time("a query of trajectories");
  for (const double t : times) require_inside(std::span(book.coordinates()).first(1), std::span(&t, 1));
  return prepare(book, options, times);
}

}  // namespace

struct TrajectoryQuery::Impl {
  std::vector<double> times;
  int outputs = 0;
  Prepared prepared;
  PreparedFields::Workspace workspace;
  BatchRun batch;
  std::vector<double*> columns;
  std::vector<char> answered;  ///< per time, in the present call
  bool is_complete = false;    ///< whether every time is held by a piece over the whole box
  Eigen::MatrixXd residual_values, residual_slopes;
  Eigen::MatrixXd block_rows, block_points;
  std::vector<double*> block_columns;
  std::vector<double> axis_point;

  Impl(std::vector<double> frames, int output_count, Prepared fields)
      : times(std::move(frames)),
        outputs(output_count),
        prepared(std::move(fields)),
        workspace(prepared.fields->make_workspace()),
        batch(*prepared.fields),
        columns(static_cast<std::size_t>(1 + prepared.fields->coordinate_count())),
        answered(times.size()) {
    std::ranges::fill(answered, char{0});
    for (int piece = 0; piece < this->fields().piece_count(); ++piece) mark(piece);
    is_complete = this->fields().all_hold_the_box() && std::ranges::count(answered, char{0}) == 0;
    const auto frame_count = static_cast<Eigen::Index>(times.size());
    residual_values.resize(frame_count, outputs);
    residual_slopes.resize(frame_count, Eigen::Index{outputs} * this->fields().coordinate_count());
    const Eigen::Index size = this->fields().block_size();
    block_rows.resize(this->fields().rows(), size);
    block_points.resize(size, this->fields().axis_count());
    axis_point.resize(this->fields().axis_point_size());
    block_columns.resize(static_cast<std::size_t>(size));
  }

  const PreparedFields& fields() const { return *prepared.fields; }

  void mark(int piece) {
    for (const int i : fields().times_of(piece)) answered[static_cast<std::size_t>(i)] = 1;
  }

  void require_all_answered() const {
    const auto missing = std::find(answered.begin(), answered.end(), char{0});
    if (missing == answered.end()) return;
    throw OutsideBoxError(fmt::format("at t = {} the point lies in a gap between the pieces of the codebook",
                                      times[static_cast<std::size_t>(missing - answered.begin())]));
  }

  /// Pieces are visited from the last to the first, so that at a border the lower piece has the last word.
  void answer(std::span<const double> q, int order) {
    require_inside(fields().coordinates(), q);
    if (!is_complete) std::ranges::fill(answered, char{0});
    for (int piece = fields().piece_count(); piece-- > 0;) {
      if (!is_complete && !fields().finder().contains(piece, q.data())) continue;
      fields().point(piece, q.data(), order, workspace, columns.data());
      if (!is_complete) mark(piece);
    }
    if (!is_complete) require_all_answered();
    if (prepared.attitude) {
      const int count = static_cast<int>(times.size());
      prepared.attitude->restore(columns.data(), order, fields().coordinate_count(), count);
    }
  }

  /// Where every piece answers for every point, and no point needs another element than its neighbours: block
  /// after block, put together before it goes to memory.
  void run_in_blocks(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
                     Eigen::Index begin, Eigen::Index end) {
    // Answers that stay in a cache are better written there.
    constexpr Eigen::Index kCacheBytes = 4 << 20;
    const bool past_caches = values.size() * static_cast<Eigen::Index>(sizeof(double)) > kCacheBytes;
    const Eigen::Index size = fields().block_size(), d = points.rows(), rows = values.rows();
    std::vector<double*>& to = block_columns;
    for (Eigen::Index first = begin; first < end; first += size) {
      const Eigen::Index count = std::min(size, end - first);
      for (Eigen::Index p = 0; p < size; ++p) {
        const double* const q = points.col(first + std::min(p, count - 1)).data();
        require_inside(fields().coordinates(), std::span(q, static_cast<std::size_t>(d)));
        const double* const x = fields().on_axes(q, axis_point.data());
        for (Eigen::Index k = 0; k < block_points.cols(); ++k) block_points(p, k) = x[k];
        double* const column =
            past_caches ? block_rows.col(p).data() : values.col(first + std::min(p, count - 1)).data();
        to[static_cast<std::size_t>(p)] = p < count ? column : nullptr;
      }
      for (int piece = fields().piece_count(); piece-- > 0;)
        fields().block(piece, block_points.data(), workspace, to.data());
      for (Eigen::Index p = 0; past_caches && p < count; ++p)
        kernels::stream(block_rows.col(p).data(), rows, values.col(first + p).data());
    }
  }

  void run(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
           Eigen::Index begin, Eigen::Index end) {
    if (is_complete && fields().has_one_cell()) {
      run_in_blocks(points, values, begin, end);
    } else {
      run_by_cells(points, values, begin, end);
    }
    for (Eigen::Index j = begin; prepared.attitude && j < end; ++j) {
      double* const column = values.col(j).data();
      prepared.attitude->restore(&column, 0, 0, static_cast<int>(times.size()));
    }
  }

  void run_by_cells(const Eigen::Ref<const Eigen::MatrixXd>& points, Eigen::Ref<Eigen::MatrixXd> values,
                    Eigen::Index begin, Eigen::Index end) {
    const auto d = static_cast<std::size_t>(points.rows());
    for (Eigen::Index first = begin; first < end; first += kBatchChunk) {
      const Eigen::Index count = std::min<Eigen::Index>(kBatchChunk, end - first);
      for (Eigen::Index j = 0; j < count; ++j) {
        const std::span<const double> q(points.col(first + j).data(), d);
        require_inside(fields().coordinates(), q);
        if (is_complete) continue;
        std::ranges::fill(answered, char{0});
        for (int piece = 0; piece < fields().piece_count(); ++piece)
          if (fields().finder().contains(piece, q.data())) mark(piece);
        require_all_answered();
      }
      for (int piece = fields().piece_count(); piece-- > 0;) {
        batch.places().clear();
        for (Eigen::Index j = 0; j < count; ++j) {
          if (is_complete || fields().finder().contains(piece, points.col(first + j).data()))
            batch.places().push_back({piece, static_cast<int>(j)});
        }
        batch.run(points.col(first).data(), workspace, values.col(first).data(), values.outerStride());
      }
    }
  }
};

TrajectoryQuery::TrajectoryQuery(const Codebook& book, std::vector<double> times,
                                 const std::vector<std::string>& outputs)
    : TrajectoryQuery(book, std::move(times), QueryOptions{.outputs = outputs}) {}

TrajectoryQuery::TrajectoryQuery(const Codebook& book, std::vector<double> times,
                                 const QueryOptions& options) {
  Prepared prepared = prepare_at(book, times, options);
  const int outputs =
      options.outputs.empty() ? book.output_count() : static_cast<int>(options.outputs.size());
  impl_ = std::make_unique<Impl>(std::move(times), outputs, std::move(prepared));
}
TrajectoryQuery::~TrajectoryQuery() = default;
TrajectoryQuery::TrajectoryQuery(const TrajectoryQuery& other)
    : impl_(std::make_unique<Impl>(other.impl_->times, other.impl_->outputs, other.impl_->prepared)) {}
TrajectoryQuery::TrajectoryQuery(TrajectoryQuery&&) noexcept = default;
TrajectoryQuery& TrajectoryQuery::operator=(const TrajectoryQuery& other) {
  return *this = TrajectoryQuery(other);
}
TrajectoryQuery& TrajectoryQuery::operator=(TrajectoryQuery&&) noexcept = default;

int TrajectoryQuery::time_count() const {
  return static_cast<int>(impl_->times.size());
}
int TrajectoryQuery::output_count() const {
  return impl_->outputs;
}
int TrajectoryQuery::parameter_count() const {
  return impl_->fields().coordinate_count();
}
int TrajectoryQuery::inner_size() const {
  return impl_->fields().inner_size();
}
Precision TrajectoryQuery::precision() const {
  return impl_->prepared.precision;
}

void TrajectoryQuery::values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values) {
  require_size("values", size_of(values), {time_count(), output_count()});
  // Answers are columns of all rows: a matrix with gaps between its columns takes a way round.
  if (values.outerStride() != values.rows()) {
    impl_->columns[0] = impl_->residual_values.data();
    impl_->answer(q, 0);
    values = impl_->residual_values;
    return;
  }
  impl_->columns[0] = values.data();
  impl_->answer(q, 0);
}

void TrajectoryQuery::values(std::span<const double> q, Eigen::Ref<Eigen::MatrixXd> values,
                             Eigen::Ref<Eigen::MatrixXd> derivatives) {
  require_size("values", size_of(values), {time_count(), output_count()});
  require_size("derivatives", size_of(derivatives), {time_count(), output_count() * parameter_count()});
  const bool has_gaps =
      values.outerStride() != values.rows() || derivatives.outerStride() != derivatives.rows();
  double* const target = has_gaps ? impl_->residual_values.data() : values.data();
  double* const slopes = has_gaps ? impl_->residual_slopes.data() : derivatives.data();
  impl_->columns[0] = target;
  for (int k = 0; k < parameter_count(); ++k)
    impl_->columns[static_cast<std::size_t>(1 + k)] = slopes + std::ptrdiff_t{impl_->fields().rows()} * k;
  impl_->answer(q, 1);
  if (!has_gaps) return;
  values = impl_->residual_values;
  derivatives = impl_->residual_slopes;
}

void TrajectoryQuery::residuals(std::span<const double> q, std::span<const double> observed,
                                std::span<const double> scales, std::span<double> residuals,
                                std::span<double> jacobian) {
  const auto rows = static_cast<std::size_t>(impl_->fields().rows());
  const auto d = static_cast<std::size_t>(parameter_count());
  if (observed.size() != rows || scales.size() != rows || residuals.size() != rows ||
      (!jacobian.empty() && jacobian.size() != rows * d)) {
    throw ArgumentError(fmt::format(
        "{} observations, {} scales, {} residuals and {} entries of a Jacobian, expected {} each and {} or 0",
        observed.size(), scales.size(), residuals.size(), jacobian.size(), rows, rows * d));
  }
  if (jacobian.empty()) {
    values(q, impl_->residual_values);
  } else {
    values(q, impl_->residual_values, impl_->residual_slopes);
  }
  kernels::residual_rows(impl_->residual_values.data(), impl_->residual_slopes.data(), observed.data(),
                         scales.data(), static_cast<std::ptrdiff_t>(rows), static_cast<int>(d),
                         residuals.data(), jacobian.empty() ? nullptr : jacobian.data());
}

void TrajectoryQuery::batch(const Eigen::Ref<const Eigen::MatrixXd>& points,
                            Eigen::Ref<Eigen::MatrixXd> values, int threads) {
  require_size("points", size_of(points), {parameter_count(), points.cols()});
  require_size("values", size_of(values), {impl_->fields().rows(), points.cols()});
  if (points.outerStride() != points.rows()) return batch(Eigen::MatrixXd(points), values, threads);
  if (threads == 1) return impl_->run(points, values, 0, points.cols());
  in_ranges(points.cols(), threads, [&](Eigen::Index begin, Eigen::Index end) {
    Impl(impl_->times, impl_->outputs, impl_->prepared).run(points, values, begin, end);
  });
}

void TrajectoryQuery::batch(const Eigen::Ref<const Eigen::MatrixXd>& points,
                            Eigen::Ref<Eigen::MatrixXd> values, Eigen::Ref<Eigen::MatrixXd> derivatives,
                            int threads) {
  const Eigen::Index d = parameter_count(), times = time_count(), rows = impl_->fields().rows();
  require_size("points", size_of(points), {d, points.cols()});
  require_size("values", size_of(values), {rows, points.cols()});
  require_size("derivatives", size_of(derivatives), {rows * d, points.cols()});
  const auto run = [&](TrajectoryQuery& query, Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index j = begin; j < end; ++j) {
      const std::span<const double> q(points.col(j).data(), static_cast<std::size_t>(d));
      query.values(q, Eigen::Map<Eigen::MatrixXd>(values.col(j).data(), times, output_count()),
                   Eigen::Map<Eigen::MatrixXd>(derivatives.col(j).data(), times, output_count() * d));
    }
  };
  if (threads == 1) return run(*this, 0, points.cols());
  in_ranges(points.cols(), threads, [&](Eigen::Index begin, Eigen::Index end) {
    TrajectoryQuery own(*this);
    run(own, begin, end);
  });
}

}  // namespace samara::codebooks

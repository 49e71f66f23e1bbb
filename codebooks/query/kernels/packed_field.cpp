#include "samara/codebooks/query/kernels/packed_field.h"

#include <algorithm>

namespace samara::codebooks::kernels {

namespace {

/// Products of a point with rows and first core apart, against those with both as one.
bool keeps_front(const RowForm& form) {
  if (!form.is_train) return true;
  const pgd::TrainCore& first = form.cores.front();
  const auto touched = static_cast<double>(form.axes.front().stencil_size());
  const auto rows = static_cast<double>(form.rows.rows());
  const double left = first.left, right = first.right;
  return rows * left + left * touched * right < rows * touched * right;
}

}  // namespace

template <class T>
void PackedField<T>::add_core(int left, int right, int nodes, const auto& entry) {
  Core core{left, right, padded<T>(std::ptrdiff_t{left} * right), {}};
  core.data = Buffer<T>(core.stride * nodes);
  for (int i = 0; i < nodes; ++i) {
    for (int r = 0; r < right; ++r) {
      for (int l = 0; l < left; ++l)
        core.data.data()[i * core.stride + std::ptrdiff_t{r} * left + l] = static_cast<T>(entry(i, l, r));
    }
  }
  cores_.push_back(std::move(core));
}

template <class T>
PackedField<T>::PackedField(const RowForm& form)
    : rows_(static_cast<int>(form.rows.rows())), is_train_(form.is_train), has_front_(keeps_front(form)) {
  for (const pgd::Axis& axis : form.axes) {
    axes_.emplace_back(axis);
    most_nodes_ = std::max(most_nodes_, axes_.back().size());
  }
  for (std::size_t k = 0; k < form.axes.size(); ++k) {
    const int nodes = form.axes[k].size();
    if (!is_train_) {
      add_core(static_cast<int>(form.rows.cols()), 1, nodes,
               [&](int i, int l, int) { return form.factors[k](i, l); });
      continue;
    }
    pgd::TrainCore core = form.cores[k];
    if (k == 0 && !has_front_) {
      pgd::TrainCore merged(rows_, core.size, core.right);
      merged.right_unfolding() = form.rows * core.right_unfolding();
      core = std::move(merged);
    }
    add_core(core.left, core.right, nodes, [&](int i, int l, int r) {
      return core.data[l + Eigen::Index{core.left} * (i + Eigen::Index{core.size} * r)];
    });
  }
  for (const Core& core : cores_) widest_ = std::max({widest_, core.left, core.right});
  if (!has_front_) return;
  front_rank_ = static_cast<int>(form.rows.cols());
  front_lead_ = padded<T>(rows_);
  front_ = Buffer<T>(front_lead_ * front_rank_);
  for (int r = 0; r < front_rank_; ++r)
    for (int m = 0; m < rows_; ++m) front_.data()[r * front_lead_ + m] = static_cast<T>(form.rows(m, r));
}

template <class T>
typename PackedField<T>::Workspace PackedField<T>::make_workspace() const {
  Workspace workspace;
  const int columns = column_count(axis_count(), 2);
  for (const AxisWeights& axis : axes_) workspace.axes.push_back(axis.make_workspace());
  for (Buffer<T>& weights : workspace.weights) weights = Buffer<T>(most_nodes_);
  for (const Core& core : cores_) workspace.blends.emplace_back(3 * core.stride);
  const std::ptrdiff_t lead = padded<T>(widest_);
  for (Buffer<T>& buffer : workspace.columns) buffer = Buffer<T>(lead * columns);
  workspace.block_weights = Buffer<T>(std::ptrdiff_t{most_nodes_} * kBlock<T>);
  for (Buffer<T>& buffer : workspace.block_columns)
    buffer = Buffer<T>(std::max<std::ptrdiff_t>(widest_, 1) * kBlock<T>);
  workspace.current.resize(static_cast<std::size_t>(columns));
  workspace.in.resize(static_cast<std::size_t>(columns));
  workspace.out.resize(static_cast<std::size_t>(columns));
  workspace.results.resize(static_cast<std::size_t>(columns));
  return workspace;
}

template <class T>
void PackedField<T>::blend_axis(std::size_t k, double x, int order, Workspace& workspace) const {
  const int first = axes_[k].at(x, order, workspace.axes[k]);
  const int nodes = axes_[k].size();
  const Core& core = cores_[k];
  const T* weights[3];
  T* out[3];
  for (int s = 0; s <= order; ++s) {
    const double* const given = workspace.axes[k].weights[s].data();
    if constexpr (std::is_same_v<T, double>) {
      weights[s] = given;
    } else {
      for (int j = 0; j < nodes; ++j) workspace.weights[s].data()[j] = static_cast<T>(given[j]);
      weights[s] = workspace.weights[s].data();
    }
    out[s] = workspace.blends[k].data() + s * core.stride;
  }
  blend(core.data.data() + first * core.stride, core.stride, core.stride, nodes, weights, order + 1, out);
}

/// The way of most queries: step() without derivatives, and without the bookkeeping that they need.
template <class T>
void PackedField<T>::value(const double* x, Workspace& workspace, double* values) const {
  const T* column = nullptr;
  // From the last axis on, and each product as soon as its blend is there: products wait for each other,
  // blends do not.
  for (std::size_t k = axes_.size(); k-- > 0;) {
    blend_axis(k, x[k], 0, workspace);
    const T* const matrix = workspace.blends[k].data();
    const Core& core = cores_[k];
    T* target = workspace.columns[k % 2].data();
    if (column == nullptr) {
      column = matrix;
    } else if (!is_train_) {
      scale(matrix, column, core.stride, target);
      column = target;
    } else if (k > 0 || has_front_) {
      multiply<T, T>(matrix, core.left, padded<T>(core.left), core.right, &column, 1, &target);
      column = target;
    } else {
      return multiply<T, double>(matrix, core.left, core.left, core.right, &column, 1, &values);
    }
  }
  if (has_front_)
    return multiply<T, double>(front_.data(), front_lead_, rows_, front_rank_, &column, 1, &values);
  std::copy_n(column, rows_, values);
}

/// Columns are carried from the last axis to the first. At axis k, with the blend S and its derivatives:
/// v <- S v; first derivatives by axes after k: t_m <- S t_m, and t_k = S' v; second ones h_jm <- S h_jm for
/// j, m after k, h_km = S' t_m, h_kk = S'' v.
template <class T>
void PackedField<T>::step(std::size_t k, int order, Workspace& workspace, double* const* results) const {
  const int d = axis_count();
  const auto axis = static_cast<int>(k);
  const bool is_last_step = k == 0 && !has_front_;
  const Core& core = cores_[k];
  const std::ptrdiff_t lead = padded<T>(widest_);
  const T* const blends = workspace.blends[k].data();
  T* const target = workspace.columns[k % 2].data();
  const bool starts = axis + 1 == d;
  // Where a column comes from, which derivative of S it meets, and where it goes.
  int count = 0;
  const auto go = [&](const T* matrix) {
    if (count == 0) return;
    if (is_train_) {
      if (is_last_step) {
        multiply<T, double>(matrix, core.left, core.left, core.right, workspace.in.data(), count,
                            workspace.results.data());
      } else {
        // Whole vectors: what the last one holds after the rows is never read.
        multiply<T, T>(matrix, core.left, padded<T>(core.left), core.right, workspace.in.data(), count,
                       workspace.out.data());
      }
    } else {
      for (int c = 0; c < count; ++c)
        scale(matrix, workspace.in[static_cast<std::size_t>(c)], core.stride,
              workspace.out[static_cast<std::size_t>(c)]);
    }
    count = 0;
  };
  const auto add = [&](int from, int to) {
    const auto c = static_cast<std::size_t>(count++);
    workspace.in[c] = workspace.current[static_cast<std::size_t>(from)];
    workspace.out[c] = target + lead * to;
    if (is_last_step) workspace.results[c] = results[to];
  };
  if (starts) {
    // The right rank is one: the blends are the columns.
    for (int s = 0; s <= order; ++s) {
      const int column = s == 0 ? 0 : s == 1 ? column_of_first(axis) : column_of_second(axis, axis);
      const T* const from = blends + s * core.stride;
      workspace.current[static_cast<std::size_t>(column)] = from;
      if (is_last_step) std::copy_n(from, rows_, results[column]);
    }
    return;
  }
  add(0, 0);
  for (int m = axis + 1; order > 0 && m < d; ++m) add(column_of_first(m), column_of_first(m));
  for (int m = axis + 1; order > 1 && m < d; ++m)
    for (int j = axis + 1; j <= m; ++j) add(column_of_second(j, m), column_of_second(j, m));
  go(blends);
  if (order > 0) {
    add(0, column_of_first(axis));
    for (int m = axis + 1; order > 1 && m < d; ++m) add(column_of_first(m), column_of_second(axis, m));
    go(blends + core.stride);
  }
  if (order > 1) {
    add(0, column_of_second(axis, axis));
    go(blends + 2 * core.stride);
  }
  for (int c = 0; c < column_count(d, order); ++c)
    workspace.current[static_cast<std::size_t>(c)] = target + lead * c;
}

template <class T>
void PackedField<T>::point(const double* x, int order, Workspace& workspace, double* const* columns) const {
  if (order == 0) return value(x, workspace, columns[0]);
  for (std::size_t k = axes_.size(); k-- > 0;) {
    blend_axis(k, x[k], order, workspace);
    step(k, order, workspace, columns);
  }
  if (!has_front_) return;
  multiply<T, double>(front_.data(), front_lead_, rows_, front_rank_, workspace.current.data(),
                      column_count(axis_count(), order), columns);
}

template <class T>
void PackedField<T>::block(const double* x, Workspace& workspace, double* const* columns) const {
  T* v = workspace.block_columns[0].data();
  T* next = workspace.block_columns[1].data();
  std::fill_n(v, (is_train_ ? 1 : front_rank_) * kBlock<T>, T(1));
  for (std::size_t k = axes_.size(); k-- > 0;) {
    const Core& core = cores_[k];
    const double* const at = x + k * kBlock<T>;
    const int first =
        axes_[k].block(axes_[k].cell(at[0]), at, workspace.axes[k], workspace.block_weights.data());
    const T* const data = core.data.data() + first * core.stride;
    if (is_train_) {
      contract_block(data, core.stride, core.left, core.right, axes_[k].size(),
                     workspace.block_weights.data(), v, next);
      std::swap(v, next);
    } else {
      scale_block(data, core.stride, core.left, axes_[k].size(), workspace.block_weights.data(), v);
    }
  }
  if (has_front_)
    return multiply_block<T, double>(front_.data(), front_lead_, rows_, front_rank_, v, columns);
  for (int p = 0; p < kBlock<T>; ++p) {
    if (columns[p] == nullptr) continue;
    for (int m = 0; m < rows_; ++m) columns[p][m] = static_cast<double>(v[m * kBlock<T> + p]);
  }
}

template class PackedField<double>;
template class PackedField<float>;

}  // namespace samara::codebooks::kernels

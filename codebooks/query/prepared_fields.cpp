#include "samara/codebooks/query/prepared_fields.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::codebooks {

using kernels::PackedField;

PreparedFields::PreparedFields(const Codebook& book, const Choice& choice) : choice_(choice) {
  const auto outputs = static_cast<int>(choice.outputs.size());
  rows_ = outputs * (choice.times ? static_cast<int>(choice.times->size()) : 1);
  if (book.front() != nullptr) front_ = *book.front();
  for (std::size_t k = 0; k < choice.fixed.size(); ++k) {
    const auto place = static_cast<int>(k);
    held_.push_back(choice.fixed[k].value_or(0.0));
    // Where the front moves with what is free, it does not stay at one point of its axis though it is held.
    if (is_free(k) || (front_ && place == front_->coordinate())) axis_places_.push_back(place);
    if (!is_free(k)) continue;
    free_places_.push_back(place);
    coordinates_.push_back(book.coordinates()[k]);
  }
  if (coordinates_.empty()) {
    throw ArgumentError("a query holds all coordinates of the codebook, expected one that is free");
  }
  // Pieces that a file has not given yet wait until a point falls into them. Times meet them all; of lists
  // the box does not tell what is inside.
  const bool may_wait =
      !choice.times && std::ranges::none_of(book.pieces().front().outline().axes, &pgd::Axis::is_list);
  std::vector<PieceFinder::Box> boxes;
  all_hold_the_box_ = has_one_cell_ = true;
  for (const codebooks::Piece& piece : book.pieces()) {
    const bool waits = may_wait && !piece.is_read();
    if (!holds(piece, choice_.fixed, waits)) continue;
    auto prepared = std::make_unique<Prepared>();
    prepared->source = piece;
    for (std::size_t i = 0; choice.times && i < choice.times->size(); ++i) {
      if (piece.groups().front().axes().front().contains((*choice.times)[i]))
        prepared->times.push_back(static_cast<int>(i));
    }
    if (choice.times && prepared->times.empty()) continue;
    boxes.push_back(box_of(piece, waits));
    all_hold_the_box_ = all_hold_the_box_ && is_whole_box(boxes.back());
    pieces_.push_back(std::move(prepared));
    if (!waits) look_at(piece_count() - 1);
  }
  finder_.emplace(boxes);
}

PieceFinder::Box PreparedFields::box_of(const codebooks::Piece& piece, bool by_box) const {
  PieceFinder::Box box;
  for (std::size_t k = 0; k < choice_.fixed.size(); ++k) {
    if (!is_free(k)) continue;
    box.intervals.push_back({piece.lower()[k], piece.upper()[k]});
    box.lists.emplace_back();
    if (!by_box && piece.groups().front().axes()[k].is_list())
      box.lists.back() = piece.groups().front().axes()[k];
  }
  return box;
}

bool PreparedFields::is_whole_box(const PieceFinder::Box& box) const {
  for (std::size_t k = 0; k < coordinates_.size(); ++k) {
    const bool whole = !box.lists[k] && box.intervals[k].lower == coordinates_[k].lower &&
                       box.intervals[k].upper == coordinates_[k].upper;
    if (!whole) return false;
  }
  return true;
}

/// Prepares a piece at once, in the constructor.
void PreparedFields::look_at(int piece) {
  const Prepared& prepared = at(piece);
  for (const Part& part : prepared.parts) {
    std::visit(
        [&](const auto& packed) {
          for (int k = 0; k < packed.axis_count(); ++k) {
            const pgd::Axis& axis = packed.axis(k).axis();
            has_one_cell_ = has_one_cell_ && (axis.has_elements() ? axis.elements() == 1 : !axis.is_list());
          }
        },
        part.packed);
  }
}

const PreparedFields::Prepared& PreparedFields::at(int piece) const {
  Prepared& prepared = *pieces_[static_cast<std::size_t>(piece)];
  if (prepared.is_ready.load(std::memory_order_acquire)) return prepared;
  std::call_once(prepared.once, [&] {
    prepare(prepared);
    prepared.is_ready.store(true, std::memory_order_release);
  });
  return prepared;
}

void PreparedFields::prepare(Prepared& prepared) const {
  const int times = choice_.times ? static_cast<int>(choice_.times->size()) : 1;
  int first_output = 0;
  for (const FieldGroup& group : prepared.source.groups()) {
    kernels::RowChoice asked;
    asked.fixed = choice_.fixed;
    if (front_) asked.fixed[static_cast<std::size_t>(front_->coordinate())].reset();
    if (choice_.times) {
      asked.times.emplace();
      for (const int i : prepared.times)
        asked.times->push_back((*choice_.times)[static_cast<std::size_t>(i)]);
    }
    std::vector<int> rows;
    for (std::size_t o = 0; o < choice_.outputs.size(); ++o) {
      const int place = choice_.outputs[o] - first_output;
      if (place < 0 || place >= group.output_count()) continue;
      asked.outputs.push_back(place);
      if (!choice_.times) rows.push_back(static_cast<int>(o));
      for (const int i : prepared.times) rows.push_back(i + times * static_cast<int>(o));
    }
    first_output += group.output_count();
    if (rows.empty()) continue;
    const kernels::RowForm form = row_form(group, asked);
    Part part{choice_.single ? Packed(PackedField<float>(form)) : Packed(PackedField<double>(form)),
              static_cast<int>(rows.size()),
              {}};
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (part.stretches.empty() || part.stretches.back().to + part.stretches.back().count != rows[i])
        part.stretches.push_back({static_cast<int>(i), rows[i], 0});
      ++part.stretches.back().count;
    }
    prepared.parts.push_back(std::move(part));
  }
}

const std::vector<int>& PreparedFields::times_of(int piece) const {
  return pieces_[static_cast<std::size_t>(piece)]->times;
}

int PreparedFields::inner_size() const {
  int most = 1;
  for (int piece = 0; piece < piece_count(); ++piece) {
    int sum = 0;
    for (const Part& part : at(piece).parts)
      sum += std::visit([](const auto& packed) { return packed.inner_size(); }, part.packed);
    most = std::max(most, sum);
  }
  return most;
}

int PreparedFields::cell(int piece, int axis, double x) const {
  return std::visit([&](const auto& packed) { return packed.axis(axis).cell(x); },
                    at(piece).parts.front().packed);
}

PreparedFields::Workspace PreparedFields::make_workspace() const {
  Workspace workspace;
  const int columns = PackedField<double>::column_count(axis_count(), 2);
  workspace.pieces.resize(pieces_.size());
  workspace.columns.resize(static_cast<std::size_t>(std::max(columns, block_size())));
  if (front_) {
    workspace.axis_point.resize(axis_point_size());
    workspace.on_axes.resize(rows_, columns);
    for (int c = 0; c < columns; ++c) workspace.axis_columns.push_back(workspace.on_axes.col(c).data());
  }
  for (int piece = 0; piece < piece_count(); ++piece)
    if (pieces_[static_cast<std::size_t>(piece)]->source.is_read()) scratch(piece, workspace);
  return workspace;
}

/// Scratch space of a piece; it is made when the piece is met first.
PreparedFields::Workspace::Piece& PreparedFields::scratch(int piece, Workspace& workspace) const {
  Workspace::Piece& result = workspace.pieces[static_cast<std::size_t>(piece)];
  if (result.is_made) return result;
  int largest = 0;
  for (const Part& part : at(piece).parts) {
    result.parts.push_back(
        std::visit([](const auto& packed) { return Workspace::Part(packed.make_workspace()); }, part.packed));
    if (part.stretches.size() > 1) largest = std::max(largest, part.rows);
  }
  const std::ptrdiff_t lead = kernels::padded<double>(largest);
  if (lead > workspace.lead) {
    workspace.lead = lead;
    workspace.rows = kernels::Buffer<double>(lead * static_cast<std::ptrdiff_t>(workspace.columns.size()));
  }
  result.is_made = true;
  return result;
}

/// Calls run(columns of the part's own rows), and puts what it writes into the columns of all rows.
template <class Run>
void PreparedFields::in_rows(const std::vector<Stretch>& stretches, int columns, double* const* target,
                             Workspace& workspace, const Run& run) const {
  const bool in_place = stretches.size() == 1;
  const std::ptrdiff_t lead = workspace.lead;
  double** const own = workspace.columns.data();
  for (int c = 0; c < columns; ++c) {
    own[c] = target[c] == nullptr ? nullptr
             : in_place           ? target[c] + stretches.front().to
                                  : workspace.rows.data() + c * lead;
  }
  run(own);
  if (in_place) return;
  for (int c = 0; c < columns; ++c) {
    if (target[c] == nullptr) continue;
    for (const Stretch& stretch : stretches)
      std::copy_n(own[c] + stretch.from, stretch.count, target[c] + stretch.to);
  }
}

/// The whole point stands after the one on the axes.
const double* PreparedFields::map_to_axes(const double* x, double* axis_point) const {
  double* const whole = axis_point + axis_count();
  std::copy(held_.begin(), held_.end(), whole);
  for (std::size_t i = 0; i < free_places_.size(); ++i) whole[free_places_[i]] = x[i];
  for (std::size_t a = 0; a < axis_places_.size(); ++a) axis_point[a] = whole[axis_places_[a]];
  const auto counted = std::ranges::find(axis_places_, front_->coordinate()) - axis_places_.begin();
  axis_point[counted] = front_->to_axis(whole);
  return axis_point;
}

void PreparedFields::point(int piece, const double* x, int order, Workspace& workspace,
                           double* const* columns) const {
  if (!front_) return point_on_axes(piece, x, order, workspace, columns);
  const double* const axis_point = map_to_axes(x, workspace.axis_point.data());
  if (order == 0) return point_on_axes(piece, axis_point, order, workspace, columns);
  point_on_axes(piece, axis_point, order, workspace, workspace.axis_columns.data());
  chain(order, workspace, columns);
}

/// Values and derivatives by free coordinates, of those along axes: the counted one depends on several.
void PreparedFields::chain(int order, const Workspace& workspace, double* const* columns) const {
  using Columns = Eigen::Map<Eigen::VectorXd>;
  const Eigen::MatrixXd& on = workspace.on_axes;
  FrontMap::Derivatives along;
  front_->to_axis(workspace.axis_point.data() + axis_count(), along);
  const int axes = axis_count(), free = coordinate_count();
  const auto second = [&](int a, int b) {
    return on.col(1 + axes + std::max(a, b) * (std::max(a, b) + 1) / 2 + std::min(a, b));
  };
  // Of a codebook's coordinate: its place among the numbers of `along`, or -1; and its own axis, or -1.
  const auto place_along = [&](int coordinate) {
    if (coordinate == front_->coordinate()) return 0;
    const auto other = std::ranges::find(front_->others(), coordinate, &FrontMap::Other::coordinate);
    return other == front_->others().end() ? -1 : 1 + static_cast<int>(other - front_->others().begin());
  };
  const auto axis_of = [&](int coordinate) {
    const auto at = std::ranges::find(axis_places_, coordinate) - axis_places_.begin();
    return coordinate == front_->coordinate() ? -1 : static_cast<int>(at);
  };
  const auto counted =
      static_cast<int>(std::ranges::find(axis_places_, front_->coordinate()) - axis_places_.begin());
  const auto slope = [&](int i) { return i < 0 ? 0.0 : along.first[static_cast<std::size_t>(i)]; };
  Columns(columns[0], rows_) = on.col(0);
  for (int k = 0; k < free; ++k) {
    const int of_k = free_places_[static_cast<std::size_t>(k)];
    const int own_k = axis_of(of_k), along_k = place_along(of_k);
    Columns first(columns[1 + k], rows_);
    first = slope(along_k) * on.col(1 + counted);
    if (own_k >= 0) first += on.col(1 + own_k);
    for (int j = 0; order > 1 && j <= k; ++j) {
      const int of_j = free_places_[static_cast<std::size_t>(j)];
      const int own_j = axis_of(of_j), along_j = place_along(of_j);
      Columns both(columns[1 + free + k * (k + 1) / 2 + j], rows_);
      both = slope(along_j) * slope(along_k) * second(counted, counted);
      if (along_j >= 0 && along_k >= 0) {
        both += along.second[static_cast<std::size_t>(along_j)][static_cast<std::size_t>(along_k)] *
                on.col(1 + counted);
      }
      if (own_j >= 0) both += slope(along_k) * second(own_j, counted);
      if (own_k >= 0) both += slope(along_j) * second(own_k, counted);
      if (own_j >= 0 && own_k >= 0) both += second(own_j, own_k);
    }
  }
}

void PreparedFields::point_on_axes(int piece, const double* x, int order, Workspace& workspace,
                                   double* const* columns) const {
  const std::vector<Part>& parts = at(piece).parts;
  Workspace::Piece& own = scratch(piece, workspace);
  const int count = PackedField<double>::column_count(axis_count(), order);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    in_rows(parts[p].stretches, count, columns, workspace, [&](double* const* rows) {
      std::visit(
          [&](const auto& packed) {
            using Scratch = typename std::decay_t<decltype(packed)>::Workspace;
            packed.point(x, order, *std::get_if<Scratch>(&own.parts[p]), rows);
          },
          parts[p].packed);
    });
  }
}

int PreparedFields::block_size() const {
  return choice_.single ? kernels::kBlock<float> : kernels::kBlock<double>;
}

void PreparedFields::block(int piece, const double* x, Workspace& workspace, double* const* columns) const {
  const std::vector<Part>& parts = at(piece).parts;
  Workspace::Piece& own = scratch(piece, workspace);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    in_rows(parts[p].stretches, block_size(), columns, workspace, [&](double* const* rows) {
      std::visit(
          [&](const auto& packed) {
            using Scratch = typename std::decay_t<decltype(packed)>::Workspace;
            packed.block(x, *std::get_if<Scratch>(&own.parts[p]), rows);
          },
          parts[p].packed);
    });
  }
}

BatchRun::BatchRun(const PreparedFields& fields)
    : fields_(fields),
      cells_(static_cast<std::size_t>(fields.axis_count() * kBatchChunk)),
      columns_(static_cast<std::size_t>(fields.block_size())),
      x_(std::ptrdiff_t{fields.axis_count()} * fields.block_size()),
      axis_point_(fields.axis_point_size()) {
  places_.reserve(kBatchChunk);
}

bool BatchRun::before(const Place& a, const Place& b) const {
  if (a.piece != b.piece) return a.piece < b.piece;
  const int d = fields_.axis_count();
  for (int k = 0; k < d; ++k) {
    const int left = cells_[static_cast<std::size_t>(a.point * d + k)];
    const int right = cells_[static_cast<std::size_t>(b.point * d + k)];
    if (left != right) return left < right;
  }
  return a.point < b.point;
}

bool BatchRun::same_cell(const Place& a, const Place& b) const {
  const int d = fields_.axis_count();
  const auto* const cells = cells_.data();
  return a.piece == b.piece && std::equal(cells + a.point * d, cells + a.point * d + d, cells + b.point * d);
}

void BatchRun::run(const double* points, PreparedFields::Workspace& workspace, double* values,
                   std::ptrdiff_t lead) {
  const int axes = fields_.axis_count();
  for (const Place& place : places_) {
    const double* const x = on_axes(points, place);
    for (int k = 0; k < axes; ++k)
      cells_[static_cast<std::size_t>(place.point * axes + k)] = fields_.cell(place.piece, k, x[k]);
  }
  std::sort(places_.begin(), places_.end(), [&](const Place& a, const Place& b) { return before(a, b); });
  const Place* const end = places_.data() + places_.size();
  for (const Place* first = places_.data(); first != end;) {
    const Place* last = first + 1;
    while (last != end && last - first < fields_.block_size() && same_cell(*first, *last)) ++last;
    answer(first, last, points, workspace, values, lead);
    first = last;
  }
}

void BatchRun::answer(const Place* first, const Place* last, const double* points,
                      PreparedFields::Workspace& workspace, double* values, std::ptrdiff_t lead) {
  const int d = fields_.coordinate_count();
  const auto size = static_cast<std::size_t>(fields_.block_size());
  const auto count = static_cast<std::size_t>(last - first);
  // A block costs as much as a few points, however few are in it.
  if (count * 4 <= size) {
    for (; first != last; ++first) {
      double* column = values + first->point * lead;
      fields_.point(first->piece, points + static_cast<std::ptrdiff_t>(first->point) * d, 0, workspace,
                    &column);
    }
    return;
  }
  for (std::size_t p = 0; p < size; ++p) {
    const Place& place = first[std::min(p, count - 1)];
    const double* const x = on_axes(points, place);
    for (int k = 0; k < fields_.axis_count(); ++k) x_.data()[static_cast<std::size_t>(k) * size + p] = x[k];
    columns_[p] = p < count ? values + place.point * lead : nullptr;
  }
  fields_.block(first->piece, x_.data(), workspace, columns_.data());
}

}  // namespace samara::codebooks

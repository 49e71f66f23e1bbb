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
  for (std::size_t k = 0; k < choice.fixed.size(); ++k)
    if (is_free(k)) coordinates_.push_back(book.coordinates()[k]);
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
    if (!holds_what_is_fixed(piece, waits)) continue;
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

bool PreparedFields::holds_what_is_fixed(const codebooks::Piece& piece, bool by_box) const {
  for (std::size_t k = 0; k < choice_.fixed.size(); ++k) {
    if (!choice_.fixed[k]) continue;
    const double x = *choice_.fixed[k];
    if (x < piece.lower()[k] || x > piece.upper()[k]) return false;
    if (!by_box && !piece.groups().front().axes()[k].contains(x)) return false;
  }
  return true;
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

int PreparedFields::cell(int piece, int coordinate, double x) const {
  return std::visit([&](const auto& packed) { return packed.axis(coordinate).cell(x); },
                    at(piece).parts.front().packed);
}

PreparedFields::Workspace PreparedFields::make_workspace() const {
  Workspace workspace;
  const int columns = std::max(PackedField<double>::column_count(coordinate_count(), 2), block_size());
  workspace.pieces.resize(pieces_.size());
  workspace.columns.resize(static_cast<std::size_t>(columns));
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

void PreparedFields::point(int piece, const double* x, int order, Workspace& workspace,
                           double* const* columns) const {
  const std::vector<Part>& parts = at(piece).parts;
  Workspace::Piece& own = scratch(piece, workspace);
  const int count = PackedField<double>::column_count(coordinate_count(), order);
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
      cells_(static_cast<std::size_t>(fields.coordinate_count() * kBatchChunk)),
      columns_(static_cast<std::size_t>(fields.block_size())),
      x_(std::ptrdiff_t{fields.coordinate_count()} * fields.block_size()) {
  places_.reserve(kBatchChunk);
}

bool BatchRun::before(const Place& a, const Place& b) const {
  if (a.piece != b.piece) return a.piece < b.piece;
  const int d = fields_.coordinate_count();
  for (int k = 0; k < d; ++k) {
    const int left = cells_[static_cast<std::size_t>(a.point * d + k)];
    const int right = cells_[static_cast<std::size_t>(b.point * d + k)];
    if (left != right) return left < right;
  }
  return a.point < b.point;
}

bool BatchRun::same_cell(const Place& a, const Place& b) const {
  const int d = fields_.coordinate_count();
  const auto* const cells = cells_.data();
  return a.piece == b.piece && std::equal(cells + a.point * d, cells + a.point * d + d, cells + b.point * d);
}

void BatchRun::run(const double* points, PreparedFields::Workspace& workspace, double* values,
                   std::ptrdiff_t lead) {
  const int d = fields_.coordinate_count();
  for (const Place& place : places_) {
    for (int k = 0; k < d; ++k) {
      cells_[static_cast<std::size_t>(place.point * d + k)] =
          fields_.cell(place.piece, k, points[static_cast<std::ptrdiff_t>(place.point) * d + k]);
    }
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
    for (int k = 0; k < d; ++k)
      x_.data()[static_cast<std::size_t>(k) * size + p] =
          points[static_cast<std::ptrdiff_t>(place.point) * d + k];
    columns_[p] = p < count ? values + place.point * lead : nullptr;
  }
  fields_.block(first->piece, x_.data(), workspace, columns_.data());
}

}  // namespace samara::codebooks

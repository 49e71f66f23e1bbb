#include "samara/codebooks/prepared_fields.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::codebooks {

using kernels::PackedField;

namespace {

/// Whether the coordinates that are held lie in the piece.
bool holds_fixed(const std::vector<pgd::Axis>& axes, const PreparedFields::Choice& choice) {
  for (std::size_t k = 0; k < choice.fixed.size(); ++k)
    if (choice.fixed[k] && !axes[k].contains(*choice.fixed[k])) return false;
  return true;
}

}  // namespace

PreparedFields::PreparedFields(const Codebook& book, const Choice& choice) {
  const auto outputs = static_cast<int>(choice.outputs.size());
  rows_ = outputs * (choice.times ? static_cast<int>(choice.times->size()) : 1);
  const auto is_left = [&](std::size_t k) { return !choice.fixed[k] && !(k == 0 && choice.times); };
  for (std::size_t k = 0; k < choice.fixed.size(); ++k)
    if (is_left(k)) coordinates_.push_back(book.coordinates()[k]);
  if (coordinates_.empty()) {
    throw ArgumentError("a query holds all coordinates of the codebook, expected one that is free");
  }
  std::vector<std::vector<pgd::Axis>> axes;
  for (const codebooks::Piece& piece : book.pieces()) {
    const std::vector<pgd::Axis>& all = piece.groups.front().axes();
    if (!holds_fixed(all, choice)) continue;
    std::vector<double> held;
    std::vector<int> held_at;
    for (std::size_t i = 0; choice.times && i < choice.times->size(); ++i) {
      if (!all.front().contains((*choice.times)[i])) continue;
      held.push_back((*choice.times)[i]);
      held_at.push_back(static_cast<int>(i));
    }
    if (choice.times && held.empty()) continue;
    add_piece(piece, choice, held, held_at);
    std::vector<pgd::Axis> left;
    for (std::size_t k = 0; k < all.size(); ++k)
      if (is_left(k)) left.push_back(all[k]);
    for (const pgd::Axis& axis : left) {
      const bool one = axis.has_elements() ? axis.elements() == 1 : axis.basis() == pgd::Basis::fourier;
      has_one_cell_ = has_one_cell_ && one;
    }
    axes.push_back(std::move(left));
  }
  all_hold_the_box_ = std::ranges::all_of(axes, [&](const std::vector<pgd::Axis>& piece) {
    return std::equal(piece.begin(), piece.end(), coordinates_.begin(),
                      [](const pgd::Axis& axis, const Coordinate& c) {
                        const bool is_list = !axis.has_elements() && axis.basis() != pgd::Basis::fourier;
                        return !is_list && axis.lower() == c.lower && axis.upper() == c.upper;
                      });
  });
  finder_.emplace(std::move(axes));
}

void PreparedFields::add_piece(const codebooks::Piece& piece, const Choice& choice,
                               const std::vector<double>& held, const std::vector<int>& held_at) {
  const int times = choice.times ? static_cast<int>(choice.times->size()) : 1;
  Piece prepared;
  int first_output = 0;
  for (const FieldGroup& group : piece.groups) {
    Part part{PackedField<double>({}), {}, {}};
    kernels::RowChoice asked;
    asked.fixed = choice.fixed;
    if (choice.times) asked.times = held;
    for (std::size_t o = 0; o < choice.outputs.size(); ++o) {
      const int place = choice.outputs[o] - first_output;
      if (place < 0 || place >= group.output_count()) continue;
      asked.outputs.push_back(place);
      if (!choice.times) part.rows.push_back(static_cast<int>(o));
      for (const int i : held_at) part.rows.push_back(i + times * static_cast<int>(o));
    }
    first_output += group.output_count();
    if (asked.outputs.empty()) continue;
    const kernels::RowForm form = row_form(group, asked);
    if (choice.single) {
      part.packed = PackedField<float>(form);
    } else {
      part.packed = PackedField<double>(form);
    }
    for (int i = 0; i < static_cast<int>(part.rows.size()); ++i) {
      const int to = part.rows[static_cast<std::size_t>(i)];
      if (part.stretches.empty() || part.stretches.back().to + part.stretches.back().count != to)
        part.stretches.push_back({i, to, 0});
      ++part.stretches.back().count;
    }
    largest_part_ = std::max(largest_part_, static_cast<int>(part.rows.size()));
    prepared.rows.insert(prepared.rows.end(), part.rows.begin(), part.rows.end());
    prepared.parts.push_back(std::move(part));
  }
  pieces_.push_back(std::move(prepared));
}

int PreparedFields::inner_size() const {
  int most = 1;
  for (const Piece& piece : pieces_) {
    int sum = 0;
    for (const Part& part : piece.parts)
      sum += std::visit([](const auto& packed) { return packed.inner_size(); }, part.packed);
    most = std::max(most, sum);
  }
  return most;
}

int PreparedFields::cell(int piece, int coordinate, double x) const {
  const Piece& at = pieces_[static_cast<std::size_t>(piece)];
  return std::visit([&](const auto& packed) { return packed.axis(coordinate).cell(x); },
                    at.parts.front().packed);
}

PreparedFields::Workspace PreparedFields::make_workspace() const {
  Workspace workspace;
  for (const Piece& piece : pieces_) {
    auto& parts = workspace.parts.emplace_back();
    for (const Part& part : piece.parts)
      parts.push_back(std::visit([](const auto& packed) { return Workspace::Part(packed.make_workspace()); },
                                 part.packed));
  }
  const int columns = std::max(PackedField<double>::column_count(coordinate_count(), 2), block_size());
  workspace.columns.resize(static_cast<std::size_t>(columns));
  workspace.scratch = kernels::Buffer<double>(kernels::padded<double>(largest_part_) * columns);
  return workspace;
}

/// Calls run(columns of the part's own rows), and puts what it writes into the columns of all rows.
template <class Run>
void PreparedFields::in_rows(const std::vector<Stretch>& stretches, int columns, double* const* target,
                             Workspace& workspace, const Run& run) const {
  const bool in_place = stretches.size() == 1;
  const std::ptrdiff_t lead = kernels::padded<double>(largest_part_);
  double** const own = workspace.columns.data();
  for (int c = 0; c < columns; ++c) {
    own[c] = target[c] == nullptr ? nullptr
             : in_place           ? target[c] + stretches.front().to
                                  : workspace.scratch.data() + c * lead;
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
  const auto at = static_cast<std::size_t>(piece);
  const int count = PackedField<double>::column_count(coordinate_count(), order);
  for (std::size_t p = 0; p < pieces_[at].parts.size(); ++p) {
    const Part& part = pieces_[at].parts[p];
    in_rows(part.stretches, count, columns, workspace, [&](double* const* own) {
      std::visit(
          [&](const auto& packed) {
            using Scratch = typename std::decay_t<decltype(packed)>::Workspace;
            packed.point(x, order, std::get<Scratch>(workspace.parts[at][p]), own);
          },
          part.packed);
    });
  }
}

int PreparedFields::block_size() const {
  for (const Piece& piece : pieces_)
    if (std::holds_alternative<PackedField<float>>(piece.parts.front().packed)) return kernels::kBlock<float>;
  return kernels::kBlock<double>;
}

void PreparedFields::block(int piece, const double* x, Workspace& workspace, double* const* columns) const {
  const auto at = static_cast<std::size_t>(piece);
  for (std::size_t p = 0; p < pieces_[at].parts.size(); ++p) {
    const Part& part = pieces_[at].parts[p];
    in_rows(part.stretches, block_size(), columns, workspace, [&](double* const* own) {
      std::visit(
          [&](const auto& packed) {
            using Scratch = typename std::decay_t<decltype(packed)>::Workspace;
            packed.block(x, std::get<Scratch>(workspace.parts[at][p]), own);
          },
          part.packed);
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

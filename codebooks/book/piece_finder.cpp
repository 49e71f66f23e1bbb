#include "samara/codebooks/book/piece_finder.h"

#include <algorithm>
#include <utility>

namespace samara::codebooks {

bool holds(const Piece& piece, std::span<const std::optional<double>> values, bool by_box) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!values[k]) continue;
    const double x = *values[k];
    if (x < piece.lower()[k] || x > piece.upper()[k]) return false;
    if (!by_box && !piece.groups().front().axes()[k].contains(x)) return false;
  }
  return true;
}

PieceFinder::PieceFinder(const std::vector<Box>& pieces) {
  dimensions_ = pieces.empty() ? 0 : pieces.front().intervals.size();
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    boxes_.insert(boxes_.end(), pieces[p].intervals.begin(), pieces[p].intervals.end());
    borders_.push_back(pieces[p].intervals.front().lower);
    borders_.push_back(pieces[p].intervals.front().upper);
    for (std::size_t k = 0; k < pieces[p].lists.size(); ++k)
      if (pieces[p].lists[k]) lists_.push_back({static_cast<int>(p), k, *pieces[p].lists[k]});
  }
  std::sort(borders_.begin(), borders_.end());
  borders_.erase(std::unique(borders_.begin(), borders_.end()), borders_.end());
  for (std::size_t i = 0; i < borders_.size(); ++i) {
    std::vector<int> held;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      const Interval& box = boxes_[p * dimensions_];
      const bool meets = box.lower <= borders_[i] && (box.upper >= borders_[i]);
      if (meets) held.push_back(static_cast<int>(p));
    }
    candidates_.push_back(std::move(held));
  }
}

int PieceFinder::find(const double* x) const {
  const auto at = std::lower_bound(borders_.begin(), borders_.end(), x[0]);
  if (at == borders_.end()) return -1;
  for (const int piece : candidates_[static_cast<std::size_t>(at - borders_.begin())])
    if (contains(piece, x)) return piece;
  return -1;
}

bool PieceFinder::contains(int piece, const double* x) const {
  const Interval* const box = boxes_.data() + static_cast<std::size_t>(piece) * dimensions_;
  for (std::size_t k = 0; k < dimensions_; ++k)
    if (!(x[k] >= box[k].lower && x[k] <= box[k].upper)) return false;
  return std::ranges::all_of(lists_, [&](const List& list) {
    return list.piece != piece || list.axis.contains(x[list.coordinate]);
  });
}

}  // namespace samara::codebooks

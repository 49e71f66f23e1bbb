#include "samara/codebooks/source/list_edits.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "samara/base/errors.h"

namespace samara::codebooks {

namespace {

/// Shorter parts are not worth a copy, which costs three numbers.
constexpr std::size_t kBlock = 64;
constexpr std::uint64_t kBase = 0x9E3779B97F4A7C15u;

/// Round numbers differ in their highest bits only, which a product would push out.
std::uint64_t mixed(double number) {
  const auto bits = std::bit_cast<std::uint64_t>(number);
  return (bits ^ bits >> 32) * 0xD6E8FEB86659FD93u;
}

bool are_same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// Hash of a block that moves along a list number by number (Karp and Rabin, 1987).
class RollingHash {
 public:
  explicit RollingHash(std::span<const double> list) : list_(list) {
    for (std::size_t i = 0; i < kBlock; ++i) leaving_ *= kBase;
  }
  std::uint64_t at(std::size_t begin) {
    value_ = 0;
    for (std::size_t i = 0; i < kBlock; ++i) value_ = value_ * kBase + mixed(list_[begin + i]);
    return value_;
  }
  /// From the block before.
  std::uint64_t roll_to(std::size_t begin) {
    value_ = value_ * kBase + mixed(list_[begin + kBlock - 1]) - mixed(list_[begin - 1]) * leaving_;
    return value_;
  }

 private:
  std::span<const double> list_;
  std::uint64_t value_ = 0, leaving_ = 1;
};

/// Blocks of a list side by side, by their hash.
std::unordered_map<std::uint64_t, std::size_t> blocks_of(std::span<const double> list) {
  std::unordered_map<std::uint64_t, std::size_t> blocks;
  blocks.reserve(list.size() / kBlock);
  RollingHash hash(list);
  for (std::size_t begin = 0; begin + kBlock <= list.size(); begin += kBlock)
    blocks.emplace(hash.at(begin), begin);
  return blocks;
}

/// How many numbers are the same from here on.
std::size_t common(std::span<const double> a, std::span<const double> b) {
  return static_cast<std::size_t>(std::ranges::mismatch(a, b, are_same).in1 - a.begin());
}

}  // namespace

std::vector<ListEdit> edits_between(std::span<const double> before, std::span<const double> now) {
  const auto blocks = blocks_of(before);
  std::vector<ListEdit> edits(1);
  edits[0].count = common(before, now);
  std::size_t done = edits[0].count;
  RollingHash hash(now);
  bool rolls = false;
  for (std::size_t at = done; at + kBlock <= now.size();) {
    const auto found = blocks.find(rolls ? hash.roll_to(at) : hash.at(at));
    rolls = true;
    std::size_t count = found == blocks.end() ? 0 : common(before.subspan(found->second), now.subspan(at));
    if (count < kBlock) {
      ++at;
      continue;
    }
    std::size_t from = found->second;
    for (; at > done && from > 0 && are_same(before[from - 1], now[at - 1]); --at, --from) ++count;
    edits.back().then.assign(now.begin() + static_cast<std::ptrdiff_t>(done),
                             now.begin() + static_cast<std::ptrdiff_t>(at));
    edits.push_back({from, count, {}});
    done = at += count;
    rolls = false;
  }
  edits.back().then.assign(now.begin() + static_cast<std::ptrdiff_t>(done), now.end());
  return edits;
}

void EditedList::add(std::vector<Part>& parts, Part part) const {
  if (part.count == 0) return;
  if (!parts.empty() && parts.back().first + parts.back().count == part.first) {
    parts.back().count += part.count;
  } else {
    parts.push_back(part);
  }
}

void EditedList::add_copy(std::vector<Part>& parts, const ListEdit& edit) const {
  if (edit.from > size_ || edit.count > size_ - edit.from)
    throw ArgumentError("an edit copies what is not in the list");
  if (edit.count == 0) return;
  auto p = static_cast<std::size_t>(std::ranges::upper_bound(begins_, edit.from) - begins_.begin()) - 1;
  std::size_t skipped = edit.from - begins_[p];
  for (std::size_t left = edit.count; left > 0; ++p, skipped = 0) {
    const std::size_t count = std::min(left, parts_[p].count - skipped);
    add(parts, {parts_[p].first + skipped, count});
    left -= count;
  }
}

void EditedList::apply(std::vector<ListEdit> edits) {
  std::vector<Part> parts;
  for (ListEdit& edit : edits) {
    add_copy(parts, edit);
    kept_.push_back(std::move(edit.then));
    add(parts, {kept_.back().data(), kept_.back().size()});
  }
  parts_ = std::move(parts);
  begins_.clear();
  size_ = 0;
  for (const Part& part : parts_) {
    begins_.push_back(size_);
    size_ += part.count;
  }
}

std::vector<double> EditedList::numbers() const {
  std::vector<double> all;
  all.reserve(size_);
  for (const Part& part : parts_) all.insert(all.end(), part.first, part.first + part.count);
  return all;
}

}  // namespace samara::codebooks

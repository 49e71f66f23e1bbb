#include "samara/pgd/cross/entry_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::pgd {

namespace {

constexpr int kBatch = 1024;  ///< entries that are evaluated together

}  // namespace

EntryTable::EntryTable(const EntryFunction& function, int outputs, std::vector<int> sizes,
                       std::size_t most_numbers)
    : function_(function), outputs_(outputs), sizes_(std::move(sizes)), most_numbers_(most_numbers) {
  double entries = 1.0;
  for (const int n : sizes_) entries *= n;
  if (!(entries < 0x1.0p63)) {
    throw ArgumentError(fmt::format("the grid has {:.3g} entries, expected less than 2^63", entries));
  }
}

std::uint64_t EntryTable::key(const Eigen::Ref<const Eigen::VectorXi>& entry) const {
  std::uint64_t linear = 0;
  for (std::size_t k = sizes_.size(); k-- > 0;) {
    linear = linear * static_cast<std::uint64_t>(sizes_[k]) +
             static_cast<std::uint64_t>(entry[static_cast<Eigen::Index>(k)]);
  }
  return linear;
}

void EntryTable::visit(const IndexBatch& entries,
                       const std::function<void(Eigen::Index, const double*)>& take) {
  std::vector<int> missing;                 // columns of `entries`, every unknown entry once
  std::vector<std::pair<int, int>> wanted;  // place among the missing, column
  std::unordered_map<std::uint64_t, int> places;
  for (Eigen::Index j = 0; j < entries.cols(); ++j) {
    const std::uint64_t entry = key(entries.col(j));
    if (const auto known = columns_.find(entry); known != columns_.end()) {
      take(j, known->second);
      continue;
    }
    const auto [place, is_new] = places.try_emplace(entry, static_cast<int>(missing.size()));
    if (is_new) missing.push_back(static_cast<int>(j));
    wanted.emplace_back(place->second, static_cast<int>(j));
  }
  std::ranges::sort(wanted);
  auto next = wanted.begin();
  const auto count = static_cast<int>(missing.size());
  for (int first = 0; first < count; first += kBatch) {
    const int last = std::min(first + kBatch, count);
    const IndexBatch batch =
        entries(Eigen::all, std::vector<int>(missing.begin() + first, missing.begin() + last));
    Eigen::MatrixXd values = evaluate(batch);
    for (; next != wanted.end() && next->first < last; ++next)
      take(next->second, values.col(next->first - first).data());
    remember(batch, std::move(values));
  }
}

Eigen::MatrixXd EntryTable::fetch(const IndexBatch& entries) {
  Eigen::MatrixXd result(outputs_, entries.cols());
  visit(entries, [&](Eigen::Index j, const double* values) {
    result.col(j) = Eigen::Map<const Eigen::VectorXd>(values, outputs_);
  });
  return result;
}

void EntryTable::forget() {
  columns_.clear();
  batches_.clear();
  numbers_ = 0;
}

Eigen::MatrixXd EntryTable::evaluate(const IndexBatch& missing) {
  Eigen::MatrixXd values(outputs_, missing.cols());
  function_(missing, values);
  evaluations_ += missing.cols();
  for (Eigen::Index j = 0; j < values.cols(); ++j) {
    if (values.col(j).allFinite()) {
      largest_ = std::max(largest_, values.col(j).cwiseAbs().maxCoeff());
    } else if (bad_entry_.empty()) {
      bad_entry_.assign(missing.col(j).begin(), missing.col(j).end());
    }
  }
  return values;
}

void EntryTable::remember(const IndexBatch& entries, Eigen::MatrixXd values) {
  if (numbers_ + static_cast<std::size_t>(values.size()) > most_numbers_) return;
  numbers_ += static_cast<std::size_t>(values.size());
  const Eigen::MatrixXd& batch = batches_.emplace_back(std::move(values));
  for (Eigen::Index j = 0; j < entries.cols(); ++j)
    columns_.emplace(key(entries.col(j)), batch.col(j).data());
}

}  // namespace samara::pgd

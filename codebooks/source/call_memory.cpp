#include "samara/codebooks/source/call_memory.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/unit_labels.h"

namespace samara::codebooks {

namespace {

std::string key_of(const double* point, std::size_t coordinates) {
  return {reinterpret_cast<const char*>(point), coordinates * sizeof(double)};
}

std::size_t rows_of(const SampledSource& source, const std::vector<double>& times) {
  return source.outputs.size() * std::max<std::size_t>(1, times.size());
}

/// Which output is not finite in a column, and when.
std::string not_finite(const SampledSource& source, const Eigen::VectorXd& values,
                       const std::vector<double>& times) {
  std::size_t row = 0;
  while (std::isfinite(values[static_cast<Eigen::Index>(row)])) ++row;
  const std::string when = times.empty() ? std::string()
                                         : fmt::format(" at t = {:.6g}{}", times[row / source.outputs.size()],
                                                       unit_suffix(source.time_unit));
  return fmt::format("{}{} is {}, expected a finite number", source.outputs[row % source.outputs.size()].name,
                     when, values[static_cast<Eigen::Index>(row)]);
}

}  // namespace

CallMemory::CallMemory(SampledSource source, std::vector<CallSheet> known, Save save)
    : source_(std::move(source)), sheets_(std::move(known)), save_(std::move(save)) {
  const std::size_t coordinates = source_.coordinates.size();
  for (const CallSheet& sheet : sheets_) {
    const std::size_t calls = sheet.points.size() / coordinates;
    if (sheet.points.size() != calls * coordinates ||
        sheet.values.size() != calls * rows_of(source_, sheet.times)) {
      throw ArgumentError("the calls of the checkpoint have other coordinates or outputs than the plan");
    }
    Places& places = places_.emplace_back();
    for (std::size_t j = 0; j < calls; ++j) places[key_of(&sheet.points[j * coordinates], coordinates)] = j;
  }
}

std::size_t CallMemory::sheet_of(const std::vector<double>& times) {
  for (std::size_t s = 0; s < sheets_.size(); ++s) {
    if (sheets_[s].times == times) return s;
  }
  sheets_.push_back({times, {}, {}, 0.0});
  places_.emplace_back();
  return sheets_.size() - 1;
}

CalledAnswers CallMemory::operator()(const Eigen::MatrixXd& points, const std::vector<double>& times) {
  const std::size_t sheet = sheet_of(times);
  const std::size_t coordinates = source_.coordinates.size();
  const auto key = [&](Eigen::Index j) { return key_of(points.col(j).data(), coordinates); };
  std::vector<Eigen::Index> missing;
  std::set<std::string> asked;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    if (!places_[sheet].contains(key(j)) && asked.insert(key(j)).second) missing.push_back(j);
  }
  for (std::size_t first = 0, end = 0; first < missing.size(); first = end) {
    end = std::min(first + next_batch(), missing.size());
    const std::vector<Eigen::Index> chosen(missing.begin() + static_cast<std::ptrdiff_t>(first),
                                           missing.begin() + static_cast<std::ptrdiff_t>(end));
    CalledAnswers asked_now = ask(points(Eigen::all, chosen), sheet);
    if (!asked_now.failure.empty()) return asked_now;
    save_if_cheap();
  }
  const std::size_t rows = rows_of(source_, times);
  Eigen::MatrixXd values(static_cast<Eigen::Index>(rows), points.cols());
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const std::size_t place = places_[sheet].at(key(j));
    std::copy_n(&sheets_[sheet].values[place * rows], rows, values.col(j).begin());
  }
  return {std::move(values), {}, {}};
}

double CallMemory::seconds_per_call() const {
  double seconds = 0.0;
  std::size_t calls = 0;
  for (const CallSheet& sheet : sheets_) {
    seconds += sheet.seconds;
    calls += sheet.points.size() / source_.coordinates.size();
  }
  return seconds / static_cast<double>(std::max<std::size_t>(1, calls));
}

std::size_t CallMemory::next_batch() const {
  constexpr double kFirst = 16.0;
  const double expected =
      last_seconds_per_call_ > 0.0 ? source_.batch_seconds / last_seconds_per_call_ : kFirst;
  return static_cast<std::size_t>(std::clamp(expected, 1.0, static_cast<double>(source_.batch)));
}

CalledAnswers CallMemory::ask(const Eigen::MatrixXd& points, std::size_t sheet) {
  const std::size_t coordinates = source_.coordinates.size();
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const auto failed = failures_.find(key_of(points.col(j).data(), coordinates));
    if (failed != failures_.end()) return {{}, failed->second, points.col(j)};
  }
  const Clock::time_point begin = Clock::now();
  SampledAnswers answers = source_.answers(points, sheets_[sheet].times);
  const std::chrono::duration<double> took = Clock::now() - begin;
  sheets_[sheet].seconds += took.count();
  last_seconds_per_call_ = took.count() / static_cast<double>(points.cols());
  for (Eigen::Index j = 0; j < answers.values.cols(); ++j) {
    if (answers.values.col(j).allFinite()) continue;
    answers.failure = not_finite(source_, answers.values.col(j), sheets_[sheet].times);
    answers.values = answers.values.leftCols(j).eval();
  }
  const Eigen::Index good = answers.values.cols();
  remember(points.leftCols(good), answers.values, sheet);
  if (answers.failure.empty()) return {};
  failures_[key_of(points.col(good).data(), coordinates)] = answers.failure;
  return {{}, answers.failure, points.col(good)};
}

void CallMemory::remember(const Eigen::MatrixXd& points, const Eigen::MatrixXd& values, std::size_t sheet) {
  CallSheet& kept = sheets_[sheet];
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const auto place = places_[sheet].size();
    if (!places_[sheet].try_emplace(key_of(points.col(j).data(), source_.coordinates.size()), place).second)
      continue;
    kept.points.insert(kept.points.end(), points.col(j).begin(), points.col(j).end());
    kept.values.insert(kept.values.end(), values.col(j).begin(), values.col(j).end());
    is_saved_ = false;
  }
}

void CallMemory::finish() const {
  try {
    source_.finish();
  } catch (const Error& error) {
    throw NoResultError(error.what());
  }
}

/// Storing takes at most a twentieth of the time.
void CallMemory::save_if_cheap() {
  if (Clock::now() - saved_at_ >= 20 * save_took_) save();
}

void CallMemory::save() {
  if (is_saved_ || !save_) return;
  const Clock::time_point begin = Clock::now();
  save_(sheets_);
  is_saved_ = true;
  saved_at_ = Clock::now();
  save_took_ = saved_at_ - begin;
}

}  // namespace samara::codebooks

#include "samara/codebooks/source/command_program.h"

#include <algorithm>
#include <charconv>
#include <cstring>

#include <fmt/format.h>

#include "samara/base/number_text.h"
#include "samara/base/text.h"

namespace samara::codebooks {

namespace {

std::string input_of(const Eigen::MatrixXd& points) {
  std::string text;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      text += number_text(points(k, j));
      text += k + 1 == points.rows() ? '\n' : ' ';
    }
  }
  return text;
}

/// A part of what a program printed, fit for a message.
std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::string result = "\"";
  for (const char c : text.substr(0, kLongest)) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code >= 0x7F) {
      result += fmt::format("\\x{:02x}", code);
    } else {
      result += c;
    }
  }
  return result + (text.size() > kLongest ? "..\"" : "\"");
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty()) lines.push_back(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::string last_words(const ChildResult& result) {
  const std::vector<std::string_view> lines = lines_of(result.errors);
  return lines.empty() ? "" : fmt::format("; it said {}", in_quotes(lines.back()));
}

}  // namespace

std::string CommandProgram::name() const {
  return in_quotes(command_.run.front());
}

Error CommandProgram::failure(const std::string& what, const ChildResult& result) const {
  return Error(fmt::format("the command {} {}{}", name(), what, last_words(result)));
}

Eigen::MatrixXd CommandProgram::answers(const Eigen::MatrixXd& points, Eigen::Index outputs) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Eigen::MatrixXd values(outputs, points.cols());
  for (Eigen::Index first = 0; first < points.cols(); first += command_.largest_batch) {
    const Eigen::Index count = std::min<Eigen::Index>(command_.largest_batch, points.cols() - first);
    values.middleCols(first, count) = batch(points.middleCols(first, count), outputs);
  }
  return values;
}

void CommandProgram::finish() {
  constexpr double kToEnd = 2.0;  // s
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!kept_) return;
  const ChildResult result = kept_->finish("", {.seconds = kToEnd});
  kept_.reset();
  // Words of farewell are no answers.
  const auto is_answer = [&](std::string_view line) {
    try {
      return !numbers_of(line, result).empty();
    } catch (const Error&) {
      return false;
    }
  };
  const std::vector<std::string_view> lines = lines_of(result.output);
  const auto answer = std::ranges::find_if(lines, is_answer);
  if (answer == lines.end()) return;
  throw failure(fmt::format("printed {} after its last answer, more than it was asked for: what it answered "
                            "before may belong to other points",
                            in_quotes(*answer)),
                result);
}

/// Nothing of a program that failed is used again.
Eigen::MatrixXd CommandProgram::batch(const Eigen::MatrixXd& points, Eigen::Index outputs) {
  constexpr std::size_t kBytesOfNumber = 64, kBytesBeside = 4096;
  const auto numbers = static_cast<std::size_t>(points.cols() * outputs);
  try {
    const ChildResult result = exchange(points, {command_.timeout, kBytesOfNumber * numbers + kBytesBeside});
    check_end(result, points.cols(), outputs);
    return values_of(result, points.cols(), outputs);
  } catch (...) {
    if (kept_) kept_->kill();
    kept_.reset();
    throw;
  }
}

ChildResult CommandProgram::exchange(const Eigen::MatrixXd& points, const ChildLimits& limits) {
  if (!command_.persistent) return ChildProcess(command_.run).finish(input_of(points), limits);
  if (!kept_) kept_ = std::make_unique<ChildProcess>(command_.run);
  return kept_->ask(fmt::format("{}\n{}", points.cols(), input_of(points)),
                    static_cast<std::size_t>(points.cols()), limits);
}

void CommandProgram::check_end(const ChildResult& result, Eigen::Index points, Eigen::Index outputs) const {
  const auto so_far = [&] {
    return fmt::format("after {} lines for {} points", lines_of(result.output).size(), points);
  };
  switch (result.end) {
    case ChildResult::End::not_started:
      throw failure(fmt::format("cannot be started: {}", std::strerror(result.code)), result);
    case ChildResult::End::timed_out:
      if (!command_.persistent)
        throw failure(fmt::format("did not end within {} s and was killed", command_.timeout), result);
      throw failure(fmt::format("did not answer within {} s and was killed {}; one that is kept must flush "
                                "its output after every batch",
                                command_.timeout, so_far()),
                    result);
    case ChildResult::End::too_much_output:
      throw failure(fmt::format("prints far more than the {} outputs of every point", outputs), result);
    case ChildResult::End::killed:
      throw failure(fmt::format("was ended by signal {} ({})", result.code, strsignal(result.code)), result);
    case ChildResult::End::closed:
      throw failure(fmt::format("closed its output {}", so_far()), result);
    case ChildResult::End::unasked:
      throw failure(fmt::format("printed {} before it was asked for the next points, expected a line for "
                                "every point and no other",
                                in_quotes(lines_of(result.output).front())),
                    result);
    case ChildResult::End::not_listening:
      throw failure("closed its input, expected one that reads on until it ends", result);
    case ChildResult::End::exited:
      if (result.code != 0) throw failure(fmt::format("ended with the code {}", result.code), result);
      if (command_.persistent)
        throw failure(fmt::format("ended {}, expected one that reads on until its input ends", so_far()),
                      result);
      return;
    case ChildResult::End::answered:
      return;
  }
}

Eigen::MatrixXd CommandProgram::values_of(const ChildResult& result, Eigen::Index points,
                                          Eigen::Index outputs) const {
  const std::vector<std::string_view> lines = lines_of(result.output);
  if (static_cast<Eigen::Index>(lines.size()) != points) {
    const std::string first = lines.empty() ? "" : fmt::format(", the first {}", in_quotes(lines.front()));
    throw failure(fmt::format("printed {} lines for {} points{}", lines.size(), points, first), result);
  }
  Eigen::MatrixXd values(outputs, points);
  for (std::size_t j = 0; j < lines.size(); ++j) {
    const std::vector<double> numbers = numbers_of(lines[j], result);
    if (static_cast<Eigen::Index>(numbers.size()) != outputs) {
      throw failure(fmt::format("printed the line {} with {} numbers, expected {}", in_quotes(lines[j]),
                                numbers.size(), outputs),
                    result);
    }
    std::copy(numbers.begin(), numbers.end(), values.col(static_cast<Eigen::Index>(j)).begin());
  }
  return values;
}

std::vector<double> CommandProgram::numbers_of(std::string_view line, const ChildResult& result) const {
  constexpr std::string_view kBetween = " \t,";
  std::vector<double> numbers;
  std::size_t at = line.find_first_not_of(kBetween);
  while (at != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kBetween, at), line.size());
    std::string_view word = line.substr(at, end - at);
    if (word.size() > 1 && word.starts_with('+')) word.remove_prefix(1);
    double number = 0.0;
    const auto [rest, problem] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (problem != std::errc() || rest != word.data() + word.size())
      throw failure(fmt::format("printed {}, expected numbers", in_quotes(line)), result);
    numbers.push_back(number);
    at = line.find_first_not_of(kBetween, end);
  }
  return numbers;
}

}  // namespace samara::codebooks

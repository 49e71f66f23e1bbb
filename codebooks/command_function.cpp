#include "samara/codebooks/command_function.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/child_process.h"
#include "samara/io/text.h"

namespace samara::codebooks {

namespace {

std::string input_of(const Eigen::MatrixXd& points) {
  std::string text;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      text += io::shortest_decimal(points(k, j));
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

class CommandFunction {
 public:
  explicit CommandFunction(Command command) : command_(std::move(command)) {}

  void operator()(const Eigen::MatrixXd& points, Eigen::MatrixXd& values) const {
    if (points.rows() != command_.inputs) {
      throw ArgumentError(fmt::format("the command {} takes {} inputs, the points have {}", name(),
                                      command_.inputs, points.rows()));
    }
    values.resize(command_.outputs, points.cols());
    for (Eigen::Index first = 0; first < points.cols(); first += command_.largest_batch) {
      const Eigen::Index count = std::min<Eigen::Index>(command_.largest_batch, points.cols() - first);
      values.middleCols(first, count) = batch(points.middleCols(first, count));
    }
  }

 private:
  std::string name() const { return in_quotes(command_.run.front()); }

  Error failure(const std::string& what, const ChildResult& result) const {
    return Error(fmt::format("the command {} {}{}", name(), what, last_words(result)));
  }

  Eigen::MatrixXd batch(const Eigen::MatrixXd& points) const {
    constexpr std::size_t kBytesOfNumber = 64, kBytesBeside = 4096;
    const auto numbers = static_cast<std::size_t>(points.cols()) * static_cast<std::size_t>(command_.outputs);
    const ChildResult result = run_child(command_.run, input_of(points),
                                         {command_.timeout, kBytesOfNumber * numbers + kBytesBeside});
    check_end(result);
    return values_of(result, points.cols());
  }

  void check_end(const ChildResult& result) const {
    switch (result.end) {
      case ChildResult::End::not_started:
        throw failure(fmt::format("cannot be started: {}", std::strerror(result.code)), result);
      case ChildResult::End::timed_out:
        throw failure(fmt::format("did not end within {} s and was killed", command_.timeout), result);
      case ChildResult::End::too_much_output:
        throw failure(fmt::format("prints far more than the {} outputs of every point", command_.outputs),
                      result);
      case ChildResult::End::killed:
        throw failure(fmt::format("was ended by signal {} ({})", result.code, strsignal(result.code)),
                      result);
      case ChildResult::End::exited:
        if (result.code != 0) throw failure(fmt::format("ended with the code {}", result.code), result);
    }
  }

  Eigen::MatrixXd values_of(const ChildResult& result, Eigen::Index points) const {
    const std::vector<std::string_view> lines = lines_of(result.output);
    if (static_cast<Eigen::Index>(lines.size()) != points) {
      throw failure(fmt::format("printed {} lines for {} points", lines.size(), points), result);
    }
    Eigen::MatrixXd values(command_.outputs, points);
    for (std::size_t j = 0; j < lines.size(); ++j) {
      const std::vector<double> numbers = numbers_of(lines[j], result);
      if (static_cast<int>(numbers.size()) != command_.outputs) {
        throw failure(fmt::format("printed the line {} with {} numbers, expected {}", in_quotes(lines[j]),
                                  numbers.size(), command_.outputs),
                      result);
      }
      std::copy(numbers.begin(), numbers.end(), values.col(static_cast<Eigen::Index>(j)).begin());
    }
    return values;
  }

  std::vector<double> numbers_of(std::string_view line, const ChildResult& result) const {
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

  Command command_;
};

}  // namespace

pgd::PointsFunction command_function(Command command) {
  if (command.run.empty() || command.run.front().empty())
    throw ArgumentError("the command is empty, expected a program and its arguments");
  if (command.inputs < 1 || command.outputs < 1 || command.largest_batch < 1 || !(command.timeout > 0.0) ||
      !std::isfinite(command.timeout)) {
    throw ArgumentError(fmt::format(
        "a command with {} inputs, {} outputs, batches of {} points and a timeout of {} s, expected "
        "positive numbers",
        command.inputs, command.outputs, command.largest_batch, command.timeout));
  }
  return CommandFunction(std::move(command));
}

}  // namespace samara::codebooks

#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "samara/base/errors.h"
#include "samara/codebooks/source/child_process.h"
#include "samara/codebooks/source/command_function.h"

namespace samara::codebooks {

/// The program of a command, for lines of any length: started for every batch, or once and kept. One that
/// is kept is ended when it fails, and started again by the next call.
class CommandProgram {
 public:
  /// @param command its numbers of inputs and outputs are not looked at
  explicit CommandProgram(Command command) : command_(std::move(command)) {}

  /// What it answers to the points, a column each: outputs x points. Calls from several threads wait for each
  /// other. @throws Error as command_function() says
  Eigen::MatrixXd answers(const Eigen::MatrixXd& points, Eigen::Index outputs);

  /// Ends a program that is kept. @throws Error if it printed more numbers than it was asked for: earlier
  /// answers may then belong to other points. A line that came late looks like the next answer.
  void finish();

  /// Its name in quotes, for messages.
  std::string name() const;

 private:
  Eigen::MatrixXd batch(const Eigen::MatrixXd& points, Eigen::Index outputs);
  ChildResult exchange(const Eigen::MatrixXd& points, const ChildLimits& limits);
  Error failure(const std::string& what, const ChildResult& result) const;
  void check_end(const ChildResult& result, Eigen::Index points, Eigen::Index outputs) const;
  Eigen::MatrixXd values_of(const ChildResult& result, Eigen::Index points, Eigen::Index outputs) const;
  std::vector<double> numbers_of(std::string_view line, const ChildResult& result) const;

  Command command_;
  std::mutex mutex_;
  std::unique_ptr<ChildProcess> kept_;
};

}  // namespace samara::codebooks

#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/source/checkpoint.h"
#include "samara/codebooks/source/sampled_source.h"

namespace samara::codebooks {

/// What calls at some points gave.
struct CalledAnswers {
  Eigen::MatrixXd values;  ///< a column per point: outputs fastest, then times; empty if there is a failure
  std::string failure;     ///< of the first point without an answer, or one that is not finite; empty: none
  Eigen::VectorXd point;   ///< where
};

/// A source that is never asked twice: it keeps all answers, and stores them for a build that is taken up
/// again. Sampling, told the same answers, takes the same way, so that the calls are the whole state of a
/// build by sampling.
class CallMemory {
 public:
  using Save = std::function<void(const std::vector<CallSheet>&)>;

  /// @param known answers of an earlier build  @param save empty: nothing is stored
  /// @throws ArgumentError if the known answers have other coordinates or outputs than the source
  CallMemory(SampledSource source, std::vector<CallSheet> known, Save save);

  const SampledSource& source() const { return source_; }

  /// Answers are stored from time to time.
  CalledAnswers operator()(const Eigen::MatrixXd& points, const std::vector<double>& times);

  /// What a call took on average, in an earlier build, too; 0 before the first.
  double seconds_per_call() const;

  /// Ends the source. @throws NoResultError if its answers cannot be relied on after all
  void finish() const;

  /// Stores what is not stored yet.
  void save();

 private:
  using Clock = std::chrono::steady_clock;
  using Places = std::unordered_map<std::string, std::size_t>;

  std::size_t sheet_of(const std::vector<double>& times);
  /// @returns the failure, without values
  CalledAnswers ask(const Eigen::MatrixXd& points, std::size_t sheet);
  void remember(const Eigen::MatrixXd& points, const Eigen::MatrixXd& values, std::size_t sheet);
  void save_if_cheap();

  SampledSource source_;
  std::vector<CallSheet> sheets_;
  std::vector<Places> places_;  ///< per sheet, of the points by their bytes
  /// Points that failed, with the reason, in this build: a command that hangs need not hang again for them.
  std::unordered_map<std::string, std::string> failures_;
  /// Points to be asked for at a time, as SampledSource::batch and batch_seconds have it.
  std::size_t next_batch() const;

  double last_seconds_per_call_ = 0.0;  ///< of the batch before; 0: there was none
  Save save_;
  bool is_saved_ = true;
  Clock::time_point saved_at_ = Clock::now();
  Clock::duration save_took_ = Clock::duration::zero();
};

}  // namespace samara::codebooks

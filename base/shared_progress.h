#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "samara/base/progress.h"

namespace samara {

/// Progress of work that several threads share: all of them count, the thread that made this object reports,
/// at most every 20 ms. Without a callback it costs a comparison.
class SharedProgress {
 public:
  /// @param parts number of parts of the whole work  @param callback must outlive this object
  SharedProgress(const ProgressCallback& callback, std::string stage, double parts)
      : callback_(callback), stage_(std::move(stage)), parts_(parts) {}

  /// To be called from time to time; reports every 20 ms. False once the callback asked to cancel.
  bool goes_on() {
    if (!callback_) return true;
    if (!cancelled() && std::this_thread::get_id() == caller_) report_if_due();
    return !cancelled();
  }

  /// One part is done.
  void count() {
    if (callback_) done_.fetch_add(1, std::memory_order_relaxed);
  }

  bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

 private:
  using Clock = std::chrono::steady_clock;

  void report_if_due() {
    const Clock::time_point now = Clock::now();
    if (now < due_) return;
    due_ = now + std::chrono::milliseconds(20);
    const double fraction = static_cast<double>(done_.load(std::memory_order_relaxed)) / parts_;
    if (!callback_({stage_, fraction})) cancelled_.store(true, std::memory_order_relaxed);
  }

  const ProgressCallback& callback_;
  std::string stage_;
  double parts_;
  std::thread::id caller_ = std::this_thread::get_id();
  Clock::time_point due_ = {};  ///< of the caller alone
  std::atomic<long> done_ = 0;
  std::atomic<bool> cancelled_ = false;
};

}  // namespace samara

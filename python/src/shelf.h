#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace samara::python {

/// Things that are costly to prepare and cheap to copy, such as queries, by what they were prepared for: each call
/// takes one for itself and brings it back. The few that were used last are kept. Safe to share between threads.
template <class Key, class Thing>
class Shelf {
  struct Box {
    Key key;
    Thing pattern;
    std::vector<std::unique_ptr<Thing>> idle = {};
  };

 public:
  /// A thing for one call.
  class Loan {
   public:
    Loan(Shelf& shelf, std::shared_ptr<Box> box, std::unique_ptr<Thing> thing)
        : shelf_(shelf), box_(std::move(box)), thing_(std::move(thing)) {}
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    ~Loan() {
      const std::scoped_lock lock(shelf_.mutex_);
      box_->idle.push_back(std::move(thing_));
    }
    Thing& operator*() { return *thing_; }
    Thing* operator->() { return thing_.get(); }

   private:
    Shelf& shelf_;
    std::shared_ptr<Box> box_;
    std::unique_ptr<Thing> thing_;
  };

  template <class Make>
  Loan take(const Key& key, const Make& make) {
    std::shared_ptr<Box> box;
    {
      const std::scoped_lock lock(mutex_);
      for (auto place = boxes_.begin(); place != boxes_.end(); ++place) {
        if (!((*place)->key == key)) continue;
        boxes_.splice(boxes_.begin(), boxes_, place);
        box = boxes_.front();
        break;
      }
      if (box && !box->idle.empty()) {
        std::unique_ptr<Thing> thing = std::move(box->idle.back());
        box->idle.pop_back();
        return Loan(*this, std::move(box), std::move(thing));
      }
    }
    if (!box) {
      box = std::make_shared<Box>(Box{key, make()});
      const std::scoped_lock lock(mutex_);
      boxes_.push_front(box);
      if (boxes_.size() > kKept) boxes_.pop_back();
    }
    auto thing = std::make_unique<Thing>(box->pattern);
    return Loan(*this, std::move(box), std::move(thing));
  }

 private:
  static constexpr std::size_t kKept = 8;

  std::mutex mutex_;
  std::list<std::shared_ptr<Box>> boxes_;  ///< the last one used first
};

}  // namespace samara::python

#pragma once
#include <cstdint>
#include <iterator>
#include <list>
#include <memory>
#include <mutex>

#include "stonestack/core/rooms.hpp"

namespace stonestack::core {

/// A cache that `forget_recently_used` empties; listed as long as it lives.
class Forgettable {
 public:
  Forgettable(const Forgettable&) = delete;
  Forgettable& operator=(const Forgettable&) = delete;
  /// Lets go of what is kept. What somebody else holds can still be found.
  virtual void forget() = 0;

 protected:
  Forgettable();
  virtual ~Forgettable();
};

/// Empties all caches of the process: what is made again costs time, and nothing else changes. For a count
/// of what the process holds without them.
void forget_recently_used();

/// Cache (least recently used) of values that are costly to make, by a key of all that decides them. Keeps
/// the last `max` that were used, and finds those that somebody still holds. For any thread.
template <typename T>
class RecentlyUsed final : public Forgettable {
 public:
  explicit RecentlyUsed(std::size_t max) : max_(max) {}

  /// Null when it has to be made.
  [[nodiscard]] std::shared_ptr<const T> find(std::uint64_t key) {
    const std::scoped_lock lock(mutex_);
    return find_locked(key);
  }
  /// Keeps `made`, or finds what another thread made meanwhile.
  [[nodiscard]] std::shared_ptr<const T> keep(std::uint64_t key, std::shared_ptr<const T> made) {
    const std::scoped_lock lock(mutex_);
    if (auto known = find_locked(key)) return known;
    std::erase_if(released_, [](const Released& r) { return r.value.expired(); });
    kept_.push_front({key, made});
    if (kept_.size() > max_) {
      released_.push_front({kept_.back().key, kept_.back().value});
      kept_.pop_back();
    }
    return made;
  }
  void forget() override {
    const std::scoped_lock lock(mutex_);
    for (const Kept& kept : kept_) released_.push_front({kept.key, kept.value});
    kept_.clear();
    std::erase_if(released_, [](const Released& r) { return r.value.expired(); });
  }

 private:
  struct Kept {
    std::uint64_t key = 0;
    std::shared_ptr<const T> value;
  };
  struct Released {
    std::uint64_t key = 0;
    std::weak_ptr<const T> value;
  };
  [[nodiscard]] std::shared_ptr<const T> find_locked(std::uint64_t key) {
    for (auto it = kept_.begin(); it != kept_.end(); ++it) {
      if (it->key != key) continue;
      kept_.splice(kept_.begin(), kept_, it);
      return kept_.front().value;
    }
    for (const Released& released : released_)
      if (released.key == key)
        if (auto alive = released.value.lock()) return alive;
    return nullptr;
  }

  std::size_t max_;
  std::mutex mutex_;
  std::list<Kept> kept_;  ///< last used first
  std::list<Released> released_;
};

}  // namespace stonestack::core

#pragma once
#include <tbb/collaborative_call_once.h>

#include <memory>

namespace stonestack::detection {

/// A value that is made when it is first asked for. Threads that ask meanwhile help to make it.
template <class T>
class MadeOnce {
 public:
  /// The value; the first call makes it.
  template <class Make>
  [[nodiscard]] const T& get(Make&& make) const {
    tbb::collaborative_call_once(state_->made, [&] { state_->value = make(); });
    return state_->value;
  }

 private:
  struct State {
    tbb::collaborative_once_flag made;
    T value{};
  };
  std::unique_ptr<State> state_ = std::make_unique<State>();
};

}  // namespace stonestack::detection

#pragma once
#include "stonestack/geometry/depth_image.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

class DepthCamera {
 public:
  virtual ~DepthCamera() = default;
  /// A frame exposed after the call.
  [[nodiscard]] virtual DepthFrame capture() = 0;
};

}  // namespace stonestack::hardware

#pragma GCC visibility pop

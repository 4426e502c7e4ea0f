#pragma once
#include "stonestack/core/rooms.hpp"

/// Measurements stand on the whole library and share the command's options (apps/).
namespace stonestack::apps {}
namespace stonestack::bench {
using namespace report;
using namespace apps;
}  // namespace stonestack::bench

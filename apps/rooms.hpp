#pragma once
#include "stonestack/core/rooms.hpp"

/// The command and its measurements stand on the whole library.
namespace stonestack::apps {
using namespace report;
}
namespace stonestack::bench {
using namespace report;
}

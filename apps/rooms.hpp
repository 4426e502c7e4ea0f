#pragma once
#include "stonestack/core/rooms.hpp"

/// The command stands on the whole library.
namespace stonestack::apps {
using namespace report;
}

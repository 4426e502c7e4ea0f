#pragma once
#include "stonestack/core/rooms.hpp"

/// Shared test code may use the whole library.
namespace stonestack::test {
using namespace report;
}
namespace stonestack::scripted {
using namespace report;
}
namespace stonestack::fuzz {
using namespace report;
}

#pragma once

/// Marks a class or function as part of the library's interface. Symbols of libstonestack are hidden; what a
/// public header declares is visible, because each of them stands in `#pragma GCC visibility push(default)`.
/// The macro is for the few names outside public headers that other binaries of this repository need.
#define STONESTACK_EXPORT __attribute__((visibility("default")))

#pragma once

#include "rooms.hpp"

/// Checks of stdin, stdout and stderr, which a caller may have closed.
namespace stonestack::apps {

/// Gives a standard file that the caller has closed (`>&-`) a stand-in, so that no file of ours becomes
/// stdout by its number. What is printed to a stand-in for stdout counts as lost.
void replace_closed_streams();

/// Throws FileError if not everything that was printed reached stdout (a full disk, a closed stdout).
void check_stdout();

}  // namespace stonestack::apps

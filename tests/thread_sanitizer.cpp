#include <oneapi/tbb/global_control.h>

// For the preset tsan. oneTBB's library is not instrumented: how it passes work from thread to thread is not
// seen, and every parallel loop would seem to race with what came before it. So loops run on the thread that
// calls them, and what is watched are the threads of this library's own: drivers, servers, the watch over a
// held stone.
namespace {
const oneapi::tbb::global_control kOneThread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
}

#pragma once

namespace stonestack::apps {

/// "0.1.0 (767bf62a1)": the version, and the commit that it was built from, "-dirty" with changes since; the
/// version alone where the sources are no git clone. Written by cmake/write_version.cmake.
[[nodiscard]] const char* program_version();

}  // namespace stonestack::apps

#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

/// Reading and writing whole files, so that parsers parse memory and nothing is left half-written.
namespace stonestack::core {

/// Reads a regular file of at most `max_bytes` bytes.
/// @throws FileError (missing, a folder, too large, unreadable).
[[nodiscard]] std::string read_file(const std::string& path, std::size_t max_bytes);
/// Writes to a temporary file beside `path` and renames it, so that a reader sees the old or the new file and
/// never a part; it is on the disk before it gets its name. Into a device or pipe it writes directly. Makes
/// missing folders.
/// @throws FileError
void write_file(const std::string& path, std::string_view content);
/// Throws FileError where `write_file` could not write: `path` is a folder, or the folder that exists nearest
/// above it takes no files. For a check before long work; writes nothing.
void require_writable(const std::string& path);

/// Path of a file or folder that comes with stonestack, e.g. `data_path("stones")`,
/// `data_path("robots/ur10.urdf")`. Looked for below STONESTACK_DATA, then in share/stonestack of the folder
/// that the program is installed below (PREFIX/bin), then of the one that the library is (PREFIX/lib).
/// @throws FileError naming what was tried.
[[nodiscard]] std::string data_path(const std::string& name);

}  // namespace stonestack::core

#pragma GCC visibility pop

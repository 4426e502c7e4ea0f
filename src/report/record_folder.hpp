#pragma once
#include <string>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::report {

/// The folder into which one run or one experiment writes its record, and nobody else as long as this object
/// lives: making the folder is the lock (mkdir), and one that is there already is locked by `flock`. Both end
/// with the process, however it ends.
class RecordFolder {
 public:
  /// Makes the folder, with those above it, or takes one that is there and in which nobody works.
  /// @throws FileError when it cannot be made, is no folder or takes no files, and when another process holds
  /// it.
  explicit RecordFolder(const std::string& path);
  /// Makes the first of PATH, PATH-2, PATH-3, ... that nobody else has made.
  /// @throws FileError
  [[nodiscard]] static RecordFolder make_new(const std::string& path);
  /// Removes what this object made, if it is still empty.
  ~RecordFolder();
  RecordFolder(RecordFolder&& other) noexcept;
  RecordFolder& operator=(RecordFolder&& other) noexcept;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// False for a folder that was there already.
  [[nodiscard]] bool made() const { return made_; }
  /// Keeps what is in it under another name, PATH-interrupted or PATH-interrupted-2, ..., and goes on with an
  /// empty folder.
  /// @return that name.
  /// @throws FileError
  std::string put_aside();

 private:
  RecordFolder() = default;
  /// Makes and locks the folder; false where it is there already and `only_new`.
  bool take(bool only_new);

  std::string path_;
  std::vector<std::string> made_above_;  ///< folders, the outermost first
  int lock_ = -1;
  bool made_ = false;
};

/// Renames a folder to PATH-interrupted, or PATH-interrupted-2, ..., whichever is free, and returns that
/// name.
/// @throws FileError
std::string put_aside(const std::string& path);

}  // namespace stonestack::report

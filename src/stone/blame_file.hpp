#pragma once
#include <algorithm>
#include <new>
#include <stdexcept>
#include <string>

#include "stonestack/core/error.hpp"

namespace stonestack::stone {

/// Does `work` on a mesh that came from `source`. What a mesh library throws when it meets a mesh that it was
/// not made for (CGAL: std::logic_error), or when that mesh fills the memory, becomes a FileError about it.
template <class Work>
auto blame_file(const std::string& source, const Work& work) {
  const char* remedy = "repair it in a mesh editor, or scan the stone again";
  try {
    return work();
  } catch (const InvalidArgument& problem) {
    throw FileError(source, std::string("cannot be made a stone: ") + problem.what(), remedy);
  } catch (const std::logic_error& problem) {
    std::string text = problem.what();
    std::replace(text.begin(), text.end(), '\n', ' ');
    throw FileError(source, "cannot be made a stone, the mesh library reports: " + text, remedy);
  } catch (const std::bad_alloc&) {
    throw FileError(source, "cannot be made a stone: there is not enough memory for it",
                    "reduce it in a mesh editor first");
  }
}

}  // namespace stonestack::stone

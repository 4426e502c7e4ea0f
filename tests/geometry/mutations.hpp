#pragma once
#include <string>

#include "stonestack/core/random.hpp"

namespace stonestack::geometry {

/// A damaged copy of a valid file: bytes changed, cut, doubled or moved, digits blown up.
inline std::string mutated(const std::string& valid, Random& random) {
  static const char* const kNasty[] = {"-1",   "99999999", "4294967295", "nan", "1e400",
                                       "-inf", "\n",       "\r",         "0",   " "};
  std::string file = valid;
  for (std::size_t n = 1 + random.index(4); n > 0 && !file.empty(); --n) {
    const std::size_t at = random.index(file.size());
    const std::size_t length = random.index(std::min<std::size_t>(file.size() - at, 64) + 1);
    switch (random.index(6)) {
      case 0:
        file[at] = static_cast<char>(random.index(256));
        break;
      case 1:
        file.resize(at);
        break;
      case 2:
        file.erase(at, length);
        break;
      case 3:
        file.insert(at, file.substr(at, length));
        break;
      case 4:
        file.replace(at, std::min<std::size_t>(1, file.size() - at), kNasty[random.index(10)]);
        break;
      default:
        file[at] = static_cast<char>(file[at] ^ (1 << random.index(8)));
    }
  }
  return file;
}

}  // namespace stonestack::geometry

#include "core/recently_used.hpp"

#include <vector>

namespace stonestack::core {
namespace {

struct Caches {
  std::mutex mutex;
  std::vector<Forgettable*> list;
};

Caches& caches() {
  static Caches all;
  return all;
}

}  // namespace

Forgettable::Forgettable() {
  const std::scoped_lock lock(caches().mutex);
  caches().list.push_back(this);
}

Forgettable::~Forgettable() {
  const std::scoped_lock lock(caches().mutex);
  std::erase(caches().list, this);
}

void forget_recently_used() {
  const std::scoped_lock lock(caches().mutex);
  for (Forgettable* cache : caches().list) cache->forget();
}

}  // namespace stonestack::core

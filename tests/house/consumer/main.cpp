// What a user's program does: library calls from an installed stonestack. Its argument is the folder in which
// the library, which lies elsewhere than the program, is to find data.
#include <stonestack/core/file.hpp>
#include <stonestack/core/random.hpp>
#include <stonestack/geometry/mesh.hpp>

#include <string>

int main(int count, char** arguments) {
  if (count != 2 || stonestack::core::data_path("stones") != std::string(arguments[1]) + "/stones") return 2;
  const auto box = stonestack::geometry::make_box({0.1, 0.1, 0.1});
  const double mass = stonestack::geometry::mass_properties(box, 2600.0).mass;
  return mass > 2.59 && mass < 2.61 && stonestack::core::Random(1).uniform() < 1.0 ? 0 : 1;
}

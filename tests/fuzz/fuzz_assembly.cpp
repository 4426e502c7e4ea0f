// Assemblies of COMPAS: refused with a FileError, or closed blocks and contacts that statics can take.
#include <cmath>

#include "fuzz/checks.hpp"
#include "physics/block_assembly.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::physics;
  using fuzz::check;
  static const fuzz::Scratch scratch;
  const std::string path = scratch.write("assembly.json", fuzz::text_of(data, size));
  try {
    BlockAssembly assembly = read_assembly(path);
    for (const AssemblyBlock& block : assembly.blocks) check(is_closed(block.mesh));
    if (assembly.interfaces.empty()) assembly.interfaces = find_interfaces(assembly.blocks);
    const AssemblyStatics statics = statics_of(assembly);
    for (const StaticBody& body : statics.bodies) check(body.mass > 0.0 && body.p_W_com.allFinite());
    for (const BlockContact& c : statics.contacts) {
      check(c.stiffness > 0.0 && c.contact.p_W.allFinite());
      check(std::abs(c.contact.n_W.norm() - 1.0) < 1e-6);
    }
  } catch (const FileError&) {
  }
  return 0;
}

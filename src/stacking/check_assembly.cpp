#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <utility>

#include "physics/block_assembly.hpp"
#include "stacking/block_balance.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/stacking/scene_tasks.hpp"

namespace stonestack::stacking {
namespace {

constexpr int kPushes = 16;  // horizontal directions for the margin

std::vector<std::string> listed(const std::string& text) {
  std::vector<std::string> out;
  std::string item;
  for (const char c : text + ",") {
    if (c != ',') {
      item += c;
    } else if (!item.empty()) {
      out.push_back(std::exchange(item, ""));
    }
  }
  return out;
}

AssemblyBlock& block_named(BlockAssembly& assembly, const std::string& name) {
  const auto found = std::find_if(assembly.blocks.begin(), assembly.blocks.end(),
                                  [&](const AssemblyBlock& block) { return block.name == name; });
  require(found != assembly.blocks.end(), "there is no block ", name, " among the ", assembly.blocks.size(),
          " of the assembly; the first is ", assembly.blocks.front().name);
  return *found;
}

void set_supports(BlockAssembly& assembly, const AssemblyTask& task) {
  if (!task.supports.empty())
    for (AssemblyBlock& block : assembly.blocks) block.support = false;
  for (const std::string& name : listed(task.supports)) block_named(assembly, name).support = true;
  const auto supports = std::count_if(assembly.blocks.begin(), assembly.blocks.end(),
                                      [](const AssemblyBlock& block) { return block.support; });
  if (supports == 0)
    throw FileError(task.path, "marks no block as support (is_support)", "name them with --supports 0,1");
}

void set_densities(BlockAssembly& assembly, const std::string& densities) {
  for (const std::string& item : listed(densities)) {
    const auto equals = item.find('=');
    double density = 0.0;
    const char* end = item.data() + item.size();
    const bool read =
        equals != std::string::npos && std::from_chars(item.data() + equals + 1, end, density).ptr == end;
    require(read && density > 0.0 && std::isfinite(density), "a density must read BLOCK=NUMBER, got ", item);
    block_named(assembly, item.substr(0, equals)).density = density;
  }
}

}  // namespace

BlockBalance block_balance(std::span<const StaticBody> bodies, std::span<const BlockContact> contacts,
                           double friction, const Eigen::Vector3d& down_W) {
  CoupledAnalysis found = analyse_coupled(bodies, contacts, friction, kPushes, down_W);
  BlockBalance out;
  out.stands = found.rest.stands;
  out.unbalanced = found.rest.unbalanced;
  out.moving = found.rest.moving;
  out.margin = found.margin;
  out.direction = found.direction;
  out.min_friction = found.min_friction;
  out.weakest_contact = found.weakest_contact;
  out.bodies.assign(bodies.begin(), bodies.end());
  for (const BlockContact& c : contacts) out.contacts.push_back(c.contact);
  out.forces_W = std::move(found.rest.forces_W);
  return out;
}

bool is_assembly(const std::string& path) {
  if (!path.ends_with(".json")) return false;
  std::ifstream file(path);
  if (!file) throw FileError(path, "cannot be read", "check the path");
  std::string start(4096, ' ');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  return start.find("stonestack.scene") == std::string::npos;
}

AssemblyCheck check_assembly(const AssemblyTask& task) {
  require(std::isfinite(task.friction) && task.friction >= 0.0, "friction must not be negative, got ",
          task.friction);
  BlockAssembly assembly = read_assembly(task.path);
  set_supports(assembly, task);
  set_densities(assembly, task.densities);
  AssemblyCheck out;
  out.friction = task.friction;
  out.tilt = task.tilt;
  out.interfaces_given = !assembly.interfaces.empty();
  if (!out.interfaces_given) assembly.interfaces = find_interfaces(assembly.blocks);
  out.interfaces = static_cast<int>(assembly.interfaces.size());
  if (out.interfaces == 0 && assembly.blocks.size() > 1)
    throw FileError(
        task.path, "no two blocks share a face, and the file names no interfaces",
        "stones that touch in points are checked as a scene file, blocks with interfaces on edges");
  const AssemblyStatics statics = statics_of(assembly);
  out.balance = block_balance(statics.bodies, statics.contacts, task.friction,
                              {-std::sin(task.tilt), 0.0, -std::cos(task.tilt)});
  out.block_of_body = statics.blocks;
  for (AssemblyBlock& block : assembly.blocks)
    out.blocks.push_back({block.name, std::move(block.mesh), block.support});
  return out;
}

}  // namespace stonestack::stacking

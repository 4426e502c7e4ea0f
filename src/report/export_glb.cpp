#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "report/export_formats.hpp"
#include "report/text.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "glTF and MCAP are little-endian");

// Constants of glTF 2.0 (Khronos, specification 2.0.1).
constexpr std::uint32_t kGlbMagic = 0x46546C67, kGlbVersion = 2, kJsonChunk = 0x4E4F534A,
                        kBinaryChunk = 0x004E4942;
constexpr int kGltfFloat = 5126, kGltfUnsignedInt = 5125, kVertexTarget = 34962, kIndexTarget = 34963;

void put_number(std::string& bytes, std::uint32_t value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Buffer of a glTF file with its views and accessors.
struct GltfBuffer {
  std::string bytes;
  json views = json::array(), accessors = json::array();

  /// Appends numbers and returns the index of their accessor. `width` numbers make an element of `type`.
  template <class Number>
  std::size_t add(const std::vector<Number>& values, std::size_t width, const char* type, int target) {
    constexpr bool real = std::is_floating_point_v<Number>;
    json view{{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(Number)}};
    if (target != 0) view["target"] = target;
    json low = json::array(), high = json::array();
    for (std::size_t k = 0; k < width; ++k) {
      Number least = std::numeric_limits<Number>::max(), most = std::numeric_limits<Number>::lowest();
      for (std::size_t i = k; i < values.size(); i += width) {
        least = std::min(least, values[i]);
        most = std::max(most, values[i]);
      }
      low.push_back(least);
      high.push_back(most);
    }
    accessors.push_back({{"bufferView", views.size()},
                         {"componentType", real ? kGltfFloat : kGltfUnsignedInt},
                         {"count", values.size() / width},
                         {"type", type},
                         {"min", low},
                         {"max", high}});
    views.push_back(view);
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
    return accessors.size() - 1;
  }
};

std::size_t add_mesh(GltfBuffer& buffer, json& meshes, const RecordedStone& stone) {
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  for (const auto& v : stone.mesh.vertices)
    for (const double x : v) positions.push_back(static_cast<float>(x));
  for (const auto& face : stone.mesh.faces)
    for (const int corner : face) indices.push_back(static_cast<std::uint32_t>(corner));
  const std::size_t vertex = buffer.add(positions, 3, "VEC3", kVertexTarget);
  const std::size_t index = buffer.add(indices, 1, "SCALAR", kIndexTarget);
  meshes.push_back(
      {{"name", stone.name},
       {"primitives", {{{"attributes", {{"POSITION", vertex}}}, {"indices", index}, {"material", 0}}}}});
  return meshes.size() - 1;
}

/// Times, positions and quaternions. A stone stays where it was until shortly before it is found elsewhere.
struct Track {
  std::vector<float> time, position, turn;
};
Track track_of(const std::vector<Keyframe>& motion) {
  constexpr double kCarried = 0.5, kJump = 0.01;  // s: samples of a motion are nearer; s before a new view
  Track track;
  Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
  const auto put = [&](double time, const Pose& pose) {
    Eigen::Quaterniond q(pose.linear());
    if (q.dot(last) < 0) q.coeffs() *= -1;  // the short way round between two keys
    last = q;
    track.time.push_back(static_cast<float>(time));
    for (const double x : pose.translation()) track.position.push_back(static_cast<float>(x));
    q.normalize();
    for (const double x : q.coeffs()) track.turn.push_back(static_cast<float>(x));
  };
  for (std::size_t i = 0; i < motion.size(); ++i) {
    if (i > 0 && motion[i].time - motion[i - 1].time > kCarried)
      put(motion[i].time - kJump, motion[i - 1].T_W_O);
    put(motion[i].time, motion[i].T_W_O);
  }
  return track;
}

void put_chunk(std::string& file, std::uint32_t type, std::string content, char padding) {
  content.resize((content.size() + 3) / 4 * 4, padding);
  put_number(file, static_cast<std::uint32_t>(content.size()));
  put_number(file, type);
  file += content;
}

}  // namespace

std::string to_glb(const RunRecord& record) {
  GltfBuffer buffer;
  json meshes = json::array(), channels = json::array(), samplers = json::array(), children = json::array();
  const double half = std::sqrt(0.5);  // glTF has y up, W has z up: a quarter turn about x
  json nodes = json::array({{{"name", "world"}, {"rotation", {-half, 0.0, 0.0, half}}}});
  for (const RecordedStone& stone : record.stones) {
    if (stone.motion.empty() || stone.mesh.faces.empty()) continue;
    const std::size_t node = nodes.size();
    const Track track = track_of(stone.motion);
    const Pose& end = stone.motion.back().T_W_O;
    const Eigen::Quaterniond q(end.linear());
    nodes.push_back({{"name", stone.name},
                     {"mesh", add_mesh(buffer, meshes, stone)},
                     {"translation", {end.translation().x(), end.translation().y(), end.translation().z()}},
                     {"rotation", {q.x(), q.y(), q.z(), q.w()}},
                     {"extras", {{"level", stone.level}}}});
    children.push_back(node);
    const std::size_t time = buffer.add(track.time, 1, "SCALAR", 0);
    const std::size_t position = buffer.add(track.position, 3, "VEC3", 0);
    const std::size_t turn = buffer.add(track.turn, 4, "VEC4", 0);
    for (const auto& [output, path] : {std::pair{position, "translation"}, std::pair{turn, "rotation"}}) {
      channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", node}, {"path", path}}}});
      samplers.push_back({{"input", time}, {"output", output}, {"interpolation", "LINEAR"}});
    }
  }
  json document{
      {"asset", {{"version", "2.0"}, {"generator", "stonestack"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"extras",
       {{"robot", record.robot}, {"seed", record.seed}, {"height", record.height}, {"ended", record.ended}}}};
  if (!meshes.empty()) {
    nodes[0]["children"] = children;
    document["meshes"] = meshes;
    document["materials"] = {
        {{"name", "stone"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.72, 0.68, 0.6, 1.0}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.9}}}}};
    document["animations"] = {{{"name", "run"}, {"channels", channels}, {"samplers", samplers}}};
    document["accessors"] = buffer.accessors;
    document["bufferViews"] = buffer.views;
    document["buffers"] = {{{"byteLength", buffer.bytes.size()}}};
  }
  document["nodes"] = nodes;
  std::string chunks;
  put_chunk(chunks, kJsonChunk, document.dump(), ' ');
  if (!buffer.bytes.empty()) put_chunk(chunks, kBinaryChunk, buffer.bytes, '\0');
  std::string file;
  for (const std::uint32_t number : {kGlbMagic, kGlbVersion, static_cast<std::uint32_t>(chunks.size() + 12)})
    put_number(file, number);
  return file + chunks;
}

}  // namespace stonestack::report

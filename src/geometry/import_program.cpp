// stonestack-import: reads what a mesh file of a foreign format holds, in a process of its own, since assimp
// crashes, hangs and opens other files on hostile input (Debian 12's 5.2.5 carries no security fix).
//
//   stonestack-import EXTENSION < FILE > MESH.ply
//
// Before a byte is parsed the process can have no more than 1 GiB, 10 s of CPU and the three files that it
// was given: it can open none. Exit code 1 with one line on stderr where the file cannot be read, 0
// with a line where assimp repaired something. What comes out is read again by the strict PLY reader of the
// library (geometry/mesh_import).
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <assimp/DefaultLogger.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <new>
#include <string>
#include <string_view>
#include <vector>

namespace {

constexpr std::size_t kProgramMaxFile = 64U << 20U;
constexpr rlim_t kMemory = 1U << 30U;     // bytes
constexpr rlim_t kProcessorSeconds = 10;  // assimp needs 0.1 s to start, hostile files never end
constexpr rlim_t kMaxResult = 256U << 20U;
constexpr rlim_t kOpenFiles = 3;  // stdin, stdout, stderr: nothing else can be opened

/// Serves the one file that was given, whatever it says of others.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(std::string name, const std::vector<std::uint8_t>& content)
      : name_(std::move(name)), content_(content) {}
  bool Exists(const char* file) const override { return name_ == file; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (name_ == file && std::strchr(mode, 'w') == nullptr)
      return new Assimp::MemoryIOStream(content_.data(), content_.size());
    if (asked_for_.empty()) asked_for_ = file;
    return nullptr;
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }
  /// The first other file that was asked for.
  [[nodiscard]] const std::string& asked_for() const { return asked_for_; }

 private:
  std::string name_;
  const std::vector<std::uint8_t>& content_;
  std::string asked_for_;
};

/// The first thing that assimp holds for an error and yet goes on, such as an index out of range.
class FirstError : public Assimp::LogStream {
 public:
  explicit FirstError(std::string* text) : text_(text) {}
  void write(const char* message) override {
    const std::string_view line = message;  // "Error, T0: OFF: ..."
    if (text_->empty()) *text_ = line.substr(std::min(line.size(), line.find(": ") + 2));
  }

 private:
  std::string* text_;
};

int refuse(const std::string& why) {
  std::fprintf(stderr, "%s\n", why.substr(0, 300).c_str());
  return 1;
}

/// A sanitizer reserves terabytes of addresses for its shadow, and opens files to look for leaks.
#ifdef STONESTACK_SANITIZED
constexpr rlim_t kAddresses = RLIM_INFINITY, kFiles = 256;
#else
constexpr rlim_t kAddresses = kMemory, kFiles = kOpenFiles;
#endif

bool restrict_this_process() {
  const auto limit = [](int what, rlim_t value) {
    const rlimit both{value, value};
    return ::setrlimit(static_cast<__rlimit_resource>(what), &both) == 0;
  };
  return limit(RLIMIT_CORE, 0) && limit(RLIMIT_AS, kAddresses) && limit(RLIMIT_CPU, kProcessorSeconds) &&
         limit(RLIMIT_FSIZE, kMaxResult) && limit(RLIMIT_NOFILE, kFiles) &&
         ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0;
}

bool read_all(std::vector<std::uint8_t>& content) {
  std::array<std::uint8_t, 65536> block{};
  while (content.size() <= kProgramMaxFile) {
    const ssize_t got = ::read(STDIN_FILENO, block.data(), block.size());
    if (got == 0) return true;
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    content.insert(content.end(), block.begin(), block.begin() + got);
  }
  return false;
}

bool write_all(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(put));
  }
  return true;
}

template <class T>
void append(std::string& file, T value) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), &value, sizeof(T));  // PLY says below which end comes first
  file.append(bytes.data(), bytes.size());
}

/// All triangles of the scene, placed by its nodes. Indices are checked by who reads it.
std::string as_ply(const aiScene& scene) {
  std::size_t vertices = 0, faces = 0;
  std::string corners, points;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      append(corners, std::uint8_t{3});
      for (unsigned k = 0; k < 3; ++k)
        append(corners,
               static_cast<std::int32_t>(std::min<std::size_t>(vertices + face.mIndices[k], 0x7fffffff)));
      ++faces;
    }
    for (unsigned v = 0; v < mesh.mNumVertices; ++v)
      for (const ai_real x : {mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z})
        append(points, static_cast<double>(x));
    vertices += mesh.mNumVertices;
  }
  const std::uint16_t one = 1;
  std::uint8_t first = 0;
  std::memcpy(&first, &one, 1);
  return std::string("ply\nformat binary_") + (first == 1 ? "little" : "big") +
         "_endian 1.0\nelement vertex " + std::to_string(vertices) +
         "\nproperty double x\nproperty double y\nproperty double z\nelement face " + std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nend_header\n" + points + corners;
}

int import(const std::string& extension, const std::vector<std::uint8_t>& content) {
  const std::string name = "mesh." + extension;
  auto* file = new OneFile(name, content);  // the importer deletes it
  std::string repaired;
  Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0)
      ->attachStream(new FirstError(&repaired), Assimp::Logger::Err);
  Assimp::Importer importer;
  importer.SetIOHandler(file);
  // Coordinates are as in the file: a Collada file's z stays z (its unit is applied by assimp).
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(
      name, aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_PreTransformVertices);
  if (!file->asked_for().empty()) return refuse("names another file, '" + file->asked_for() + "'");
  if (scene == nullptr) return refuse(std::string("cannot be read: ") + importer.GetErrorString());
  if ((scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0) return refuse("holds no complete scene");
  if (!repaired.empty()) std::fprintf(stderr, "%s\n", repaired.substr(0, 300).c_str());
  return write_all(as_ply(*scene)) ? 0 : refuse("its mesh could not be handed on");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fputs(
        "stonestack-import: a mesh file that assimp reads becomes a PLY file\n"
        "Usage: stonestack-import EXTENSION < FILE > MESH.ply\n"
        "Example: stonestack-import dae < stand.dae > stand.ply\n"
        "stonestack starts it by itself; nothing but the file on stdin is opened.\n",
        argc == 2 && std::string_view(argv[1]) == "--help" ? stdout : stderr);
    return argc == 2 && std::string_view(argv[1]) == "--help" ? 0 : 2;
  }
  try {
    if (!restrict_this_process()) return refuse("the importer could not restrict itself");
    std::vector<std::uint8_t> content;
    if (!read_all(content)) return refuse("is larger than 64 MiB or cannot be read");
    return import(argv[1], content);
  } catch (const std::bad_alloc&) {
    return refuse("needs more than 1 GiB to be read");
  } catch (const std::exception& error) {
    return refuse(std::string("cannot be read: ") + error.what());
  }
}

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "geometry/camera_check.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kPngMaxFile = 256U << 20U;
constexpr double kMaxCounts = 65535.0;

/// libpng reports errors by a long jump; nothing with a destructor may live in the functions that it leaves.
struct Message {
  std::array<char, 160> text{};
};

void note_error(png_structp png, png_const_charp what) {
  auto* message = static_cast<Message*>(png_get_error_ptr(png));
  std::strncpy(message->text.data(), what, message->text.size() - 1);
  png_longjmp(png, 1);
}
void ignore_warning(png_structp /*png*/, png_const_charp /*what*/) {}

struct Source {
  const char* at;
  std::size_t left;
};

void read_bytes(png_structp png, png_bytep out, std::size_t count) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (count > source->left) png_error(png, "the file ends too early");
  std::memcpy(out, source->at, count);
  source->at += count;
  source->left -= count;
}

void append_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  try {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
  } catch (const std::bad_alloc&) {
    png_error(png, "out of memory");
  }
}
void flush_nothing(png_structp /*png*/) {}

/// Decodes into `bytes` (2 big-endian bytes a pixel). False with a message when it is not such a picture.
bool decode(Source source, const CameraIntrinsics& camera, unsigned char* bytes, Message& message) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &message, note_error, ignore_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_read_struct(&png, &info, nullptr);
    return false;
  }
  png_set_read_fn(png, &source, read_bytes);
  png_set_user_limits(png, 16384, 16384);
  // Text and colours carry no depth, and libpng allocates as much as such a chunk announces: its
  // limit is only a warning.
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(png, info);
  if (png_get_bit_depth(png, info) != 16 || png_get_color_type(png, info) != PNG_COLOR_TYPE_GRAY)
    png_error(png, "not a 16-bit greyscale picture");
  if (png_get_interlace_type(png, info) != PNG_INTERLACE_NONE) png_error(png, "an interlaced picture");
  if (png_get_image_width(png, info) != static_cast<unsigned>(camera.width) ||
      png_get_image_height(png, info) != static_cast<unsigned>(camera.height)) {
    std::snprintf(message.text.data(), message.text.size(),
                  "a picture of %u x %u, but the camera has %d x %d", png_get_image_width(png, info),
                  png_get_image_height(png, info), camera.width, camera.height);
    png_longjmp(png, 1);
  }
  const auto row_bytes = 2 * static_cast<std::size_t>(camera.width);
  for (int v = 0; v < camera.height; ++v)
    png_read_row(png, bytes + static_cast<std::size_t>(v) * row_bytes, nullptr);
  png_read_end(png, nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
  return true;
}

bool encode(const unsigned char* bytes, const CameraIntrinsics& camera, std::string& out, Message& message) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &message, note_error, ignore_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &out, append_bytes, flush_nothing);
  png_set_IHDR(png, info, static_cast<unsigned>(camera.width), static_cast<unsigned>(camera.height), 16,
               PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  const auto row_bytes = 2 * static_cast<std::size_t>(camera.width);
  for (int v = 0; v < camera.height; ++v) png_write_row(png, bytes + static_cast<std::size_t>(v) * row_bytes);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

void require_unit(double unit) {
  require(unit > 0.0 && std::isfinite(unit), "the depth unit must be positive, got ", unit, " m");
}

}  // namespace

void write_depth_png(const std::string& path, const DepthImage& image, double unit) {
  require_usable(image);
  require_unit(unit);
  std::vector<unsigned char> bytes;
  bytes.reserve(2 * image.z.size());
  for (const float z : image.z) {
    const double rounded = std::round(static_cast<double>(z) / unit);
    const bool fits = rounded >= 0.0 && rounded <= kMaxCounts;  // false for NaN
    const auto count = static_cast<unsigned>(fits ? rounded : 0.0);
    bytes.push_back(static_cast<unsigned char>(count >> 8U));
    bytes.push_back(static_cast<unsigned char>(count & 255U));
  }
  std::string file;
  Message message;
  if (!encode(bytes.data(), image.camera, file, message))
    throw FileError(path, concat("the depth image cannot be encoded: ", message.text.data()),
                    "free some memory");
  write_file(path, file);
}

DepthImage read_depth_png(const std::string& path, const CameraIntrinsics& camera, double unit) {
  require_unit(unit);
  DepthImage image = make_empty_image(camera);
  const std::string file = read_file(path, kPngMaxFile);
  std::vector<unsigned char> bytes(2 * image.z.size());
  Message message;
  if (!decode({file.data(), file.size()}, camera, bytes.data(), message))
    throw FileError(path, concat("not a depth image: ", message.text.data()),
                    "give a 16-bit greyscale PNG of the camera's size");
  for (std::size_t i = 0; i < image.z.size(); ++i)
    image.z[i] = static_cast<float>(unit * (bytes[2 * i] * 256.0 + bytes[2 * i + 1]));
  return image;
}

}  // namespace stonestack::geometry

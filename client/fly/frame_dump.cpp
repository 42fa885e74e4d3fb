#include "client/fly/frame_dump.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string_view>
#include <system_error>

#include "base/bytes.h"

namespace foreland::client {

namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

Error ioError(const std::filesystem::path& path, const char* what) {
  return {ErrorCode::kIo, path.string() + ": " + what + ": " + std::strerror(errno) +
                              "; choose a folder that can be written to and has room"};
}

// `mode` as for fopen. Closing is part of writing: a full disk may show only there.
Status writeAll(const std::filesystem::path& path, ByteSpan bytes, const char* mode) {
  File file(std::fopen(path.c_str(), mode), &std::fclose);
  if (!file) return ioError(path, "cannot be opened");
  // fwrite takes no null pointer, not even for no bytes.
  const bool wrote = bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  if (std::fclose(file.release()) != 0 || !wrote) return ioError(path, "cannot be written");
  return {};
}

ByteSpan bytesOf(std::string_view text) { return {reinterpret_cast<const uint8_t*>(text.data()), text.size()}; }

template <class... Args>
std::string format(const char* pattern, Args... args) {
  std::string out(1024, '\0');
  out.resize(static_cast<size_t>(std::snprintf(out.data(), out.size(), pattern, args...)));
  return out;
}

}  // namespace

Bytes encodePly(const KeyframeMesh& mesh, double weight) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment metres in the scene frame: x east, y north, z up at its origin\n"
      "element vertex " +
      std::to_string(mesh.parameters.size()) +
      "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
      std::to_string(mesh.triangleCount()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  Bytes out;
  out.reserve(header.size() + mesh.parameters.size() * 24 + mesh.triangleCount() * 13);
  ByteWriter writer(out);
  writer.putBytes(bytesOf(header));
  for (size_t i = 0; i < mesh.parameters.size(); ++i) {
    const glm::dvec3 p = mesh.origin + glm::dvec3(mesh.at(i, weight));
    writer.put(p.x), writer.put(p.y), writer.put(p.z);
  }
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    writer.put<uint8_t>(3);
    for (size_t k = 0; k < 3; ++k) writer.put(static_cast<int32_t>(mesh.indices[i + k]));
  }
  return out;
}

Status writeFileWhole(const std::filesystem::path& path, ByteSpan bytes) {
  std::filesystem::path unfinished = path;
  unfinished += ".unfinished";
  std::error_code error;
  if (Status s = writeAll(unfinished, bytes, "wb"); !s.ok()) {
    std::filesystem::remove(unfinished, error);
    return s;
  }
  std::filesystem::rename(unfinished, path, error);
  if (!error) return {};
  std::error_code ignored;
  std::filesystem::remove(unfinished, ignored);
  return Error{ErrorCode::kIo, path.string() + ": cannot be written: " + error.message()};
}

Result<FrameDump> FrameDump::create(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error || !std::filesystem::is_directory(directory))
    return Error{ErrorCode::kIo, directory.string() + ": cannot be made a folder for frames" +
                                     (error ? ": " + error.message() : "") + "; choose another for --dump"};
  if (Status s = writeFileWhole(directory / "frames.jsonl", {}); !s.ok()) return s.error();
  return FrameDump(directory);
}

Status FrameDump::write(const Frame& frame, const FrameView& view, const proto::ViewRequest& request) {
  const std::string name = format("frame_%06llu.ply", static_cast<unsigned long long>(frame.number));
  if (Status s = writeFileWhole(directory_ / name, encodePly(*view.mesh, view.weight)); !s.ok()) return s;
  const glm::dvec3& eye = view.pose.eye;
  const glm::dquat& q = view.pose.orientation;
  const std::string line =
      format("{\"file\":\"%s\",\"frame\":%llu,\"time_s\":%.6f,\"shown_time_s\":%.6f,\"eye_m\":[%.17g,%.17g,%.17g],",
             name.c_str(), static_cast<unsigned long long>(frame.number), frame.time_s, frame.shown_time_s, eye.x,
             eye.y, eye.z) +
      format("\"orientation_wxyz\":[%.17g,%.17g,%.17g,%.17g],\"vertical_fov_rad\":%.17g,\"viewport_px\":[%u,%u],", q.w,
             q.x, q.y, q.z, request.lens.vertical_fov_rad, request.lens.width_px, request.lens.height_px) +
      format("\"strategy\":\"%s\",\"tolerance_px\":%.9g,\"weight\":%.9g,\"keyframes\":[%u,%u]}\n",
             proto::name(request.strategy), static_cast<double>(view.mesh->to.frameTolerance()),
             static_cast<double>(view.weight), view.mesh->from.index, view.mesh->to.index);
  if (Status s = writeAll(directory_ / "frames.jsonl", bytesOf(line), "ab"); !s.ok()) return s;
  ++written_;
  return {};
}

}  // namespace foreland::client

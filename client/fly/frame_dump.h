// Writes what is drawn, so that other tools can judge it: a frame's interpolated mesh as binary PLY (metres,
// scene frame) and a line of frames.jsonl with its camera. docs/FLY.md describes both. A PLY appears whole under its
// name or not at all, and its line is written after it. One owner.
#pragma once

#include <filesystem>
#include <string>

#include "base/result.h"
#include "client/viewer.h"

namespace foreland::client {

// The interpolated mesh, mix(from, to, weight): double coordinates, triangles counter-clockwise seen from above.
Bytes encodePly(const KeyframeMesh& mesh, double weight);

// Writes a file whole: to a name beside it first, then renamed.
Status writeFileWhole(const std::filesystem::path& path, ByteSpan bytes);

class FrameDump {
 public:
  // Makes the folder if need be and begins frames.jsonl anew. An Error if it cannot be written to.
  static Result<FrameDump> create(const std::filesystem::path& directory);

  struct Frame {
    uint64_t number = 0;  // counts shown frames from 0
    double time_s = 0;    // since the flight began
    double shown_time_s = 0;
  };
  // `view.mesh` is not nullptr.
  Status write(const Frame& frame, const FrameView& view, const proto::ViewRequest& request);
  uint64_t written() const { return written_; }

 private:
  explicit FrameDump(std::filesystem::path directory) : directory_(std::move(directory)) {}

  std::filesystem::path directory_;
  uint64_t written_ = 0;
};

}  // namespace foreland::client

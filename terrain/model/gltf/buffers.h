// The bytes and numbers behind a glTF document. Every range is checked before it is read. One owner.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/model/gltf/document.h"
#include "terrain/model/read_model.h"

namespace foreland::terrain {

class GltfBuffers {
 public:
  // `binary`: the buffer of a .glb. Document, binary and reader must outlive this.
  GltfBuffers(const GltfDocument& document, ByteSpan binary, const FileReader& read_file)
      : document_(document),
        binary_(binary),
        read_file_(read_file),
        buffers_(document.buffers.size()),
        views_(document.views.size()) {}

  // The bytes of a view, unpacked; valid as long as this. Buffers are read when they are first needed.
  Result<ByteSpan> view(uint32_t view);

  // The components of all elements, normalised where the accessor says so. Errors name the accessor.
  Result<std::vector<double>> numbers(uint32_t accessor);
  Result<std::vector<uint32_t>> indices(uint32_t accessor);

 private:
  Result<ByteSpan> buffer(uint32_t buffer);
  Result<ByteSpan> slice(uint32_t buffer, uint64_t offset, uint64_t bytes);
  // Calls take(i, value) for components `components` of each element.
  template <class Take>
  Status forNumbers(const GltfElements& elements, uint32_t components, const Take& take);
  Result<std::vector<double>> raw(uint32_t accessor);
  Status overwrite(const GltfAccessor& accessor, std::vector<double>& values);

  const GltfDocument& document_;
  ByteSpan binary_;
  const FileReader& read_file_;
  std::vector<std::optional<Bytes>> buffers_;  // those that are read
  std::vector<std::optional<Bytes>> views_;    // those that are unpacked
};

}  // namespace foreland::terrain

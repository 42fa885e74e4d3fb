#include "terrain/model/gltf/buffers.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "terrain/model/gltf/meshopt.h"
#include "terrain/model/gltf/uri.h"

namespace foreland::terrain {

namespace {

constexpr uint64_t kMaxUnbacked = 1u << 20;  // elements that are zero because no view holds them

Error malformedBuffer(std::string what) { return {ErrorCode::kMalformed, std::move(what)}; }

std::string nameOf(const char* array, uint32_t index) { return std::string(array) + "[" + std::to_string(index) + "]"; }

uint32_t wordAt(const uint8_t* at, size_t bytes) {
  uint32_t word = 0;
  for (size_t i = 0; i < bytes; ++i) word |= uint32_t{at[i]} << (8 * i);
  return word;
}

double numberAt(const uint8_t* at, GltfType type) {
  const uint32_t word = wordAt(at, gltfTypeBytes(type));
  switch (type) {
    case GltfType::kInt8:
      return static_cast<int8_t>(word);
    case GltfType::kInt16:
      return static_cast<int16_t>(word);
    case GltfType::kFloat:
      return std::bit_cast<float>(word);
    default:
      return word;
  }
}

// What stands for 1.
double largestOf(GltfType type) {
  switch (type) {
    case GltfType::kInt8:
      return 127;
    case GltfType::kUint8:
      return 255;
    case GltfType::kInt16:
      return 32767;
    case GltfType::kUint16:
      return 65535;
    default:
      return 1;
  }
}

}  // namespace

Result<ByteSpan> GltfBuffers::buffer(uint32_t buffer) {
  const GltfBuffer& about = document_.buffers[buffer];
  ByteSpan bytes = binary_;
  const auto& unknown = document_.unknown_extensions;
  const bool is_packed = std::find(unknown.begin(), unknown.end(), kKhronosMeshopt) != unknown.end();
  if (about.uri.empty() && is_packed && (buffer != 0 || binary_.empty()))
    return Error{ErrorCode::kUnsupported, nameOf("buffers", buffer) + " is packed by the extension " + kKhronosMeshopt +
                                              ", which is not supported; pack it with EXT_meshopt_compression "
                                              "(gltfpack -c), or not at all"};
  if (!about.uri.empty()) {
    if (!buffers_[buffer]) {
      auto read = Result<Bytes>(Bytes());
      if (isDataUri(about.uri)) {
        read = decodeDataUri(about.uri);
      } else {
        const auto file = fileOfUri(about.uri);
        if (!file.ok()) return file.error();
        read = read_file_(*file);
      }
      if (!read.ok()) return read.error();
      buffers_[buffer] = std::move(read).value();
    }
    bytes = *buffers_[buffer];
  } else if (buffer != 0) {
    return malformedBuffer(nameOf("buffers", buffer) + " has no data; export the model again");
  }
  if (about.bytes > bytes.size())
    return malformedBuffer(nameOf("buffers", buffer) + " promises " + std::to_string(about.bytes) + " bytes, but has " +
                           std::to_string(bytes.size()) + "; copy or export the model again");
  return bytes.first(about.bytes);
}

Result<ByteSpan> GltfBuffers::slice(uint32_t buffer_index, uint64_t offset, uint64_t bytes) {
  const auto whole = buffer(buffer_index);
  if (!whole.ok()) return whole;
  if (offset > whole->size() || bytes > whole->size() - offset)
    return malformedBuffer("has a view beyond the end of " + nameOf("buffers", buffer_index) +
                           "; export the model again");
  return whole->subspan(offset, bytes);
}

Result<ByteSpan> GltfBuffers::view(uint32_t view) {
  const GltfView& about = document_.views[view];
  if (about.meshopt.buffer == kNoIndex) return slice(about.buffer, about.offset, about.bytes);
  if (!views_[view]) {
    const auto packed = slice(about.meshopt.buffer, about.meshopt.offset, about.meshopt.bytes);
    if (!packed.ok()) return packed;
    auto unpacked = unpackMeshopt(about.meshopt, *packed);
    if (!unpacked.ok()) return unpacked.error();
    views_[view] = std::move(unpacked).value();
  }
  return ByteSpan(*views_[view]);
}

template <class Take>
Status GltfBuffers::forNumbers(const GltfElements& elements, uint32_t components, const Take& take) {
  if (elements.count == 0) return {};
  const auto bytes = view(elements.view);
  if (!bytes.ok()) return bytes.error();
  const GltfView& about = document_.views[elements.view];
  const uint64_t size = gltfTypeBytes(elements.type), element = size * components;
  const uint64_t stride = about.meshopt.buffer != kNoIndex ? about.meshopt.stride
                          : about.stride != 0              ? about.stride
                                                           : element;
  if (elements.offset > bytes->size() || element > bytes->size() - elements.offset ||
      (elements.count - 1) > (bytes->size() - elements.offset - element) / stride)
    return malformedBuffer("reaches beyond the end of " + nameOf("bufferViews", elements.view) +
                           "; export the model again");
  for (uint64_t i = 0; i < elements.count; ++i)
    for (uint32_t k = 0; k < components; ++k)
      take(i * components + k, numberAt(bytes->data() + elements.offset + i * stride + k * size, elements.type));
  return {};
}

Status GltfBuffers::overwrite(const GltfAccessor& accessor, std::vector<double>& values) {
  if (accessor.places.view == kNoIndex || accessor.values.view == kNoIndex)
    return malformedBuffer("has sparse values without a view; export the model again");
  std::vector<double> places(accessor.places.count), changed(accessor.places.count * accessor.components);
  Status status = forNumbers(accessor.places, 1, [&](uint64_t i, double value) { places[i] = value; });
  if (!status.ok()) return status;
  status = forNumbers(accessor.values, accessor.components, [&](uint64_t i, double value) { changed[i] = value; });
  if (!status.ok()) return status;
  for (uint64_t i = 0; i < places.size(); ++i) {
    if (!(places[i] >= 0 && places[i] < static_cast<double>(accessor.elements.count)))
      return malformedBuffer("has a sparse value for an element that does not exist; export the model again");
    std::copy_n(changed.begin() + static_cast<ptrdiff_t>(i * accessor.components), accessor.components,
                values.begin() + static_cast<ptrdiff_t>(static_cast<uint64_t>(places[i]) * accessor.components));
  }
  return {};
}

Result<std::vector<double>> GltfBuffers::raw(uint32_t accessor) {
  const GltfAccessor& about = document_.accessors[accessor];
  const auto fail = [&](const Error& error) {
    return Error{error.code, nameOf("accessors", accessor) + " " + error.message};
  };
  const bool is_backed = about.elements.view != kNoIndex;
  if (!is_backed && about.elements.count > kMaxUnbacked)
    return fail(malformedBuffer("has more than 1048576 elements, but no data; export the model again"));
  if (is_backed) {  // before memory is allocated
    const auto bytes = view(about.elements.view);
    if (!bytes.ok()) return fail(bytes.error());
    if (about.elements.count > bytes->size())
      return fail(malformedBuffer("has more elements than its view has bytes; export the model again"));
  }
  std::vector<double> values(about.elements.count * about.components);
  if (is_backed) {
    const Status status =
        forNumbers(about.elements, about.components, [&](uint64_t i, double value) { values[i] = value; });
    if (!status.ok()) return fail(status.error());
  }
  if (about.places.count > 0)
    if (const Status status = overwrite(about, values); !status.ok()) return fail(status.error());
  return values;
}

Result<std::vector<double>> GltfBuffers::numbers(uint32_t accessor) {
  auto values = raw(accessor);
  const GltfAccessor& about = document_.accessors[accessor];
  if (!values.ok() || !about.is_normalised) return values;
  const double largest = largestOf(about.elements.type);
  for (double& value : *values) value = std::max(value / largest, -1.0);
  return values;
}

Result<std::vector<uint32_t>> GltfBuffers::indices(uint32_t accessor) {
  const GltfAccessor& about = document_.accessors[accessor];
  if (about.components != 1 || about.elements.type == GltfType::kFloat)
    return malformedBuffer(nameOf("accessors", accessor) +
                           " is used as indices, but holds no whole numbers; export the model again");
  const auto values = raw(accessor);
  if (!values.ok()) return values.error();
  std::vector<uint32_t> indices;
  indices.reserve(values->size());
  for (const double value : *values) indices.push_back(value < 0 ? kNoIndex : static_cast<uint32_t>(value));
  return indices;
}

}  // namespace foreland::terrain

// Reads any bytes as a model: PLY, STL if they begin with "solid" or "STL", or OBJ. The result must be a Model whose
// indices are in range, or an Error.
#include <cstring>
#include <string_view>

#include "base/check.h"
#include "terrain/model/read_model.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace foreland;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto library = [&](const std::string&) -> Result<Bytes> { return Bytes(data, data + size); };
  const auto model = text.starts_with("ply")                                ? terrain::parsePly({data, size}, "model")
                     : text.starts_with("solid") || text.starts_with("STL") ? terrain::parseStl({data, size}, "model")
                                                                            : terrain::parseObj(text, "model", library);
  if (!model.ok()) return 0;
  for (const terrain::Corner& corner : model->corners) {
    CHECK_LT(corner.vertex, model->positions.size());
    CHECK_TRUE(corner.texture == terrain::kNoIndex || corner.texture < model->texture_coordinates.size());
  }
  for (const uint32_t material : model->face_materials)
    CHECK_TRUE(material == terrain::kNoIndex || material < model->materials.size());
  return 0;
}

#include "terrain/model/checked_model.h"

#include <cmath>

namespace foreland::terrain {

namespace {

Status refuse(ErrorCode code, std::string what) { return Error{code, std::move(what)}; }

}  // namespace

Status CheckedModel::addPosition(const glm::dvec3& position) {
  const std::string name = model_.vertexName(model_.positions.size());
  if (model_.positions.size() >= kMaxModelVertices)
    return refuse(ErrorCode::kLimit, "more than 134217728 vertices; simplify the model");
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(position[axis]))
      return refuse(ErrorCode::kMalformed, name + " has a coordinate that is no finite number; correct the model");
    if (std::fabs(position[axis]) > kMaxCoordinate)
      return refuse(ErrorCode::kMalformed, name + " has a coordinate beyond 1e9; scale or move the model");
  }
  model_.positions.push_back(position);
  return {};
}

Status CheckedModel::addTextureCoordinate(const glm::dvec2& coordinate) {
  const size_t index = model_.texture_coordinates.size();
  if (index >= kMaxModelVertices)
    return refuse(ErrorCode::kLimit, "more than 134217728 texture coordinates; simplify the model");
  if (!(std::fabs(coordinate.x) <= kMaxCoordinate && std::fabs(coordinate.y) <= kMaxCoordinate))
    return refuse(ErrorCode::kMalformed, "texture coordinate " + std::to_string(index + model_.first_number) +
                                             " is no finite number below 1e9; correct the model");
  model_.texture_coordinates.push_back(coordinate);
  return {};
}

Status CheckedModel::endFace(uint32_t material) {
  const std::string name = model_.faceName(model_.faceCount());
  if (model_.faceCount() >= kMaxModelVertices)
    return refuse(ErrorCode::kLimit, "more than 134217728 faces; simplify the model");
  if (faceCorners() < 3)
    return refuse(ErrorCode::kMalformed, name + " has fewer than three corners; correct or remove it");
  if (faceCorners() > kMaxFaceCorners)
    return refuse(ErrorCode::kLimit, name + " has more than 1024 corners; cut it into smaller faces");
  model_.face_ends.push_back(model_.corners.size());
  model_.face_materials.push_back(material);
  return {};
}

Result<Model> CheckedModel::finish() {
  const auto fail = [&](std::string what) { return Error{ErrorCode::kMalformed, model_.name + ": " + what}; };
  if (model_.faceCount() == 0) return fail("has no face; name a model with a surface");
  for (size_t face = 0; face < model_.faceCount(); ++face)
    for (uint64_t c = model_.faceBegin(face); c < model_.face_ends[face]; ++c) {
      const Corner& corner = model_.corners[c];
      if (corner.vertex >= model_.positions.size())
        return fail(model_.faceName(face) + " names " + model_.vertexName(corner.vertex) + ", but there are only " +
                    std::to_string(model_.positions.size()) + "; correct or export the model again");
      if (corner.texture != kNoIndex && corner.texture >= model_.texture_coordinates.size())
        return fail(model_.faceName(face) + " names texture coordinate " +
                    std::to_string(corner.texture + model_.first_number) + ", but there are only " +
                    std::to_string(model_.texture_coordinates.size()) + "; correct or export the model again");
    }
  if (!model_.colours.empty()) model_.colours.resize(model_.positions.size(), Colour{255, 255, 255, 255});
  if (!model_.face_colours.empty()) model_.face_colours.resize(model_.faceCount(), Colour{255, 255, 255, 255});
  for (const auto& [what, count] : left_out_)
    if (count > 0) model_.notes.push_back(what + " left out: " + std::to_string(count));
  return std::move(model_);
}

}  // namespace foreland::terrain

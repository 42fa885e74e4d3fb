// Builds a Model piece by piece. A piece that would break the invariants of a Model (model.h) is an Error that names
// the vertex or face. One owner.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "base/result.h"
#include "terrain/model/model.h"

namespace foreland::terrain {

class CheckedModel {
 public:
  CheckedModel(std::string name, uint32_t first_number) {
    model_.name = std::move(name);
    model_.first_number = first_number;
  }
  const Model& get() const { return model_; }
  Model& edit() { return model_; }

  Status addPosition(const glm::dvec3& position);
  Status addTextureCoordinate(const glm::dvec2& coordinate);
  void addCorner(const Corner& corner) {
    if (faceCorners() <= kMaxFaceCorners) model_.corners.push_back(corner);
  }
  Status endFace(uint32_t material);  // of the corners since the last one ended

  // Counts what the reader does not take, for a note "`what` left out: N". `what` is of a fixed set, or bounded by it.
  void leaveOut(const std::string& what, uint64_t count = 1) { left_out_[what] += count; }

  // The model, with the notes; an Error if it has no face, or a corner names a vertex or texture coordinate that does
  // not exist.
  Result<Model> finish();

 private:
  uint64_t faceCorners() const { return model_.corners.size() - model_.faceBegin(model_.faceCount()); }

  Model model_;
  std::map<std::string, uint64_t> left_out_;
};

}  // namespace foreland::terrain

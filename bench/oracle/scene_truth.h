// The oracle's truth from a scene file's heights.
#pragma once

#include <memory>

#include "bench/oracle/oracle.h"
#include "terrain/store/scene.h"

namespace foreland::bench {

inline Truth truthOf(std::shared_ptr<const terrain::Scene> scene) {
  return {.frame = scene->frame(),
          .shape = scene->grid().shape(),
          .heights = [scene](uint32_t x, uint32_t y, std::span<int32_t> out) {
            for (size_t i = 0; i < out.size(); ++i)
              out[i] = scene->height(proto::NodeId::at(x + static_cast<uint32_t>(i), y));
          }};
}

}  // namespace foreland::bench

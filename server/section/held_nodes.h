// Sections of a scene as the delta codec asks for them. Refer to what they are made from; one owner, cheap.
#pragma once

#include <algorithm>

#include "proto/delta_codec.h"
#include "server/section/adapt.h"

namespace foreland::server {

// The section that an adapter stands at.
class AdapterNodes final : public proto::HeldNodes {
 public:
  AdapterNodes(const Adapter& adapter, const terrain::Scene& scene) : adapter_(adapter), scene_(scene) {}
  bool has(proto::Slot slot) const override { return adapter_.contains(slot); }
  int32_t height(proto::NodeId v) const override { return scene_.height(v); }

 private:
  const Adapter& adapter_;
  const terrain::Scene& scene_;
};

// Any section.
class SectionNodes final : public proto::HeldNodes {
 public:
  SectionNodes(const proto::Section& section, const terrain::Scene& scene) : section_(section), scene_(scene) {}
  bool has(proto::Slot slot) const override {
    return std::binary_search(section_.slots.begin(), section_.slots.end(), slot);
  }
  int32_t height(proto::NodeId v) const override { return scene_.height(v); }

 private:
  const proto::Section& section_;
  const terrain::Scene& scene_;
};

}  // namespace foreland::server

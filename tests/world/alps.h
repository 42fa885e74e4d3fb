// The scene that most flights in virtual time are over: small, planar, steep; made once.
#pragma once

#include <memory>

#include "tests/support/scene.h"

namespace foreland::test {

inline std::shared_ptr<const terrain::Scene> alps() {
  static const auto scene = makeScene(301, 217, 11);
  return scene;
}

}  // namespace foreland::test

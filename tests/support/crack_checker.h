// The crack checker (oracle/crack_checker.h) as a GoogleTest predicate: EXPECT_TRUE(hasNoCracks(mesh, shape)).
#pragma once

#include <gtest/gtest.h>

#include "oracle/crack_checker.h"

namespace foreland::test {

inline ::testing::AssertionResult hasNoCracks(const client::KeyframeMesh& mesh, const proto::GridShape& shape) {
  const oracle::CrackReport report = oracle::findCracks(mesh, shape);
  if (report.cracks == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << report.cracks << " cracks; the first: " << report.first;
}

}  // namespace foreland::test

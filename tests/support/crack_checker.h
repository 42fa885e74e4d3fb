// The crack checker (bench/oracle/crack_checker.h) as a GoogleTest predicate: EXPECT_TRUE(hasNoCracks(mesh, shape)).
#pragma once

#include <gtest/gtest.h>

#include "bench/oracle/crack_checker.h"

namespace foreland::test {

inline ::testing::AssertionResult hasNoCracks(const client::KeyframeMesh& mesh, const proto::GridShape& shape) {
  const bench::CrackReport report = bench::findCracks(mesh, shape);
  if (report.cracks == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << report.cracks << " cracks; the first: " << report.first;
}

}  // namespace foreland::test

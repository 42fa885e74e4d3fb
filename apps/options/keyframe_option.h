// --keyframe-ms, which several programs have. Header only; main thread.
#pragma once

#include <string>

#include "apps/options/options.h"
#include "proto/message/keyframe_interval.h"

namespace foreland::apps {

// Milliseconds, two of them with a dash between, or `adaptive`.
inline CLI::Validator keyframeInterval() {
  return {[](std::string& text) {
            const auto interval = proto::keyframeIntervalFrom(text);
            return interval ? std::string() : interval.error().message;
          },
          "adaptive|[0-9]+(-[0-9]+)?", std::string(kPattern)};
}

}  // namespace foreland::apps

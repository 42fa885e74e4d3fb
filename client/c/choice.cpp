#include "client/c/choice.h"

#include <cmath>
#include <numbers>
#include <string>

namespace foreland::client {
namespace {

using proto::Predictor;
using proto::Strategy;

// By FORELAND_PREDICT and its like, FORELAND_VELOCITY, ...; 0: the default.
constexpr Strategy kStrategies[] = {Strategy::kPredict, Strategy::kPredict, Strategy::kCurrent, Strategy::kDelay};
constexpr Predictor kPredictors[] = {Predictor::kConstantVelocity,
                                     Predictor::kConstantVelocity,
                                     Predictor::kConstantAcceleration,
                                     Predictor::kHold,
                                     Predictor::kKnownPath,
                                     Predictor::kDoubleExponential,
                                     Predictor::kKalman};
constexpr Blend kChoices[] = {Blend::kKeyframe, Blend::kKeyframe, Blend::kGeomorph, Blend::kSpline2, Blend::kSpline3};

Error outOfRange(const char* name, double value, const char* range) {
  return {ErrorCode::kInvalidArgument,
          std::string(name) + " is " + std::to_string(value) + ": give " + range + ", or 0 for the default."};
}

bool isOn(uint32_t choice, bool by_default) { return choice == FORELAND_DEFAULT ? by_default : choice == FORELAND_ON; }

Status checkOptions(const ForelandOptions& o) {
  if (o.strategy >= std::size(kStrategies)) return outOfRange("strategy", o.strategy, "FORELAND_PREDICT or its like");
  if (o.predictor >= std::size(kPredictors))
    return outOfRange("predictor", o.predictor, "FORELAND_VELOCITY or its like");
  const auto isChoice = [](uint32_t c) { return c <= FORELAND_OFF; };
  if (!isChoice(o.occlusion) || !isChoice(o.relief) || !isChoice(o.meshes))
    return Error{ErrorCode::kInvalidArgument, "occlusion, relief and meshes are FORELAND_ON or FORELAND_OFF."};
  if (o.tolerance_px != 0 && !(o.tolerance_px >= 0.01 && o.tolerance_px <= 1000))
    return outOfRange("tolerance_px", o.tolerance_px, "0.01 to 1000 pixels");
  for (const double ms : {o.keyframe_ms, o.longest_keyframe_ms})
    if (ms != 0 && !(ms >= 20 && ms <= 10'000)) return outOfRange("keyframe_ms", ms, "20 to 10000 milliseconds");
  return {};
}

proto::Lens lensOf(const ForelandLens& lens) {
  if (lens.size == 0) return {.vertical_fov_rad = 55 * std::numbers::pi / 180, .width_px = 1280, .height_px = 720};
  return {.vertical_fov_rad = lens.fov_y, .width_px = lens.width_px, .height_px = lens.height_px};
}

}  // namespace

void change(ForelandOptions& options, const ForelandOptions& changes) {
  const auto set = [](auto& to, auto from) { to = from != 0 ? from : to; };
  set(options.strategy, changes.strategy), set(options.predictor, changes.predictor);
  set(options.blend, changes.blend), set(options.tolerance_px, changes.tolerance_px);
  set(options.keyframe_ms, changes.keyframe_ms), set(options.longest_keyframe_ms, changes.longest_keyframe_ms);
  set(options.occlusion, changes.occlusion), set(options.relief, changes.relief);
}

Result<Blend> blendOf(const ForelandOptions& options) {
  if (options.blend >= std::size(kChoices)) return outOfRange("blend", options.blend, "FORELAND_KEYFRAME or its like");
  return kChoices[options.blend];
}

Result<proto::ViewRequest> requestOf(const Choice& choice) {
  const ForelandOptions& o = choice.options;
  if (Status s = checkOptions(o); !s.ok()) return s.error();
  const auto toDuration = [](double ms) { return Duration{std::llround(ms * 1000)}; };
  const proto::ViewRequest request{
      .lens = lensOf(choice.lens),
      .tau_px = o.tolerance_px != 0 ? o.tolerance_px : 1,
      .strategy = kStrategies[o.strategy],
      .predictor = o.predictor == 0 && choice.has_path ? Predictor::kKnownPath : kPredictors[o.predictor],
      .keyframe_interval = toDuration(o.keyframe_ms != 0 ? o.keyframe_ms : 200),
      .longest_interval = toDuration(o.longest_keyframe_ms),
      .max_triangles = o.max_triangles,
      .max_bytes_per_second = o.max_bytes_per_second,
      .occlusion = isOn(o.occlusion, true),
      .memory_bytes = o.memory_bytes != 0 ? o.memory_bytes : proto::kDefaultMemoryBytes,
      .relief = isOn(o.relief, false),
      .tile_bytes = o.tile_bytes != 0 ? o.tile_bytes : proto::kDefaultTileBytes};
  if (Status s = isTaken(request); !s.ok()) return s.error();
  return request;
}

}  // namespace foreland::client

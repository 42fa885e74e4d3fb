#include "lab/external/told_motion.h"

#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <utility>

namespace foreland::lab {

namespace {

using Json = AskedProgram::Json;

Json jsonOf(const proto::TimedPose& pose, bool has_jumped) {
  const glm::dvec3& eye = pose.pose.eye;
  const glm::dquat& q = pose.pose.orientation;
  return {{"time_us", pose.time.us},
          {"eye_m", {eye.x, eye.y, eye.z}},
          {"orientation", {q.w, q.x, q.y, q.z}},
          {"jumped", has_jumped}};
}

Result<server::Extrapolation> extrapolationOf(const Json& answer, AskedProgram& program) {
  const auto v = program.numbers(answer, "velocity_m_s", 3), a = program.numbers(answer, "acceleration_m_s2", 3),
             q = program.numbers(answer, "rotation", 4);
  for (const auto* numbers : {&v, &a, &q})
    if (!numbers->ok()) return numbers->error();
  const Json span = answer.value("span_s", Json());
  if (!span.is_number() || !(span.get<double>() >= 1e-3 && span.get<double>() <= 3600))
    return program.refuse("\"span_s\" must be a number from 0.001 to 3600");
  const glm::dquat rotation((*q)[0], (*q)[1], (*q)[2], (*q)[3]);
  if (std::abs(glm::length(rotation) - 1) > 1e-3)
    return program.refuse("\"rotation\" must be a quaternion of unit length, its real part first");
  server::Extrapolation told;
  told.velocity = {(*v)[0], (*v)[1], (*v)[2]};
  told.acceleration = {(*a)[0], (*a)[1], (*a)[2]};
  told.rotation = rotation;
  told.span_s = span.get<double>();
  return told;
}

class ProgramForesight final : public server::Foresight {
 public:
  ProgramForesight(AskedProgram& program, uint64_t connection) : program_(program), connection_(connection) {}

  void add(const proto::TimedPose& pose, bool has_jumped) override { poses_.push_back(jsonOf(pose, has_jumped)); }

  server::Extrapolation extrapolate() override {
    if (poses_.empty()) return told_;
    const auto answer =
        program_.ask({{"ask", "motion"}, {"connection", connection_}, {"poses", std::exchange(poses_, Json::array())}});
    if (!answer) return told_ = {};
    const auto told = extrapolationOf(*answer, program_);
    return told_ = told ? *told : server::Extrapolation{};
  }

 private:
  AskedProgram& program_;
  uint64_t connection_;
  Json poses_ = Json::array();  // since the last question
  server::Extrapolation told_;
};

}  // namespace

std::unique_ptr<server::Foresight> ToldMotion::next() {
  return std::make_unique<ProgramForesight>(*program_, connections_++);
}

}  // namespace foreland::lab

// A predictor that is a program of the user's. One owner, a run's; it outlives what it makes.
#pragma once

#include <memory>

#include "lab/external/asked_program.h"
#include "server/view/foresight.h"

namespace foreland::lab {

class ToldMotion {
 public:
  // `program` outlives this.
  explicit ToldMotion(AskedProgram& program) : program_(&program) {}
  // For the next connection; they are told apart by their numbers. Asks once for each time that the camera has moved.
  // After a failure the camera is expected to stand still.
  std::unique_ptr<server::Foresight> next();

 private:
  AskedProgram* program_;
  uint64_t connections_ = 0;
};

}  // namespace foreland::lab

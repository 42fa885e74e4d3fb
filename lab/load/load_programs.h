// The programs of the user's that take part in one load, and what they stand in for. One owner, a run's.
#pragma once

#include <memory>

#include "lab/external/asked_program.h"
#include "lab/load/job_order.h"
#include "lab/load/load_run.h"

namespace foreland::lab {

struct LoadPrograms {
  std::unique_ptr<AskedProgram> balance, order, predictor, link;  // null: ours

  // Those that the options name. Errors are AskedProgram's.
  static Result<LoadPrograms> start(const LoadOptions& options);
  // The first failure.
  Status status() const;
};

// Asks the program where each viewer goes and, if its greeting has `"moves": true`, whom to move. With `"queues": true`
// viewers who resume are queued. After a failure nobody finds a server. The program outlives it.
std::unique_ptr<Balancer> toldBalancer(AskedProgram& program);
// Asks the program for the key of each job that is queued: of the jobs that are released, the least is next. After a
// failure all are equal. The program outlives it.
std::unique_ptr<JobOrder> toldOrder(AskedProgram& program);

}  // namespace foreland::lab

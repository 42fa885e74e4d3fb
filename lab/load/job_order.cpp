#include "lab/load/job_order.h"

namespace foreland::lab {

namespace {

// Servers take jobs by their deadlines; the other orders are here to be compared with that.
Time releaseOf(const server::Due& due) { return due.release; }
Time laxityOf(const server::Due& due) { return due.deadline - due.work; }

class OwnOrder final : public JobOrder {
 public:
  explicit OwnOrder(LoadPolicy policy) : policy_(policy) {}
  server::JobKey key() const override {
    if (policy_ == LoadPolicy::kFifo) return releaseOf;
    return policy_ == LoadPolicy::kLeastLaxity ? laxityOf : server::deadlineOf;
  }
  void place(server::Due& job, const JobOwner& owner, Time) override {
    if (policy_ == LoadPolicy::kFair) job.deadline = job.deadline + owner.deficit.wait(owner.share);
  }

 private:
  LoadPolicy policy_;
};

}  // namespace

std::unique_ptr<JobOrder> makeOrder(LoadPolicy policy) { return std::make_unique<OwnOrder>(policy); }

}  // namespace foreland::lab

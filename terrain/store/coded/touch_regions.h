// Regions of addresses whose memory appears when it is touched: a load from a part that cannot be read calls the
// region's owner, on the thread that loads, and is then done again. Readers need not know that anything happened, so a
// record that is there costs what any load costs. A thread's loads only: a system call that is handed an address that
// cannot be read fails with EFAULT.
//
// It is a handler of SIGSEGV. Faults at other addresses go to the handler that was there before, or end the program as
// they always did. Debuggers stop at each such touch unless told otherwise (gdb: handle SIGSEGV nostop
// noprint), and Valgrind must be told to keep registers (--vex-iropt-register-updates=allregs-at-mem-access).
#pragma once

#include <cstddef>
#include <cstdint>

namespace foreland::terrain {

class TouchOwner {
 public:
  // Makes what is at `address` readable, or returns though another thread has. Called in a signal handler, for a load
  // of this program's own code that holds none of the owner's locks; may itself touch other parts.
  virtual void onTouch(uintptr_t address) = 0;

 protected:
  ~TouchOwner() = default;
};

// From its creation on touches of a region go to the owner, which must outlive it. Any thread, at most 64 at a time.
class TouchRegion {
 public:
  TouchRegion(const void* begin, size_t bytes, TouchOwner& owner);
  TouchRegion(const TouchRegion&) = delete;
  TouchRegion& operator=(const TouchRegion&) = delete;
  ~TouchRegion();

 private:
  size_t index_;
};

}  // namespace foreland::terrain

// Work that must not end the thread that does it, whatever it throws: out of memory, say.
#pragma once

#include <exception>

namespace foreland {

// Does the work; if it throws, on_failure(const char* what) is told, as the handler of an
// exception.
template <class Work, class OnFailure>
void guarded(const Work& work, const OnFailure& on_failure) {
  try {
    work();
  } catch (const std::exception& e) { on_failure(e.what()); } catch (...) {
    on_failure("an unknown exception");
  }
}

}  // namespace foreland

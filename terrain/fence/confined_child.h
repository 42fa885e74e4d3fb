// Runs a reader of foreign files in a child process that is confined, for programs that need for themselves what
// confine() takes away for good, such as sockets. A mistake in the reader harms the child alone, and what comes back is
// bytes, which are to be decoded like those of any other stranger. To be called before threads are started: the child
// is a fork.
#pragma once

#include <cstddef>
#include <functional>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/fence/confine.h"

namespace foreland::terrain {

// What `make` returns in the child. Error if the child ends before, or makes more than `max_bytes`. Where the kernel
// cannot confine, the child is one nevertheless.
Result<Bytes> inConfinedChild(const Confinement& confinement, size_t max_bytes, const std::function<Bytes()>& make);

}  // namespace foreland::terrain

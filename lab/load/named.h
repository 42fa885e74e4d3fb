// Looks a value of an enumeration up by its name, for options that name one.
#pragma once

#include <array>
#include <string>

#include "base/result.h"

namespace foreland::lab {

// `names` in the order of the enumeration. The Error says what there is: "there is no `what` '...'; choose one of ...".
template <class E, size_t N>
Result<E> named(const std::string& name, const char* what, const std::array<const char*, N>& names) {
  std::string all;
  for (size_t i = 0; i < N; ++i) {
    if (name == names[i]) return static_cast<E>(i);
    all += (i == 0 ? "" : ", ") + std::string(names[i]);
  }
  return Error{ErrorCode::kInvalidArgument,
               std::string("there is no ") + what + " '" + name + "'; choose one of " + all};
}

}  // namespace foreland::lab

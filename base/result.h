// Errors of the outside world (file, network, flag) as values: what went wrong with what, and the remedy. Nothing
// throws. Value types; any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/check.h"

namespace foreland {

enum class ErrorCode : uint8_t {
  kInvalidArgument,  // a flag or parameter that makes no sense
  kNotFound,         // the named thing does not exist
  kIo,               // the system refused: permission, disk full, port in use
  kMalformed,        // bytes that do not follow their format
  kUnsupported,      // well-formed, but beyond what this version can do
  kLimit,            // above a stated limit
};

// `message` names what is wrong and how to remedy it; users see it unchanged.
struct Error {
  ErrorCode code = ErrorCode::kInvalidArgument;
  std::string message;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}      // NOLINT: implicit, so that `return value;` works
  Result(Error error) : value_(std::move(error)) {}  // NOLINT
  bool ok() const { return value_.index() == 0; }
  explicit operator bool() const { return ok(); }
  T& value() & {
    CHECK_TRUE(ok());
    return std::get<0>(value_);
  }
  const T& value() const& {
    CHECK_TRUE(ok());
    return std::get<0>(value_);
  }
  T&& value() && {
    CHECK_TRUE(ok());
    return std::get<0>(std::move(value_));
  }
  const Error& error() const {
    CHECK_TRUE(!ok());
    return std::get<1>(value_);
  }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }

 private:
  std::variant<T, Error> value_;
};

// Success, or an Error: `if (Status s = f(); !s.ok()) return s.error();`
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}  // NOLINT
  bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const {
    CHECK_TRUE(!ok());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace foreland

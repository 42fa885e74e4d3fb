// The world's mistakes (file, network, flag) as values: what went wrong, which thing, and the way out. Nothing throws.
// Value types; any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "base/check.h"

namespace foreland {

enum class ErrorCode : uint8_t {
  kInvalidArgument,  // a flag or parameter that cannot be meant
  kNotFound,         // the named thing does not exist
  kIo,               // the system refused: permission, disk full, port in use
  kMalformed,        // bytes that are not what they claim to be
  kUnsupported,      // well-formed, but not something this version can do
  kLimit,            // larger or more than a stated limit
};

// `message` names the thing and says what to do about it; it is shown to the user as it is.
struct Error {
  ErrorCode code = ErrorCode::kInvalidArgument;
  std::string message;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}      // NOLINT: implicit by design, as `return value;`
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

// Checks for programming errors: a failed one prints both operands and aborts. Never for input from outside, which
// result.h is for. Any thread. CHECK_* always runs; DCHECK_* only in builds without NDEBUG.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <type_traits>

namespace foreland::check_detail {

template <class T>
double printable(const T& value) {
  if constexpr (std::is_arithmetic_v<T>)
    return static_cast<double>(value);
  else if constexpr (std::is_enum_v<T>)
    return static_cast<double>(static_cast<std::underlying_type_t<T>>(value));
  else
    return 0.0;
}

[[noreturn]] inline void fail(const char* file, int line, const char* expression, double left, double right) {
  std::fprintf(stderr, "%s:%d: CHECK failed: %s (left %.17g, right %.17g)\n", file, line, expression, left, right);
  std::abort();
}

}  // namespace foreland::check_detail

#define FORELAND_CHECK_OP_(op, a, b)                                                     \
  do {                                                                                   \
    const auto& check_left_ = (a);                                                       \
    const auto& check_right_ = (b);                                                      \
    if (!(check_left_ op check_right_))                                                  \
      ::foreland::check_detail::fail(__FILE__, __LINE__, #a " " #op " " #b,              \
                                     ::foreland::check_detail::printable(check_left_),   \
                                     ::foreland::check_detail::printable(check_right_)); \
  } while (false)

#define CHECK_EQ(a, b) FORELAND_CHECK_OP_(==, a, b)
#define CHECK_NE(a, b) FORELAND_CHECK_OP_(!=, a, b)
#define CHECK_LT(a, b) FORELAND_CHECK_OP_(<, a, b)
#define CHECK_LE(a, b) FORELAND_CHECK_OP_(<=, a, b)
#define CHECK_GT(a, b) FORELAND_CHECK_OP_(>, a, b)
#define CHECK_GE(a, b) FORELAND_CHECK_OP_(>=, a, b)
#define CHECK_TRUE(a) FORELAND_CHECK_OP_(==, static_cast<bool>(a), true)

#ifdef NDEBUG
#define DCHECK_EQ(a, b) ((void)0)
#define DCHECK_LT(a, b) ((void)0)
#define DCHECK_LE(a, b) ((void)0)
#define DCHECK_GE(a, b) ((void)0)
#define DCHECK_TRUE(a) ((void)0)
#else
#define DCHECK_EQ(a, b) CHECK_EQ(a, b)
#define DCHECK_LT(a, b) CHECK_LT(a, b)
#define DCHECK_LE(a, b) CHECK_LE(a, b)
#define DCHECK_GE(a, b) CHECK_GE(a, b)
#define DCHECK_TRUE(a) CHECK_TRUE(a)
#endif

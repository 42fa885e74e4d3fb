// FORELAND_SANITIZED is 1 in builds with ASan or TSan, else 0: for code they do not allow and tests too slow for them.
#pragma once

#ifdef __has_feature  // clang
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FORELAND_SANITIZED 1
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)  // gcc
#define FORELAND_SANITIZED 1
#endif

#ifndef FORELAND_SANITIZED
#define FORELAND_SANITIZED 0
#endif

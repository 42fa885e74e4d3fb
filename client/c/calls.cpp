#include "client/c/calls.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <new>

namespace foreland::client {
namespace {

std::array<char, 1024>& room() {
  thread_local std::array<char, 1024> text{};
  return text;
}

}  // namespace

const char* lastError() { return room().data(); }

ForelandStatus refuse(ForelandStatus status, std::string_view why) noexcept {
  auto& text = room();
  size_t size = std::min(why.size(), text.size() - 1);
  while (size < why.size() && size > 0 && (static_cast<unsigned char>(why[size]) & 0xc0) == 0x80)
    --size;  // whole characters
  std::memcpy(text.data(), why.data(), size);
  text[size] = 0;
  return status;
}

ForelandStatus refuse(const Error& error) noexcept {
  return refuse(error.code == ErrorCode::kUnsupported ? FORELAND_UNSUPPORTED : FORELAND_ARGUMENT, error.message);
}

ForelandStatus refuseException() noexcept {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return refuse(FORELAND_FAILED, "Memory is short: close other terrains, or ask for less.");
  } catch (const std::exception& e) { return refuse(FORELAND_FAILED, e.what()); } catch (...) {
    return refuse(FORELAND_FAILED, "An exception of an unknown kind.");
  }
}

}  // namespace foreland::client

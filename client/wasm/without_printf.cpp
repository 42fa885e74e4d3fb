// Last words without printf(), which with its arithmetic of 128 bits would be a tenth of the module. The linker takes
// these functions in place of those of libc and libc++: fprintf() for failed checks (base/check.h), and what libc++
// says where it would throw. They write to the page's console.
#include <unistd.h>

#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>
#include <string_view>

namespace {

// Six digits after the point, at most.
std::string textOf(double number) {
  constexpr uint64_t kMillion = 1'000'000;
  if (std::isnan(number)) return "nan";
  const std::string sign = number < 0 ? "-" : "";
  const double size = std::fabs(number);
  if (size >= 1e12) return sign + "1e12 or more";
  const auto millionths = static_cast<uint64_t>(size * kMillion);
  std::string text = sign + std::to_string(millionths / kMillion);
  if (const uint64_t rest = millionths % kMillion; rest > 0) text += "." + std::to_string(kMillion + rest).substr(1);
  return text;
}

// Knows %s, %d and %.17g.
void say(std::string_view format, std::va_list values) {
  std::string text;
  for (size_t i = 0; i < format.size(); ++i) {
    if (format[i] != '%') {
      text += format[i];
      continue;
    }
    i = format.find_first_of("sdg", i);
    if (i == std::string_view::npos) break;
    if (format[i] == 's') text += va_arg(values, const char*);
    if (format[i] == 'd') text += std::to_string(va_arg(values, int));
    if (format[i] == 'g') text += textOf(va_arg(values, double));
  }
  (void)!::write(STDERR_FILENO, text.data(), text.size());
}

}  // namespace

extern "C" int fprintf(std::FILE*, const char* format, ...) {
  std::va_list values;
  va_start(values, format);
  say(format, values);
  va_end(values);
  return 0;
}

// libc++'s own would ask handlers that nobody sets, and then print.
void* operator new(size_t size) {
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) return memory;
  std::abort();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void* operator new(size_t size, std::align_val_t alignment) {
  const auto multiple = static_cast<size_t>(alignment);
  if (void* const memory = std::aligned_alloc(multiple, (size + multiple - 1) / multiple * multiple)) return memory;
  std::abort();
}
void* operator new[](size_t size) { return operator new(size); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }

extern "C" void __cxa_pure_virtual() { std::abort(); }

void std::__libcpp_verbose_abort(const char* format, ...) {
  std::va_list values;
  va_start(values, format);
  say(format, values);
  va_end(values);
  std::abort();
}

#include "server/net/metrics/process_metrics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <system_error>

namespace foreland::server {
namespace {

// The fields of /proc/self/stat from the third on (proc(5)); what precedes them holds the program's name.
std::istringstream statistics() {
  std::ifstream file("/proc/self/stat");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const size_t name_end = text.rfind(')');
  return std::istringstream(name_end == std::string::npos ? "" : text.substr(name_end + 1));
}

// Of the system's start, in seconds since 1970.
double bootTime() {
  std::ifstream file("/proc/stat");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("btime ")) return std::stod(line.substr(6));
  return 0;
}

uint64_t openFiles() {
  std::error_code error;
  const std::filesystem::directory_iterator begin("/proc/self/fd", error);
  return error ? 0 : static_cast<uint64_t>(std::distance(begin, std::filesystem::directory_iterator()));
}

}  // namespace

ProcessMetrics processMetrics() {
  ProcessMetrics result;
  const auto ticks_a_second = static_cast<double>(sysconf(_SC_CLK_TCK));
  std::istringstream fields = statistics();
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  double user_ticks = 0, system_ticks = 0, start_ticks = 0;
  fields >> user_ticks >> system_ticks;
  for (int field = 16; field < 22; ++field) fields >> skipped;
  uint64_t resident_pages = 0;
  fields >> start_ticks >> result.virtual_bytes >> resident_pages;
  result.cpu_seconds = (user_ticks + system_ticks) / ticks_a_second;
  static const double boot = bootTime();
  result.start_time_s = boot + start_ticks / ticks_a_second;
  result.resident_bytes = resident_pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  result.open_fds = openFiles();
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) == 0) result.max_fds = files.rlim_cur;
  return result;
}

}  // namespace foreland::server

#include "terrain/fence/confine.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <memory>

#include "base/sanitized.h"

namespace foreland::terrain {

namespace {

// What later kernels added; the headers may be older than the kernel.
constexpr uint64_t kRefer = 1u << 13, kTruncate = 1u << 14;
constexpr uint64_t kReadFile = LANDLOCK_ACCESS_FS_READ_FILE, kReadFolder = kReadFile | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr uint64_t kExecute = LANDLOCK_ACCESS_FS_EXECUTE;
constexpr uint64_t kAllOfFirst = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;

class Descriptor {
 public:
  explicit Descriptor(long value) : value_(static_cast<int>(value)) {}
  ~Descriptor() {
    if (value_ >= 0) close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }

 private:
  int value_;
};

// Rules for what is not there have no effect. Rights that only folders have are left out for files.
void allow(const Descriptor& rules, const std::filesystem::path& path, uint64_t access) {
  const Descriptor at(open(path.c_str(), O_PATH | O_CLOEXEC));
  if (at.get() < 0) return;
  struct stat status {};
  if (fstat(at.get(), &status) != 0) return;
  constexpr uint64_t kOfFiles = kReadFile | kExecute | LANDLOCK_ACCESS_FS_WRITE_FILE | kTruncate;
  landlock_path_beneath_attr rule{};
  rule.allowed_access = S_ISDIR(status.st_mode) ? access : access & kOfFiles;
  rule.parent_fd = at.get();
  syscall(SYS_landlock_add_rule, rules.get(), LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
}

// Libraries are loaded, and PROJ, GDAL and the C library read their data, when they are first needed.
constexpr const char* kSystem[] = {
    "/usr",         "/lib",           "/lib64",     "/etc/ld.so.cache", "/etc/localtime",
    "/proc/self",   "/proc/cpuinfo",  "/proc/stat", "/proc/meminfo",    "/sys/devices/system",
    "/dev/urandom", "/sys/fs/cgroup", "/dev/zero"};

// Where projsync puts the grids that a user fetches.
std::vector<std::filesystem::path> foldersOfProjsync() {
  std::vector<std::filesystem::path> folders;
  if (const char* own = std::getenv("PROJ_USER_WRITABLE_DIRECTORY")) folders.emplace_back(own);
  if (const char* data = std::getenv("XDG_DATA_HOME")) folders.push_back(std::filesystem::path(data) / "proj");
  if (const char* home = std::getenv("HOME")) folders.push_back(std::filesystem::path(home) / ".local/share/proj");
  return folders;
}

bool confineFiles(const Confinement& confinement) {
  const long version = syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) return false;
  landlock_ruleset_attr handled{};
  handled.handled_access_fs = kAllOfFirst | (version >= 2 ? kRefer : 0) | (version >= 3 ? kTruncate : 0);
  const uint64_t all = handled.handled_access_fs;
  const Descriptor rules(syscall(SYS_landlock_create_ruleset, &handled, sizeof handled, 0));
  if (rules.get() < 0) return false;
  for (const char* path : kSystem) allow(rules, path, kReadFolder | kExecute);
  for (const char* name : {"PROJ_LIB", "PROJ_DATA", "GDAL_DATA"})
    if (const char* path = std::getenv(name)) allow(rules, path, kReadFolder);
  for (const std::filesystem::path& grids : foldersOfProjsync()) allow(rules, grids, kReadFolder);
  allow(rules, "/dev/null", all);
  for (const std::filesystem::path& path : confinement.read) allow(rules, path, kReadFolder);
  for (const std::filesystem::path& path : confinement.write) allow(rules, path, all & ~kExecute);
  return syscall(SYS_landlock_restrict_self, rules.get(), 0) == 0;
}

// The leak sanitizer looks into its own process by ptrace when it ends.
constexpr bool kMayTrace = FORELAND_SANITIZED == 1;

bool confineCalls() {
  const std::unique_ptr<void, void (*)(scmp_filter_ctx)> filter(seccomp_init(SCMP_ACT_ALLOW), seccomp_release);
  if (!filter) return false;
  for (const int call :
       {SCMP_SYS(socket),          SCMP_SYS(socketpair),     SCMP_SYS(connect),           SCMP_SYS(bind),
        SCMP_SYS(listen),          SCMP_SYS(accept),         SCMP_SYS(accept4),           SCMP_SYS(execve),
        SCMP_SYS(execveat),        SCMP_SYS(ptrace),         SCMP_SYS(process_vm_readv),  SCMP_SYS(process_vm_writev),
        SCMP_SYS(io_uring_setup),  SCMP_SYS(io_uring_enter), SCMP_SYS(io_uring_register), SCMP_SYS(bpf),
        SCMP_SYS(perf_event_open), SCMP_SYS(mount),          SCMP_SYS(unshare),           SCMP_SYS(setns),
        SCMP_SYS(pidfd_getfd),     SCMP_SYS(keyctl),         SCMP_SYS(add_key),           SCMP_SYS(request_key)})
    if (!(kMayTrace && call == SCMP_SYS(ptrace)) && seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(EPERM), call, 0) != 0)
      return false;
  return seccomp_load(filter.get()) == 0;  // calls of other architectures end the process
}

void limit(__rlimit_resource_t what, rlim_t most) {
  rlimit now{};
  if (getrlimit(what, &now) != 0) return;
  if (now.rlim_max != RLIM_INFINITY && now.rlim_max < most) most = now.rlim_max;
  const rlimit less{most, most};
  setrlimit(what, &less);
}

// Whether the process has more already: a sanitizer's shadow, which is not memory.
bool hasMoreThan(rlim_t bytes) {
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  for (int field = 0; field < 6; ++field) statm >> pages;  // the sixth: data and stack
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) > bytes / 2;
}

void limitResources() {
  constexpr rlim_t kDay_s = 24 * 3600;
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE), processors = sysconf(_SC_NPROCESSORS_ONLN);
  limit(RLIMIT_CORE, 0);
  const rlim_t memory = static_cast<rlim_t>(pages) * static_cast<rlim_t>(page);
  if (pages > 0 && page > 0 && !hasMoreThan(memory)) limit(RLIMIT_DATA, memory);
  limit(RLIMIT_CPU, kDay_s * static_cast<rlim_t>(processors > 0 ? processors : 1));
}

}  // namespace

std::vector<std::string> confine(const Confinement& confinement) {
  std::vector<std::string> missing;
  limitResources();
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || !confineFiles(confinement))
    missing.push_back(
        "this kernel does not confine a process to folders (Landlock); foreign files are fenced by the readers alone");
  if (!confineCalls()) missing.push_back("this kernel does not keep a process from opening connections (seccomp)");
  return missing;
}

}  // namespace foreland::terrain

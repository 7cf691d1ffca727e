// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/sandbox.cpp
#include "process/sandbox.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include "process/child_process.h"
#include "process/worker_io.h"

namespace dgm::bake {
namespace {

/// System calls that reading files, allocating and ending need.
constexpr int kAllowed[] = {SCMP_SYS(brk),
                            SCMP_SYS(clock_gettime),
                            SCMP_SYS(clock_nanosleep),
                            SCMP_SYS(close),
                            SCMP_SYS(exit),
                            SCMP_SYS(exit_group),
                            SCMP_SYS(fcntl),
                            SCMP_SYS(flock),
                            SCMP_SYS(fstat),
                            SCMP_SYS(fstatfs),
                            SCMP_SYS(futex),
                            SCMP_SYS(getcwd),
                            SCMP_SYS(getdents64),
                            SCMP_SYS(getegid),
                            SCMP_SYS(geteuid),
                            SCMP_SYS(getgid),
                            SCMP_SYS(getpid),
                            SCMP_SYS(getrandom),
                            SCMP_SYS(getrusage),
                            SCMP_SYS(gettid),
                            SCMP_SYS(gettimeofday),
                            SCMP_SYS(getuid),
                            SCMP_SYS(lseek),
                            SCMP_SYS(lstat),
                            SCMP_SYS(madvise),
                            SCMP_SYS(mmap),
                            SCMP_SYS(mprotect),
                            SCMP_SYS(mremap),
                            SCMP_SYS(munmap),
                            SCMP_SYS(newfstatat),
                            SCMP_SYS(pread64),
                            SCMP_SYS(preadv),
                            SCMP_SYS(read),
                            SCMP_SYS(readlink),
                            SCMP_SYS(readlinkat),
                            SCMP_SYS(readv),
                            SCMP_SYS(restart_syscall),
                            SCMP_SYS(rseq),
                            SCMP_SYS(rt_sigaction),
                            SCMP_SYS(rt_sigprocmask),
                            SCMP_SYS(rt_sigreturn),
                            SCMP_SYS(sched_getaffinity),
                            SCMP_SYS(sched_yield),
                            SCMP_SYS(set_robust_list),
                            SCMP_SYS(sigaltstack),
                            SCMP_SYS(stat),
                            SCMP_SYS(statx),
                            SCMP_SYS(time),
                            SCMP_SYS(uname),
                            SCMP_SYS(write),
                            SCMP_SYS(writev)};

void limit(int resource, rlim_t most) {
    rlimit now{};
    if (getrlimit(static_cast<__rlimit_resource_t>(resource), &now) != 0) return;
    now.rlim_max = std::min(now.rlim_max, most);
    now.rlim_cur = std::min(now.rlim_cur, now.rlim_max);
    setrlimit(static_cast<__rlimit_resource_t>(resource), &now);
}

/// Empty if the process may open the files given and no others; else why not.
std::string restrict_files(std::span<const std::filesystem::path> readable) {
    constexpr std::uint64_t kFile = LANDLOCK_ACCESS_FS_READ_FILE;
    constexpr std::uint64_t kAll = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;  // what the first version knows
    const landlock_ruleset_attr handled{.handled_access_fs = kAll};
    const Descriptor rules(static_cast<int>(syscall(SYS_landlock_create_ruleset, &handled, sizeof handled, 0)));
    if (!rules.is_open()) return std::string("Landlock is not there: ") + std::strerror(errno);
    for (const std::filesystem::path& path : readable) {
        const Descriptor target(open(path.c_str(), O_PATH | O_CLOEXEC));
        if (!target.is_open()) continue;  // what is not there cannot be read
        std::error_code ignored;
        const bool is_folder = std::filesystem::is_directory(path, ignored);
        const landlock_path_beneath_attr rule{.allowed_access = is_folder ? kFile | LANDLOCK_ACCESS_FS_READ_DIR : kFile,
                                              .parent_fd = target.get()};
        if (syscall(SYS_landlock_add_rule, rules.get(), LANDLOCK_RULE_PATH_BENEATH, &rule, 0) != 0)
            return std::string("Landlock takes no rule: ") + std::strerror(errno);
    }
    if (syscall(SYS_landlock_restrict_self, rules.get(), 0) != 0)
        return std::string("Landlock does not restrict this process: ") + std::strerror(errno);
    return {};
}

/// Empty if nothing but the list above is left; else why not.
std::string restrict_calls() {
    const std::unique_ptr<void, void (*)(scmp_filter_ctx)> filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)), seccomp_release);
    if (!filter) return "libseccomp has no memory";
    // Names that this processor's system does not have are left out by libseccomp itself.
    for (const int call : kAllowed) seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, 0);
    constexpr auto kWriting = static_cast<scmp_datum_t>(O_ACCMODE | O_CREAT | O_TRUNC | O_TMPFILE);
    constexpr auto kFolder = static_cast<scmp_datum_t>(O_DIRECTORY);  // a part of O_TMPFILE
    int added = seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(openat), 1,
                                 SCMP_A2(SCMP_CMP_MASKED_EQ, kWriting & ~kFolder, O_RDONLY));
    seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(open), 1,
                     SCMP_A1(SCMP_CMP_MASKED_EQ, kWriting & ~kFolder, O_RDONLY));
    // abort() and the like, which signal the process itself.
    const auto self = static_cast<scmp_datum_t>(getpid());
    seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1, SCMP_A0(SCMP_CMP_EQ, self));
    seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, SCMP_SYS(prlimit64), 2, SCMP_A0(SCMP_CMP_EQ, 0),
                     SCMP_A2(SCMP_CMP_EQ, 0));  // reading one's own
    if (added == 0) added = seccomp_load(filter.get());
    return added == 0 ? std::string() : std::string("no list of system calls: ") + std::strerror(-added);
}

}  // namespace

std::vector<std::string> enter_sandbox(std::span<const std::filesystem::path> readable, const SandboxLimits& limits) {
    std::vector<std::string> missing;
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, limits.cpu_seconds);
    limit(RLIMIT_NOFILE, limits.descriptors);
    limit_worker_memory(limits.memory_bytes, 1);
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0)
        missing.push_back(std::string("no_new_privs is not there: ") + std::strerror(errno));
    for (std::string reason : {restrict_files(readable), restrict_calls()})
        if (!reason.empty()) missing.push_back(std::move(reason));
    return missing;
}

}  // namespace dgm::bake

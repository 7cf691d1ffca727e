// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/sandbox.cpp
#include "process/sandbox.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <memory>
#include <new>
#include <utility>

#include "files/io_failure.h"
#include "model/codes.h"
#include "model/error.h"
#include "process/child_process.h"
#include "process/worker_io.h"

namespace dgm::bake {
namespace {

/// Calls that reading files, allocating and ending need.
constexpr int kReading[] = {SCMP_SYS(access),
                            SCMP_SYS(brk),
                            SCMP_SYS(clock_gettime),
                            SCMP_SYS(clock_nanosleep),
                            SCMP_SYS(close),
                            SCMP_SYS(exit),
                            SCMP_SYS(exit_group),
                            SCMP_SYS(faccessat),
                            SCMP_SYS(faccessat2),
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

/// Calls that writing files needs beside them. Which files, Landlock decides.
constexpr int kWriting[] = {SCMP_SYS(chmod),     SCMP_SYS(copy_file_range),
                            SCMP_SYS(creat),     SCMP_SYS(dup),
                            SCMP_SYS(fallocate), SCMP_SYS(fchmod),
                            SCMP_SYS(fchmodat),  SCMP_SYS(fdatasync),
                            SCMP_SYS(fsync),     SCMP_SYS(ftruncate),
                            SCMP_SYS(mkdir),     SCMP_SYS(mkdirat),
                            SCMP_SYS(msync),     SCMP_SYS(open),
                            SCMP_SYS(openat),    SCMP_SYS(pwrite64),
                            SCMP_SYS(pwritev),   SCMP_SYS(rename),
                            SCMP_SYS(renameat),  SCMP_SYS(renameat2),
                            SCMP_SYS(rmdir),     SCMP_SYS(sendfile),
                            SCMP_SYS(statfs),    SCMP_SYS(sync_file_range),
                            SCMP_SYS(truncate),  SCMP_SYS(umask),
                            SCMP_SYS(unlink),    SCMP_SYS(unlinkat)};

/// Calls that threads need.
constexpr int kThreading[] = {SCMP_SYS(get_mempolicy),
                              SCMP_SYS(getcpu),
                              SCMP_SYS(mbind),
                              SCMP_SYS(membarrier),
                              SCMP_SYS(nanosleep),
                              SCMP_SYS(sched_getparam),
                              SCMP_SYS(sched_getscheduler),
                              SCMP_SYS(sched_setaffinity),
                              SCMP_SYS(set_tid_address),
                              SCMP_SYS(sysinfo)};

/// Beyond any map of the largest grid with all its layers, its textures and the meshes made of it.
constexpr std::uint64_t kMostOutputBytes = std::uint64_t{64} << 30;

/// Libraries that others load when they are first used, and what tells them about processors and memory.
constexpr const char* kSystemFiles[] = {
    "/lib",         "/lib64",        "/usr/lib",      "/usr/lib64", "/usr/local/lib", "/etc/ld.so.cache",   "/dev/null",
    "/dev/urandom", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/proc/self",     "/sys/devices/system"};

/// Landlock's rights over what is in a folder that may be written in.
constexpr std::uint64_t kReadRights = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kWriteRights = kReadRights | LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG |
                                       LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_REMOVE_FILE |
                                       LANDLOCK_ACCESS_FS_REMOVE_DIR | LANDLOCK_ACCESS_FS_REFER;

/// @param grace  between the limit that is told and the one that ends the process without a word
void limit(int resource, rlim_t most, rlim_t grace = 0) {
    rlimit now{};
    if (getrlimit(static_cast<__rlimit_resource_t>(resource), &now) != 0) return;
    now.rlim_max = std::min(now.rlim_max, most + grace);
    now.rlim_cur = std::min({now.rlim_cur, now.rlim_max, most});
    setrlimit(static_cast<__rlimit_resource_t>(resource), &now);
}

std::string failed(const char* what, int error) {
    return std::string(what) + ": " + std::strerror(error);
}

/// Why Landlock is not to be had. A moment's trouble may not make a sandbox without it, or without one of the files:
/// what cannot be read would look as if it were not there.
std::string no_landlock(const char* what, int error) {
    if (formats::may_pass(error))
        throw model::Error(model::codes::kSystemBusy, failed("the sandbox cannot be made", error));
    return failed(what, error);
}

/// Lets `path`, and all that is in a folder, be used with `rights`. False if Landlock takes no rule.
bool add_rule(const Descriptor& rules, const std::filesystem::path& path, std::uint64_t rights) {
    const Descriptor target(open(path.c_str(), O_PATH | O_CLOEXEC));
    if (!target.is_open()) return !formats::may_pass(errno);  // what is not there cannot be used
    struct stat status {};
    if (fstat(target.get(), &status) != 0) return false;
    if (!S_ISDIR(status.st_mode)) rights &= LANDLOCK_ACCESS_FS_READ_FILE;
    const landlock_path_beneath_attr rule{.allowed_access = rights, .parent_fd = target.get()};
    return syscall(SYS_landlock_add_rule, rules.get(), LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0;
}

/// The kernel's interface; negative, with errno, if it has none.
long landlock_version() {
    return syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
}

/// Empty if the process may use the files given and no others; else why not.
std::string restrict_files(const Sandbox& files) {
    const long version = landlock_version();
    if (version < 0) return no_landlock("Landlock is not there", errno);
    // The first version cannot let a file be moved from one folder to another.
    if (version < 2 && !files.writable.empty()) return "Landlock is of its first version, which forbids all moves";
    constexpr std::uint64_t kFirst = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1) - 1;
    const landlock_ruleset_attr handled{.handled_access_fs = version < 2 ? kFirst : kFirst | LANDLOCK_ACCESS_FS_REFER};
    const Descriptor rules(static_cast<int>(syscall(SYS_landlock_create_ruleset, &handled, sizeof handled, 0)));
    if (!rules.is_open()) return no_landlock("Landlock makes no rules", errno);
    for (const std::filesystem::path& path : files.readable)
        if (!add_rule(rules, path, kReadRights)) return no_landlock("Landlock takes no rule", errno);
    for (const std::filesystem::path& path : files.writable)
        if (!add_rule(rules, path, kWriteRights)) return no_landlock("Landlock takes no rule", errno);
    if (syscall(SYS_landlock_restrict_self, rules.get(), 0) != 0)
        return no_landlock("Landlock does not restrict this process", errno);
    return {};
}

/// What the allocation of something else would do if it failed now.
[[noreturn]] void fail_allocation() {
    if (const std::new_handler handler = std::get_new_handler()) handler();
    throw std::bad_alloc();
}

/// libseccomp 2.5 crashes after some allocations that fail. It takes some 0.4 MB; the C library asks for 1 MiB and more
/// at a time.
void check_memory_for_filter() {
    constexpr std::size_t kNeeded = 4 << 20;
    void* const spare = mmap(nullptr, kNeeded, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (spare == MAP_FAILED) fail_allocation();
    munmap(spare, kNeeded);
}

/// While it lives the process may compute for a second. After other allocations that fail libseccomp 2.5 loops for
/// ever; all it does takes a few milliseconds.
class AllocationWatch {
 public:
    AllocationWatch() {
        signal(SIGVTALRM, end_process);
        const itimerval second{.it_interval = {}, .it_value = {.tv_sec = 1, .tv_usec = 0}};
        setitimer(ITIMER_VIRTUAL, &second, nullptr);
    }
    /// The timer can no longer be stopped: that call is not on the list.
    ~AllocationWatch() { signal(SIGVTALRM, SIG_IGN); }
    AllocationWatch(const AllocationWatch&) = delete;
    AllocationWatch& operator=(const AllocationWatch&) = delete;

 private:
    static void end_process(int) {
        static_cast<void>(send_message(kOutOfMemoryLine));
        _exit(static_cast<int>(model::ExitCode::kInternal));
    }
};

/// Ends as a failed allocation does if one of libseccomp's fails.
class CallFilter {
 public:
    CallFilter() : filter_(seccomp_init(SCMP_ACT_ERRNO(EPERM)), seccomp_release) {
        if (!filter_) fail_allocation();
        check_memory_for_filter();
    }
    template <std::size_t N>
    void allow(const int (&calls)[N]) {
        for (const int call : calls) allow(call);
    }
    template <class... Conditions>
    void allow(int call, const Conditions&... conditions) {
        add(SCMP_ACT_ALLOW, call, conditions...);
    }
    void refuse(int call, int error) { add(SCMP_ACT_ERRNO(static_cast<unsigned>(error)), call); }
    /// 0, or the error.
    [[nodiscard]] int load() const { return -checked(seccomp_load(filter_.get())); }

 private:
    /// Names that this processor's system does not have are left out by libseccomp itself.
    template <class... Conditions>
    void add(std::uint32_t action, int call, const Conditions&... conditions) {
        static_cast<void>(checked(seccomp_rule_add(filter_.get(), action, call, sizeof...(conditions), conditions...)));
    }
    /// EFAULT is libseccomp's answer to failures inside, which are those of allocations; those of the system are
    /// ECANCELED.
    static int checked(int answer) {
        if (answer == -ENOMEM || answer == -EFAULT) fail_allocation();
        return answer;
    }

    AllocationWatch watch_;
    std::unique_ptr<void, void (*)(scmp_filter_ctx)> filter_;
};

/// Conditions on an argument of a call, counted from 0. libseccomp's macros for them are compound literals of C.
scmp_arg_cmp equals(unsigned argument, scmp_datum_t value) {
    return {argument, SCMP_CMP_EQ, value, 0};
}
scmp_arg_cmp masked_equals(unsigned argument, scmp_datum_t mask, scmp_datum_t value) {
    return {argument, SCMP_CMP_MASKED_EQ, mask, value};
}

/// Empty if nothing but the lists above is left; else why not.
std::string restrict_calls(bool writes, bool threads) {
    CallFilter filter;
    filter.allow(kReading);
    if (writes) {
        filter.allow(kWriting);
    } else {
        constexpr auto kChanging =
            static_cast<scmp_datum_t>((O_ACCMODE | O_CREAT | O_TRUNC | O_TMPFILE) & ~O_DIRECTORY);
        filter.allow(SCMP_SYS(openat), masked_equals(2, kChanging, O_RDONLY));
        filter.allow(SCMP_SYS(open), masked_equals(1, kChanging, O_RDONLY));
    }
    if (threads) {
        filter.allow(kThreading);
        constexpr auto kThread = static_cast<scmp_datum_t>(CLONE_THREAD);
        filter.allow(SCMP_SYS(clone), masked_equals(0, kThread, kThread));
        filter.refuse(SCMP_SYS(clone3), ENOSYS);  // its flags are out of sight: the C library takes clone() instead
        filter.allow(SCMP_SYS(prctl), equals(0, PR_SET_NAME));
    }
    // abort() and the like, which signal the process itself.
    filter.allow(SCMP_SYS(tgkill), equals(0, static_cast<scmp_datum_t>(getpid())));
    filter.allow(SCMP_SYS(prlimit64), equals(0, 0), equals(2, 0));  // reading one's own
    const int error = filter.load();
    return error == 0 ? std::string() : failed("there is no list of system calls", error);
}

}  // namespace

Sandbox import_sandbox(const std::filesystem::path& mesh, std::vector<std::filesystem::path> readable) {
    Sandbox out{.readable = std::move(readable), .writable = {}};
    out.readable.push_back(mesh);  // it may be a link to another folder
    out.readable.push_back(mesh.has_parent_path() ? mesh.parent_path() : ".");
    out.readable.insert(out.readable.end(), std::begin(kSystemFiles), std::end(kSystemFiles));
    return out;
}

Sandbox worker_sandbox(const std::filesystem::path& mesh, std::vector<std::filesystem::path> readable,
                       const std::vector<std::filesystem::path>& outputs) {
    Sandbox out = import_sandbox(mesh, std::move(readable));
    out.cpu_seconds = 0;
    out.starts_threads = true;
    out.file_bytes = kMostOutputBytes;
    for (const std::filesystem::path& output : outputs)
        if (!output.empty()) out.writable.push_back(output.has_parent_path() ? output.parent_path() : ".");
    return out;
}

std::vector<std::string> enter_sandbox(const Sandbox& sandbox) {
    std::vector<std::string> missing;
    limit(RLIMIT_CORE, 0);
    if (sandbox.cpu_seconds > 0) limit(RLIMIT_CPU, sandbox.cpu_seconds, 1);  // SIGXCPU: not killed from outside
    limit(RLIMIT_NOFILE, sandbox.descriptors);
    signal(SIGXFSZ, SIG_IGN);
    limit(RLIMIT_FSIZE, sandbox.file_bytes);
    if (!sandbox.starts_threads) limit(RLIMIT_NPROC, 0);  // the system counts threads as processes
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) missing.push_back(failed("no_new_privs is not there", errno));
    for (const std::string& reason :
         {restrict_files(sandbox), restrict_calls(!sandbox.writable.empty(), sandbox.starts_threads)})
        if (!reason.empty()) missing.push_back(reason);
    return missing;
}

std::vector<std::string> sandbox_lacks() {
    std::vector<std::string> out;
    if (landlock_version() < 2)
        out.push_back("Landlock is not there, or of its first version: workers may write anywhere");
    if (prctl(PR_GET_SECCOMP, 0, 0, 0, 0) < 0) out.push_back("seccomp is not there: workers may make any system call");
    return out;
}

}  // namespace dgm::bake

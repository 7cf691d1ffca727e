/* SPDX-License-Identifier: GPL-3.0-or-later */
/* tests/e2e/fail_calls.c
 * Preloaded into the programs: the system runs short where a test wants it to.
 *
 *   DGM_DISK_BYTES=N           the disk is full after N bytes of one process have gone into regular files
 *   DGM_FAULT=KIND:N[:ACTION]  the N-th call of that kind (from 1; 0: none) fails; ACTION: once, on (this one and all
 *                              that follow), kill (SIGKILL to the process that makes it) [once]
 *   DGM_FAULT_COUNTS=FILE      a file of kFileBytes zeros: counts the calls of each kind, of all processes together
 *
 * Kinds: memory read write sync rename open map fork thread, and any (each of them but memory; remove too). Calls
 * before main() do not count: nothing of ours runs yet that could handle them. Reads and writes count for regular files
 * only; those that glibc makes for itself (stdio) are not seen. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum kind { kMemory, kRead, kWrite, kSync, kRename, kOpen, kMap, kFork, kThread, kRemove, kAny, kKinds };
static const char* const kNames[kKinds] = {"memory", "read", "write",  "sync",   "rename", "open",
                                           "map",    "fork", "thread", "remove", "any"};
enum action { kOnce, kOn, kKill };
enum { kFileBytes = 256 };

static struct {
    int armed;
    enum kind kind;
    enum action action;
    unsigned long long at;
    unsigned long long own[kKinds];
    unsigned long long* counts; /* own, or the file's: shared by threads and processes */
    long long disk_bytes;       /* -1: no limit */
} fault = {.disk_bytes = -1};

static void read_wish(void) {
    const char* disk = getenv("DGM_DISK_BYTES");
    if (disk) fault.disk_bytes = atoll(disk);
    fault.counts = fault.own;
    fault.kind = kKinds;
    const char* file = getenv("DGM_FAULT_COUNTS");
    if (file) {
        const int fd = (int)syscall(SYS_openat, AT_FDCWD, file, O_RDWR | O_CLOEXEC);
        void* shared =
            fd < 0 ? MAP_FAILED : (void*)syscall(SYS_mmap, NULL, kFileBytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
        if (shared != MAP_FAILED) fault.counts = shared;
        if (fd >= 0) syscall(SYS_close, fd);
    }
    const char* wish = getenv("DGM_FAULT");
    const char* number = wish ? strchr(wish, ':') : NULL;
    if (number == NULL) return;
    for (int k = 0; k < kKinds; ++k)
        if (strlen(kNames[k]) == (size_t)(number - wish) && strncmp(kNames[k], wish, (size_t)(number - wish)) == 0)
            fault.kind = (enum kind)k;
    char* end = NULL;
    fault.at = strtoull(number + 1, &end, 10);
    fault.action = strcmp(end, ":on") == 0 ? kOn : strcmp(end, ":kill") == 0 ? kKill : kOnce;
}

/* Counts a call. True: it has to fail. */
static int fails_one(enum kind kind) {
    const unsigned long long n = __atomic_add_fetch(&fault.counts[kind], 1, __ATOMIC_SEQ_CST);
    if (kind != fault.kind || fault.at == 0 || n < fault.at || (n != fault.at && fault.action != kOn)) return 0;
    if (fault.action == kKill) syscall(SYS_kill, syscall(SYS_getpid), SIGKILL);
    return 1;
}
static int fails(enum kind kind, int error) {
    if (!fault.armed) return 0;
    const int one = fails_one(kind), any = kind != kMemory && fails_one(kAny);
    if (one || any) errno = error;
    return one || any;
}

static int (*real_main)(int, char**, char**);
static int armed_main(int argc, char** argv, char** environment) {
    read_wish();
    fault.armed = 1;
    return real_main(argc, argv, environment);
}
int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(void), void (*fini)(void),
                      void (*rtld_fini)(void), void* stack_end) {
    int (*next)(int (*)(int, char**, char**), int, char**, void (*)(void), void (*)(void), void (*)(void), void*) =
        (int (*)(int (*)(int, char**, char**), int, char**, void (*)(void), void (*)(void), void (*)(void),
                 void*))dlsym(RTLD_NEXT, "__libc_start_main");
    real_main = main;
    return next(armed_main, argc, argv, init, fini, rtld_fini, stack_end);
}

#define NEXT(type, name, ...)         \
    static type (*next)(__VA_ARGS__); \
    if (!next) next = (type(*)(__VA_ARGS__))dlsym(RTLD_NEXT, name)

/* Memory: glibc's own names, since dlsym() allocates. */
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
void* malloc(size_t size) {
    return fails(kMemory, ENOMEM) ? NULL : __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
    return fails(kMemory, ENOMEM) ? NULL : __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) {
    return fails(kMemory, ENOMEM) ? NULL : __libc_realloc(old, size);
}
void* memalign(size_t alignment, size_t size) {
    return fails(kMemory, ENOMEM) ? NULL : __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
    return fails(kMemory, ENOMEM) ? NULL : __libc_memalign(alignment, size);
}
int posix_memalign(void** out, size_t alignment, size_t size) {
    if (fails(kMemory, ENOMEM)) return ENOMEM;
    *out = __libc_memalign(alignment, size);
    return *out ? 0 : ENOMEM;
}

/* A file on disk: no pipe, and not the job in memory. */
static int is_file(int fd) {
    struct stat status;
    char place[32], name[16];
    if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) return 0;
    snprintf(place, sizeof place, "/proc/self/fd/%d", fd);
    const ssize_t n = readlink(place, name, sizeof name);
    return !(n > 4 && strncmp(name, "/mem", 4) == 0);
}

/* How many of `wanted` bytes still fit; -1: none. */
static ssize_t take(int fd, size_t wanted) {
    if (!fault.armed) return (ssize_t)wanted;
    const int saved = errno, file = is_file(fd);
    errno = saved;
    if (!file) return (ssize_t)wanted;
    if (fails(kWrite, ENOSPC)) return -1;
    if (fault.disk_bytes < 0) return (ssize_t)wanted;
    if (fault.disk_bytes == 0) {
        errno = ENOSPC;
        return -1;
    }
    if ((long long)wanted > fault.disk_bytes) wanted = (size_t)fault.disk_bytes;
    fault.disk_bytes -= (long long)wanted;
    return (ssize_t)wanted;
}
ssize_t write(int fd, const void* data, size_t size) {
    NEXT(ssize_t, "write", int, const void*, size_t);
    const ssize_t n = take(fd, size);
    return n < 0 ? -1 : next(fd, data, (size_t)n);
}
ssize_t pwrite(int fd, const void* data, size_t size, off_t at) {
    NEXT(ssize_t, "pwrite", int, const void*, size_t, off_t);
    const ssize_t n = take(fd, size);
    return n < 0 ? -1 : next(fd, data, (size_t)n, at);
}
ssize_t pwrite64(int fd, const void* data, size_t size, off_t at) {
    return pwrite(fd, data, size, at);
}
ssize_t writev(int fd, const struct iovec* parts, int count) {
    NEXT(ssize_t, "writev", int, const struct iovec*, int);
    if (count <= 0) return next(fd, parts, count);
    const ssize_t n = take(fd, parts[0].iov_len);
    if (n < 0) return -1;
    return (size_t)n == parts[0].iov_len ? next(fd, parts, count) : write(fd, parts[0].iov_base, (size_t)n);
}

static int read_fails(int fd) {
    if (!fault.armed) return 0;
    const int saved = errno, file = is_file(fd);
    errno = saved;
    return file && fails(kRead, EIO);
}
ssize_t read(int fd, void* to, size_t size) {
    NEXT(ssize_t, "read", int, void*, size_t);
    return read_fails(fd) ? -1 : next(fd, to, size);
}
ssize_t pread(int fd, void* to, size_t size, off_t at) {
    NEXT(ssize_t, "pread", int, void*, size_t, off_t);
    return read_fails(fd) ? -1 : next(fd, to, size, at);
}
ssize_t pread64(int fd, void* to, size_t size, off_t at) {
    return pread(fd, to, size, at);
}
int fsync(int fd) {
    NEXT(int, "fsync", int);
    return fails(kSync, EIO) ? -1 : next(fd);
}
int fdatasync(int fd) {
    NEXT(int, "fdatasync", int);
    return fails(kSync, EIO) ? -1 : next(fd);
}

int rename(const char* from, const char* to) {
    NEXT(int, "rename", const char*, const char*);
    return fails(kRename, EIO) ? -1 : next(from, to);
}
int renameat(int from_folder, const char* from, int to_folder, const char* to) {
    NEXT(int, "renameat", int, const char*, int, const char*);
    return fails(kRename, EIO) ? -1 : next(from_folder, from, to_folder, to);
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
    NEXT(int, "renameat2", int, const char*, int, const char*, unsigned);
    return fails(kRename, EIO) ? -1 : next(from_folder, from, to_folder, to, flags);
}
int unlink(const char* path) {
    NEXT(int, "unlink", const char*);
    return fails(kRemove, EIO) ? -1 : next(path);
}
int unlinkat(int folder, const char* path, int flags) {
    NEXT(int, "unlinkat", int, const char*, int);
    return fails(kRemove, EIO) ? -1 : next(folder, path, flags);
}
int rmdir(const char* path) {
    NEXT(int, "rmdir", const char*);
    return fails(kRemove, EIO) ? -1 : next(path);
}

/* Descriptors run out. */
#define MODE(flags)                               \
    mode_t mode = 0;                              \
    if (((flags) & (O_CREAT | O_TMPFILE)) != 0) { \
        va_list rest;                             \
        va_start(rest, flags);                    \
        mode = va_arg(rest, mode_t);              \
        va_end(rest);                             \
    }
int open(const char* path, int flags, ...) {
    NEXT(int, "open", const char*, int, ...);
    MODE(flags)
    return fails(kOpen, EMFILE) ? -1 : next(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
    NEXT(int, "open64", const char*, int, ...);
    MODE(flags)
    return fails(kOpen, EMFILE) ? -1 : next(path, flags, mode);
}
int openat(int folder, const char* path, int flags, ...) {
    NEXT(int, "openat", int, const char*, int, ...);
    MODE(flags)
    return fails(kOpen, EMFILE) ? -1 : next(folder, path, flags, mode);
}
int openat64(int folder, const char* path, int flags, ...) {
    NEXT(int, "openat64", int, const char*, int, ...);
    MODE(flags)
    return fails(kOpen, EMFILE) ? -1 : next(folder, path, flags, mode);
}
FILE* fopen(const char* path, const char* mode) {
    NEXT(FILE*, "fopen", const char*, const char*);
    return fails(kOpen, EMFILE) ? NULL : next(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
    NEXT(FILE*, "fopen64", const char*, const char*);
    return fails(kOpen, EMFILE) ? NULL : next(path, mode);
}
DIR* opendir(const char* path) {
    NEXT(DIR*, "opendir", const char*);
    return fails(kOpen, EMFILE) ? NULL : next(path);
}
int pipe2(int ends[2], int flags) {
    NEXT(int, "pipe2", int*, int);
    return fails(kOpen, EMFILE) ? -1 : next(ends, flags);
}
int socketpair(int domain, int type, int protocol, int ends[2]) {
    NEXT(int, "socketpair", int, int, int, int*);
    return fails(kOpen, EMFILE) ? -1 : next(domain, type, protocol, ends);
}
int memfd_create(const char* name, unsigned flags) {
    NEXT(int, "memfd_create", const char*, unsigned);
    return fails(kOpen, EMFILE) ? -1 : next(name, flags);
}

void* mmap(void* wanted, size_t size, int protection, int flags, int fd, off_t at) {
    NEXT(void*, "mmap", void*, size_t, int, int, int, off_t);
    return fails(kMap, ENOMEM) ? MAP_FAILED : next(wanted, size, protection, flags, fd, at);
}
void* mmap64(void* wanted, size_t size, int protection, int flags, int fd, off_t at) {
    return mmap(wanted, size, protection, flags, fd, at);
}
pid_t fork(void) {
    NEXT(pid_t, "fork", void);
    return fails(kFork, EAGAIN) ? -1 : next();
}
int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*body)(void*), void* argument) {
    NEXT(int, "pthread_create", pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
    return fails(kThread, EAGAIN) ? EAGAIN : next(thread, attributes, body, argument);
}

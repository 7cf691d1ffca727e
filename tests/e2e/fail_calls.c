/* SPDX-License-Identifier: GPL-3.0-or-later */
/* tests/e2e/fail_writes.c
 * Preloaded into dgm-bake: the disk is full after DGM_DISK_BYTES bytes of one process have gone into regular files.
 * Where the test may not mount a small file system, this says ENOSPC in its place. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static long long left = -2;

/* How many of `wanted` bytes still fit; -1: none. */
static ssize_t take(int fd, size_t wanted) {
    struct stat status;
    if (left == -2) {
        const char* limit = getenv("DGM_DISK_BYTES");
        left = limit ? atoll(limit) : -1;
    }
    if (left < 0 || fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) return (ssize_t)wanted;
    char path[64], name[4096];
    int length = 0;
    for (int k = fd; k > 0; k /= 10) ++length;
    char* p = path;
    for (const char* s = "/proc/self/fd/"; *s; ++s) *p++ = *s;
    for (int k = length - 1, n = fd; k >= 0; --k, n /= 10) p[k] = (char)('0' + n % 10);
    p[length] = 0;
    ssize_t n = readlink(path, name, sizeof name - 1);
    if (n > 0 && name[0] == '/' && name[1] == 'm' && name[2] == 'e' && name[3] == 'm')
        return (ssize_t)wanted; /* the job */
    if (left == 0) return -1;
    if ((long long)wanted > left) wanted = (size_t)left;
    left -= (long long)wanted;
    return (ssize_t)wanted;
}

ssize_t write(int fd, const void* data, size_t size) {
    static ssize_t (*next)(int, const void*, size_t);
    if (!next) next = (ssize_t(*)(int, const void*, size_t))dlsym(RTLD_NEXT, "write");
    const ssize_t n = take(fd, size);
    if (n < 0) {
        errno = ENOSPC;
        return -1;
    }
    return next(fd, data, (size_t)n);
}

ssize_t pwrite(int fd, const void* data, size_t size, off_t at) {
    static ssize_t (*next)(int, const void*, size_t, off_t);
    if (!next) next = (ssize_t(*)(int, const void*, size_t, off_t))dlsym(RTLD_NEXT, "pwrite");
    const ssize_t n = take(fd, size);
    if (n < 0) {
        errno = ENOSPC;
        return -1;
    }
    return next(fd, data, (size_t)n, at);
}

ssize_t pwrite64(int fd, const void* data, size_t size, off_t at) {
    return pwrite(fd, data, size, at);
}

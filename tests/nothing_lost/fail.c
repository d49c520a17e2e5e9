// A layer between a program and the system, put there by LD_PRELOAD: of the calls that write below the folder FAIL_UNDER, number FAIL_AT
// fails (with FAIL_ON too all after it), by the error FAIL_AS or, "short", by writing half. How many there were goes to FAIL_COUNT.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

static long calls;

static int below(const char *path) {
    const char *under = getenv("FAIL_UNDER");
    char whole[4096];
    if (!under || !path) return 0;
    if (path[0] != '/') {
        if (!getcwd(whole, sizeof whole - 1)) return 0;
        return !strncmp(whole, under, strlen(under));
    }
    return !strncmp(path, under, strlen(under));
}

static int open_below(int file) {
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    if (path[0] != '/') return 0; // a pipe
    return below(path);
}

// 0: goes on; 1: fails; 2: is short.
static int fails(void) {
    long call = __atomic_add_fetch(&calls, 1, __ATOMIC_SEQ_CST);
    const char *at = getenv("FAIL_AT"), *as = getenv("FAIL_AS");
    if (!at || (getenv("FAIL_ON") ? call < atol(at) : call != atol(at))) return 0;
    if (as && !strcmp(as, "short")) return 2;
    errno = as && !strcmp(as, "EIO") ? EIO : as && !strcmp(as, "EROFS") ? EROFS : ENOSPC;
    return 1;
}

#define REAL(name) __typeof__(name) *real = (__typeof__(name) *)dlsym(RTLD_NEXT, #name)

ssize_t write(int file, const void *bytes, size_t count) {
    REAL(write);
    if (open_below(file)) {
        int how = fails();
        if (how == 1) return -1;
        if (how == 2) return real(file, bytes, count > 1 ? count / 2 : count);
    }
    return real(file, bytes, count);
}

static int opens(const char *path, int flags) { return (flags & (O_CREAT | O_TRUNC)) && below(path) && fails() == 1; }

#define OPEN(name)                                   \
    int name(const char *path, int flags, ...) {     \
        REAL(name);                                  \
        va_list rest;                                \
        va_start(rest, flags);                       \
        mode_t mode = va_arg(rest, mode_t);          \
        va_end(rest);                                \
        if (opens(path, flags)) return -1;           \
        return real(path, flags, mode);              \
    }
OPEN(open)
OPEN(open64)

int rename(const char *from, const char *to) {
    REAL(rename);
    if (below(to) && fails() == 1) return -1;
    return real(from, to);
}

int mkdir(const char *path, mode_t mode) {
    REAL(mkdir);
    if (below(path) && fails() == 1) return -1;
    return real(path, mode);
}

// A disc that is full lets files go: not a call that may fail so.
static int removes(int is_below) {
    const char *as = getenv("FAIL_AS");
    return is_below && as && strcmp(as, "ENOSPC") && fails() == 1;
}

int unlink(const char *path) {
    REAL(unlink);
    if (removes(below(path))) return -1;
    return real(path);
}

int rmdir(const char *path) {
    REAL(rmdir);
    if (removes(below(path))) return -1;
    return real(path);
}

int unlinkat(int folder, const char *path, int flags) {
    REAL(unlinkat);
    if (removes(folder == AT_FDCWD || path[0] == '/' ? below(path) : open_below(folder))) return -1;
    return real(folder, path, flags);
}

#define ON_FILE(name, declared, given)               \
    int name declared {                              \
        REAL(name);                                  \
        if (open_below(file) && fails() == 1) return -1; \
        return real given;                           \
    }
ON_FILE(fsync, (int file), (file))
ON_FILE(fdatasync, (int file), (file))
ON_FILE(ftruncate, (int file, off_t length), (file, length))
ON_FILE(ftruncate64, (int file, off64_t length), (file, length))

__attribute__((destructor)) static void told(void) {
    const char *path = getenv("FAIL_COUNT");
    if (!path) return;
    FILE *file = fopen(path, "w");
    if (!file) return;
    fprintf(file, "%ld\n", calls);
    fclose(file);
}

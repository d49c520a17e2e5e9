/* A solve with nothing beneath it: no C library, no allocator, no start-up code. See docs/integrators.md for how it is linked.
 * x86-64 Linux; the only thing asked of the system is to end the process. Exit code 0: a result that is what was wanted. */
#include "thurible.h"

#define SIDE 16
#define STEPS 6

/* The only memory: more than thurible_plan asks for. */
static _Alignas(64) unsigned char pool[1 << 20];
static float from[SIDE * SIDE], to[SIDE * SIDE];

/* What compilers ask of a freestanding program. */
void *memset(void *to_, int value, size_t bytes) {
    unsigned char *out = to_;
    while (bytes--) *out++ = (unsigned char)value;
    return to_;
}

void *memcpy(void *restrict to_, const void *restrict from_, size_t bytes) {
    unsigned char *out = to_;
    const unsigned char *in = from_;
    while (bytes--) *out++ = *in++;
    return to_;
}

void *memmove(void *to_, const void *from_, size_t bytes) {
    unsigned char *out = to_;
    const unsigned char *in = from_;
    if (out < in) return memcpy(to_, from_, bytes);
    while (bytes--) out[bytes] = in[bytes];
    return to_;
}

int memcmp(const void *left_, const void *right_, size_t bytes) {
    const unsigned char *left = left_, *right = right_;
    for (; bytes; bytes--, left++, right++)
        if (*left != *right) return *left < *right ? -1 : 1;
    return 0;
}

int bcmp(const void *left, const void *right, size_t bytes) {
    return memcmp(left, right, bytes);
}

static int solve(void) {
    for (int cell = 0; cell < SIDE * SIDE; cell++) {
        int x = cell % SIDE, y = cell / SIDE;
        from[cell] = x >= 3 && x < 9 && y >= 4 && y < 10;
        to[cell] = x >= 6 && x < 12 && y >= 5 && y < 11;
    }
    ThuribleConfig config;
    if (thurible_defaults(&config, sizeof config) != THURIBLE_RESULT_OK) return 1;
    const size_t keyframe = STEPS;
    config.cells[0] = config.cells[1] = SIDE;
    config.steps = STEPS;
    config.force_weight = 10.0;
    config.keyframes = &keyframe;
    config.keyframe_count = 1;
    size_t bytes = 0, alignment = 0;
    if (thurible_plan(&config, &bytes, &alignment, 0) != THURIBLE_RESULT_OK || bytes > sizeof pool || alignment > 64) return 2;
    Thurible *solver = 0;
    if (thurible_init(pool, bytes - 1, &config, &solver) != THURIBLE_RESULT_TOO_SMALL || solver) return 3;
    if (thurible_init(pool, bytes, &config, &solver) != THURIBLE_RESULT_OK) return 4;
    if (thurible_set_source(solver, from, sizeof from) != THURIBLE_RESULT_OK) return 5;
    if (thurible_set_keyframe(solver, 0, to, sizeof to, 0) != THURIBLE_RESULT_OK) return 6;
    ThuribleProgress progress;
    if (thurible_step(solver, 0, 0, &progress) != THURIBLE_RESULT_OK || progress.status != THURIBLE_STATUS_GOES) return 7;
    if (thurible_solve(solver, 0, 0, &progress) != THURIBLE_RESULT_OK) return 8;
    if (progress.status != THURIBLE_STATUS_CONVERGED && progress.status != THURIBLE_STATUS_MAX_ITERATIONS) return 9;
    if (thurible_copy(solver, THURIBLE_FIELD_DENSITY, STEPS, 0, from, sizeof from) != THURIBLE_RESULT_OK) return 10;
    float mass = 0, apart = 0;
    for (int cell = 0; cell < SIDE * SIDE; cell++) {
        mass += to[cell];
        apart += from[cell] > to[cell] ? from[cell] - to[cell] : to[cell] - from[cell];
    }
    return apart < 0.5f * mass ? 0 : 11; /* at the beginning the two squares are 1.17 masses apart */
}

__attribute__((noreturn)) static void leave(long code) {
    __asm__ volatile("syscall" : : "a"(60L), "D"(code) : "rcx", "r11", "memory");
    __builtin_unreachable();
}

/* Where a panic ends, should there be one, if the library was built with the feature host_panic. */
void thurible_panicked(const char *file, size_t length, uint32_t line);
void thurible_panicked(const char *file, size_t length, uint32_t line) {
    (void)file, (void)length, (void)line;
    leave(97);
}

/* Called by _start with a stack that is aligned. */
__attribute__((used, noreturn)) static void run(void) { leave(solve()); }

__asm__(".globl _start\n_start: xor %ebp, %ebp\n and $-16, %rsp\n call run\n");

/* What the programs of this folder share: checks that say where they fail, memory, numbers of either precision. */
#ifndef CHECK_H
#define CHECK_H
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif
#include "thurible.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

#define CHECK(what) \
    do { \
        if (!(what)) { \
            failures++; \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #what); \
        } \
    } while (0)
#define IS(call, result) check_result(__LINE__, #call, (call), THURIBLE_RESULT_##result)
#define OK(call) IS(call, OK)
#define SAYS(message, handle, words) says(__LINE__, message(handle, NULL, 0), message(handle, text, sizeof text), words)

static char text[400] __attribute__((unused));

static inline void check_result(int line, const char *call, ThuribleResult found, ThuribleResult wanted) {
    if (found != wanted) {
        failures++;
        fprintf(stderr, "%d: %s: %s, but should be: %s\n", line, call, thurible_result_text(found), thurible_result_text(wanted));
    }
}

static inline void says(int line, size_t counted, size_t written, const char *words) {
    if (counted != written || !strstr(text, words)) {
        failures++;
        fprintf(stderr, "%d: it says \"%s\", but should: %s\n", line, text, words);
    }
}

static inline void *aligned(size_t bytes) {
    void *memory = NULL;
    if (posix_memalign(&memory, 64, bytes ? bytes : 64) != 0) exit(99);
    memset(memory, 0xA5, bytes);
    return memory;
}

static inline void put(void *field, size_t number, size_t index, double value) {
    if (number == 4) ((float *)field)[index] = (float)value;
    else ((double *)field)[index] = value;
}

static inline double get(const void *field, size_t number, size_t index) {
    return number == 4 ? ((const float *)field)[index] : ((const double *)field)[index];
}

#endif

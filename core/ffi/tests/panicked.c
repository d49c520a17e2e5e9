/* Where a panic of a library built with host_panic ends: it says where it was and stops the program. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef __cplusplus
extern "C"
#endif
void thurible_panicked(const char *file, size_t length, uint32_t line);

void thurible_panicked(const char *file, size_t length, uint32_t line) {
    fprintf(stderr, "panic at %.*s:%u\n", (int)length, file, (unsigned)line);
    abort();
}

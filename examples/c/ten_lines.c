/* From nothing to a solved scene: how to compile it is in docs/integrators.md. */
#include "thurible.h"
#include <stdio.h>

static _Alignas(64) unsigned char memory[1 << 20];
static float from[24 * 24], to[24 * 24];

int main(void) {
    for (int cell = 0; cell < 24 * 24; cell++) { /* a square of smoke, which is to move up and to the right */
        int x = cell % 24, y = cell / 24;
        from[cell] = x >= 5 && x < 13 && y >= 5 && y < 13;
        to[cell] = x >= 10 && x < 18 && y >= 9 && y < 17;
    }
    ThuribleConfig config;
    Thurible *solver;
    ThuribleProgress progress;
    const size_t keyframe = 10;
    /* begin */
    thurible_defaults(&config, sizeof config);
    config.cells[0] = config.cells[1] = 24;
    config.steps = 10;
    config.keyframes = &keyframe;
    config.keyframe_count = 1;
    if (thurible_init(memory, sizeof memory, &config, &solver) != THURIBLE_RESULT_OK) return 1;
    if (thurible_set_source(solver, from, sizeof from) != THURIBLE_RESULT_OK) return 1;
    if (thurible_set_keyframe(solver, 0, to, sizeof to, NULL) != THURIBLE_RESULT_OK) return 1;
    if (thurible_solve(solver, NULL, NULL, &progress) != THURIBLE_RESULT_OK) return 1;
    if (thurible_copy(solver, THURIBLE_FIELD_DENSITY, 10, 0, to, sizeof to) != THURIBLE_RESULT_OK) return 1;
    /* end */
    printf("%s: objective %.3f\n", thurible_status_text(progress.status), progress.data + progress.force);
    for (int row = 23; row >= 0; row--) {
        for (int x = 0; x < 24; x++) {
            float density = to[row * 24 + x];
            int shade = density > 0.875f ? 4 : density > 0.0f ? (int)(density * 4.0f + 0.5f) : 0;
            printf("%c%c", " .:o#"[shade], " .:o#"[shade]);
        }
        printf("\n");
    }
    return progress.status == THURIBLE_STATUS_NOT_FINITE;
}

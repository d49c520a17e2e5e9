/* Configurations and saved bytes that were changed at random: every call answers in order. FUZZ RUNS [SEED]; a call that takes longer than
 * a second, ten where the flow crosses the box in a step and by ADMM, a minute in a box of 64 to 1, or panics, ends the program. What the caller promises is kept: lists are as long as their counts say. */
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif
#include "thurible.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define MOST ((size_t)1 << 22)

static uint64_t state = 0x9E3779B97F4A7C15u;

static uint64_t next(void) { /* xorshift64*, Vigna 2016 */
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return state * 0x2545F4914F6CDD1Du;
}

static size_t below(size_t end) { return (size_t)((next() >> 16) % end); }

/* Of a processor: that other work has it meanwhile is no hang. */
static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static const double numbers[] = {0.0, -0.0, 1.0, -1.0, 0.5, 1e-300, 1e300, 1e-5, 64.0, 1e6};
static const size_t counts[] = {0, 1, 2, 3, 4, 5, 7, 8, 9, 63, 64, 1024, 1025, 4096, 4097, 65535, (size_t)1 << 31, (size_t)1 << 40, SIZE_MAX - 1, SIZE_MAX};

/* Changes a word, a number or a bit of it. */
static void change(unsigned char *bytes, size_t size) {
    size_t at = below(size / 8) * 8;
    double number = below(3) ? numbers[below(10)] : (double)(int64_t)next() * 1e-12;
    uint64_t count = counts[below(20)];
    uint32_t half = (uint32_t)counts[below(20)];
    switch (below(5)) {
    case 0: bytes[below(size)] ^= (unsigned char)(1u << below(8)); break;
    case 1: memcpy(bytes + at, &number, 8); break;
    case 2: memcpy(bytes + at, &count, 8); break;
    case 3: memcpy(bytes + at + 4 * below(2), &half, 4); break;
    default: half = (uint32_t)below(10), memcpy(bytes + at + 4 * below(2), &half, 4);
    }
}

static size_t keyframes[2] = {3, 4};
static double weights[2] = {1.0, 2.0};
static ThuribleEmitter emitters[2];
static ThuribleFactor factors[2];
static ThuribleTemplate templates[2];

/* Lists that are there, with anything in them. */
static void lists(ThuribleConfig *config) {
    keyframes[0] = 3, keyframes[1] = 4;
    if (!below(8)) change((unsigned char *)keyframes, sizeof keyframes);
    if (!below(4)) change((unsigned char *)weights, sizeof weights);
    if (!below(2)) change((unsigned char *)emitters, sizeof emitters);
    if (!below(2)) change((unsigned char *)factors, sizeof factors);
    if (!below(2)) change((unsigned char *)templates, sizeof templates);
    config->keyframes = keyframes, config->keyframe_count = 1 + below(2);
    config->keyframe_weights = below(2) ? weights : NULL;
    config->emitters = emitters, config->emitter_count = below(3) ? 0 : below(3);
    config->schedule = factors, config->schedule_count = below(3) ? 0 : below(3);
    config->templates = templates, config->template_count = below(3) ? 0 : below(3);
}

static unsigned char memory_[MOST + 4096], saved[MOST];
static double field[1 << 16];

/* Makes an instance, fills it, saves it, restores what was changed of it, and takes a step. */
static int goes_through(const ThuribleConfig *config, size_t bytes, size_t saved_bytes) {
    Thurible *solver = NULL;
    ThuribleProgress progress;
    char text[300];
    unsigned char *memory = memory_ + (4096 - (uintptr_t)memory_ % 4096) % 4096;
    if (thurible_init(memory, bytes, config, &solver)) return 0;
    size_t cells = config->cells[0] * config->cells[1] * (config->dimensions == 3 ? config->cells[2] : 1), size = cells * config->precision;
    if (size > sizeof field) return 0;
    if (config->precision == 4) for (size_t cell = 0; cell < cells; cell++) ((float *)field)[cell] = (float)(cell % 5) / 5;
    else for (size_t cell = 0; cell < cells; cell++) field[cell] = (double)(cell % 5) / 5;
    if (!below(8)) change((unsigned char *)field, size);
    thurible_set_source(solver, field, below(8) ? size : counts[below(12)]);
    for (size_t index = 0; index < 2; index++) thurible_set_keyframe(solver, below(8) ? index : counts[below(20)], field, size, NULL);
    for (size_t index = 0; index < config->emitter_count; index++) thurible_set_emitter(solver, index, field, size);
    int solved = thurible_step(solver, NULL, NULL, &progress) == 0;
    if (saved_bytes <= MOST && !thurible_save(solver, saved, saved_bytes)) {
        for (size_t count = below(3); count > 0; count--) change(saved, below(2) ? 1536 : saved_bytes / 8 * 8);
        thurible_restore(solver, saved, below(8) ? saved_bytes : below(saved_bytes));
        thurible_step(solver, NULL, NULL, &progress);
    }
    thurible_message(solver, text, sizeof text);
    thurible_close(solver);
    return solved;
}

static double rest[27];
static uint32_t corners[32];
static uint8_t held[9];
static ThuribleSpring springs[2];

/* A square of eight triangles with anything in it, and two steps of it: 1 where it was planned, 2 where it took a step, -1 for a refusal without a reason. */
static int body(void) {
    ThuribleCondenseConfig config;
    ThuribleCondenser *condenser = NULL;
    ThuribleCondensed stepped;
    ThuribleIteration told[2];
    char text[300];
    size_t bytes = 0, scratch = 0;
    unsigned char *memory = memory_ + (4096 - (uintptr_t)memory_ % 4096) % 4096;
    if (thurible_condense_defaults(&config, sizeof config)) return -1;
    for (size_t at = 0; at < 9; at++) rest[2 * at] = (double)(at % 3) / 2, rest[2 * at + 1] = (double)(at / 3) / 2, held[at] = at % 3 == 0;
    for (size_t cell = 0; cell < 4; cell++) {
        const uint32_t a = (uint32_t)(cell % 2 + 3 * (cell / 2)), all[6] = {a, a + 1, a + 4, a, a + 4, a + 3};
        memcpy(corners + 6 * cell, all, sizeof all);
    }
    memset(springs, 0, sizeof springs);
    springs[0].ends[1] = 8, springs[0].stiffness = 1.0, springs[1] = springs[0];
    config.cap = 2, config.method = (uint32_t)below(8), config.basis = below(2) ? 0 : (uint32_t)below(6), config.precision = below(2) ? 4 : 8;
    for (size_t changes = below(4); changes > 0; changes--) change((unsigned char *)&config, sizeof config);
    if (config.cap > 8 && config.cap <= 100000000) config.cap = 8;
    config.vertex_count = below(16) ? 9 : below(10), config.rest = rest, config.held = held;
    config.element_count = below(16) ? 8 : below(9), config.elements = corners;
    config.spring_count = below(3), config.springs = springs;
    if (!below(3)) change((unsigned char *)rest, sizeof rest);
    if (!below(4)) change((unsigned char *)corners, sizeof corners);
    if (!below(4)) held[below(9)] = (uint8_t)below(3);
    if (!below(4)) change((unsigned char *)springs, sizeof springs);
    int refused = thurible_condense_scratch(&config, &scratch);
    if (!refused) refused = thurible_condense_plan(&config, saved, MOST, &bytes, NULL);
    if (refused) return thurible_condense_explain(&config, saved, MOST, text, sizeof text) ? 0 : -1;
    if (bytes > MOST || thurible_condense_init(memory, bytes, &config, &condenser)) return 1;
    const size_t size = config.vertex_count * config.dimensions * sizeof(double);
    for (int step = 0; step < 2; step++) {
        if (!below(4)) change((unsigned char *)field, 16 * 9);
        const int moves = below(2) != 0;
        thurible_condense_step(condenser, NULL, NULL, moves ? field : NULL, moves ? size : 8 * below(2), below(2) ? field : NULL, told, below(3), &stepped);
        thurible_condense_set_velocity(condenser, field, size);
    }
    thurible_condense_read(condenser, (uint32_t)below(5), field, size);
    thurible_condense_message(condenser, text, sizeof text);
    thurible_condense_close(condenser);
    return 2;
}

/* Seconds that a step may take: more where buoyancy drives the flow through the whole box in it, which takes many iterations of the implicit step;
 * by ADMM, which goes through 30 cycles and more in it; and where a box is so long that multigrid smooths its coarser grids hundreds of times. */
static double most(const ThuribleConfig *config) {
    size_t longest = 1, shortest = SIZE_MAX;
    for (uint32_t axis = 0; axis < config->dimensions && axis < 3; axis++) {
        const size_t cells = config->cells[axis];
        longest = cells > longest ? cells : longest, shortest = cells < shortest ? cells : shortest;
    }
    if (shortest > 0 && longest / shortest >= 64) return 60.0;
    if (config->method == THURIBLE_METHOD_ADMM) return 10.0;
    for (int axis = 0; axis < 3; axis++)
        if (config->buoyancy[axis] > 1.0 || config->buoyancy[axis] < -1.0) return 10.0;
    return 1.0;
}

int main(int count, char **arguments) {
    size_t runs = count > 1 ? (size_t)strtoull(arguments[1], NULL, 10) : 100000, planned = 0, solved = 0, bodies = 0, moved = 0;
    if (count > 2) state ^= strtoull(arguments[2], NULL, 10);
    double slowest = 0;
    for (size_t run = 0; run < runs; run++) {
        ThuribleConfig config;
        if (thurible_defaults(&config, sizeof config)) return 99;
        config.dimensions = 2 + (uint32_t)below(2), config.precision = below(2) ? 4 : 8, config.method = (uint32_t)below(7);
        for (int axis = 0; axis < 3; axis++) config.cells[axis] = 4 + below(5);
        config.steps = 4, config.iterations = 2, config.threads = 1;
        for (size_t changes = below(4); changes > 0; changes--) change((unsigned char *)&config, sizeof config);
        lists(&config);
        char text[300];
        size_t bytes = 0, alignment = 0, saved_bytes = 0;
        double begun = seconds();
        int refused = thurible_plan(&config, &bytes, &alignment, &saved_bytes);
        if (refused != 0 && thurible_explain(&config, text, sizeof text) == 0) {
            printf("run %zu: a configuration is refused without a reason\n", run);
            return 1;
        }
        if (!refused) {
            planned++;
            if (bytes <= MOST) solved += (size_t)goes_through(&config, bytes, saved_bytes);
        }
        const int went = body();
        if (went < 0) {
            printf("run %zu: a body is refused without a reason\n", run);
            return 1;
        }
        bodies += went > 0, moved += went > 1;
        double took = seconds() - begun;
        if (took > slowest) slowest = took;
        /* A step of many iterations within may be asked for: what is asked for is no hang. */
        if (took > most(&config) && config.steps <= 4 && config.nso_cycles <= 63 && config.admm_ao_iterations <= 8) {
            printf("run %zu took %.1f s: method %u in %zu x %zu x %zu cells, at most %zu cycles\n", run, took, config.method, config.cells[0], config.cells[1],
                   config.cells[2], (size_t)config.nso_cycles);
            return 1;
        }
    }
    printf("| C arguments | %zu | %zu planned, %zu took a step | %zu | %.0f ms | |\n", runs, planned, solved, runs - planned, 1e3 * slowest);
    printf("| C bodies | %zu | %zu planned, %zu took a step | %zu | | |\n", runs, bodies, moved, runs - bodies);
    return 0;
}

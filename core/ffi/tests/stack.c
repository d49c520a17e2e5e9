/* How much stack the library uses: every method, precision and dimension is planned, made, filled, solved, saved and restored, and a tracker too, on a
 * thread whose stack was painted, and the deepest byte that lost its paint counts. The last column begins on one coarser grid more than the
 * others. With an argument, fails above that many bytes in the others. */
#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 200809L
#endif
#include "thurible.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STACK ((size_t)1 << 20)
#define PAINT 0xC5

typedef struct {
    ThuribleConfig config;
    void *memory, *source, *target, *saved;
    size_t bytes, field_bytes, saved_bytes;
    int failed, idle;
    const ThuribleTrackConfig *track; /* a tracker instead of a solver */
} Job;

/* Plans and makes a tracker, gives two frames and finds the flow between them; whether one of that failed. */
static int tracks(const Job *job) {
    ThuribleTracker *tracker;
    ThuriblePair pair;
    return thurible_track_plan(job->track, NULL, NULL) || thurible_track_init(job->memory, job->bytes, job->track, &tracker) ||
           thurible_track_give(tracker, NULL, job->source, NULL, job->field_bytes) ||
           thurible_track_give(tracker, NULL, job->target, NULL, job->field_bytes) ||
           thurible_track_step(tracker, NULL, NULL, NULL, NULL, NULL, NULL, &pair);
}

static void *solve(void *job_) {
    Job *job = (Job *)job_;
    if (job->idle) return NULL;
    if (job->track) {
        job->failed = tracks(job);
        return NULL;
    }
    Thurible *solver;
    ThuribleProgress progress;
    char text[200];
    job->failed = thurible_plan(&job->config, NULL, NULL, NULL) || thurible_init(job->memory, job->bytes, &job->config, &solver) ||
                  thurible_set_source(solver, job->source, job->field_bytes) ||
                  thurible_set_keyframe(solver, 0, job->target, job->field_bytes, NULL) || thurible_step(solver, NULL, NULL, &progress) ||
                  thurible_save(solver, job->saved, job->saved_bytes) || thurible_restore(solver, job->saved, job->saved_bytes) ||
                  thurible_solve(solver, NULL, NULL, &progress) || progress.status == THURIBLE_STATUS_NOT_FINITE;
    job->config.length = -1.0;
    job->failed |= thurible_message(solver, text, sizeof text) != 0 || thurible_explain(&job->config, text, sizeof text) == 0;
    return NULL;
}

static void *aligned(size_t bytes) {
    void *memory = NULL;
    if (posix_memalign(&memory, 4096, bytes) != 0) exit(99);
    return memory;
}

/* Bytes that a thread with this job used. */
static size_t used(Job *job) {
    static unsigned char *stack = NULL;
    if (!stack) stack = (unsigned char *)aligned(STACK);
    memset(stack, PAINT, STACK);
    pthread_attr_t attributes;
    pthread_t thread;
    if (pthread_attr_init(&attributes) || pthread_attr_setstack(&attributes, stack, STACK)) exit(99);
    if (pthread_create(&thread, &attributes, solve, job) || pthread_join(thread, NULL)) exit(99);
    pthread_attr_destroy(&attributes);
    size_t clean = 0;
    while (clean < STACK && stack[clean] == PAINT) clean++;
    return STACK - clean;
}

/* Patches all over the box, of which two fields are hard to match. */
static void fill(Job *job, uint32_t precision, size_t cells) {
    job->field_bytes = cells * precision;
    job->source = aligned(job->field_bytes);
    job->target = aligned(job->field_bytes);
    for (size_t cell = 0; cell < cells; cell++) {
        double from = cell / 16 % 3 == 0, to = cell / 16 % 4 == 0;
        if (precision == 4) ((float *)job->source)[cell] = (float)from, ((float *)job->target)[cell] = (float)to;
        else ((double *)job->source)[cell] = from, ((double *)job->target)[cell] = to;
    }
}

/* Bytes that a job takes, whose memory is given back. */
static size_t bytes_of(Job *job, const char *what, size_t idle) {
    const size_t bytes = used(job) - idle;
    if (job->failed) {
        printf("\n%s was refused\n", what);
        exit(1);
    }
    free(job->memory), free(job->saved), free(job->source), free(job->target);
    return bytes;
}

/* Bytes that tracking takes. */
static size_t tracking(uint32_t dimensions, uint32_t precision, size_t side, size_t idle) {
    ThuribleTrackConfig config;
    Job job;
    memset(&job, 0, sizeof job);
    if (thurible_track_defaults(&config, sizeof config, THURIBLE_MINIMISER_DIRECT)) exit(99);
    for (int axis = 0; axis < 3; axis++) config.cells[axis] = side;
    config.precision = precision;
    config.dimensions = dimensions;
    config.readvect = config.forces = 1;
    if (thurible_track_plan(&config, &job.bytes, NULL)) exit(99);
    job.track = &config;
    job.memory = aligned(job.bytes);
    fill(&job, precision, side * side * (dimensions == 3 ? side : 1));
    return bytes_of(&job, "tracking", idle);
}

/* Bytes that a solve by this method takes on cells of this many a side. */
static size_t solves(const char *what, uint32_t method, uint32_t dimensions, uint32_t precision, size_t side, size_t idle) {
    const size_t keyframe = 6, cells = side * side * (dimensions == 3 ? side : 1);
    Job job;
    memset(&job, 0, sizeof job);
    if (thurible_defaults(&job.config, sizeof job.config)) exit(99);
    for (int axis = 0; axis < 3; axis++) job.config.cells[axis] = side;
    job.config.precision = precision;
    job.config.dimensions = dimensions;
    job.config.method = method;
    job.config.steps = keyframe;
    job.config.keyframes = &keyframe;
    job.config.keyframe_count = 1;
    job.config.iterations = 2;
    job.config.lbfgs_nested = 1;
    if (thurible_plan(&job.config, &job.bytes, NULL, &job.saved_bytes)) exit(99);
    job.memory = aligned(job.bytes);
    job.saved = aligned(job.saved_bytes);
    fill(&job, precision, cells);
    return bytes_of(&job, what, idle);
}

int main(int count, char **arguments) {
    const char *methods[] = {"direct", "admm", "lbfgs", "pd", "simulate"};
    Job job;
    memset(&job, 0, sizeof job);
    job.idle = 1;
    const size_t idle = used(&job); /* what a thread itself takes */
    size_t most = 0;
    printf("stack in bytes, that of the thread itself (%zu) subtracted:\n", idle);
    const uint32_t columns[][3] = {{2, 4, 32}, {2, 8, 32}, {3, 4, 16}, {3, 8, 16}, {2, 4, 64}};
    printf("%-9s", "method");
    for (size_t column = 0; column < 5; column++) printf(" %uD f%u %4u", (unsigned)columns[column][0], (unsigned)columns[column][1] * 8, (unsigned)columns[column][2]);
    printf("\n");
    for (uint32_t method = 0; method < 5; method++) {
        printf("%-9s", methods[method]);
        for (size_t column = 0; column < 5; column++) {
            const size_t bytes = solves(methods[method], method, columns[column][0], columns[column][1], columns[column][2], idle);
            if (column < 4 && bytes > most) most = bytes;
            printf(" %11zu", bytes);
        }
        printf("\n");
    }
    printf("%-9s", "tracking");
    for (size_t column = 0; column < 5; column++) {
        const size_t bytes = tracking(columns[column][0], columns[column][1], columns[column][2], idle);
        if (bytes > most) most = bytes;
        printf(" %11zu", bytes);
    }
    printf("\n");
    const size_t ceiling = count > 1 ? strtoul(arguments[1], NULL, 10) : SIZE_MAX;
    printf("most but for the last column: %zu\n", most);
    if (most > ceiling) printf("that is more than %zu\n", ceiling);
    return most > ceiling;
}

/* The whole of thurible.h, as C11 and as C++17. Ends with 0 when every check holds; says which does not. */
#include "check.h"
#include <pthread.h>

/* A scene with its densities, in either precision. */
typedef struct {
    ThuribleConfig config;
    size_t keyframes[2];
    size_t cells, number, bytes, saved;
    void *source, *target;
} Scene;

/* The caller's config.keyframes must stay where it is, so scenes are filled in place. */
static void make_scene(Scene *scene, uint32_t precision, uint32_t dimensions, size_t side, size_t steps, uint32_t method) {
    memset(scene, 0, sizeof *scene);
    OK(thurible_defaults(&scene->config, sizeof scene->config));
    ThuribleConfig *config = &scene->config;
    scene->keyframes[0] = steps / 2;
    scene->keyframes[1] = steps;
    config->precision = precision;
    config->dimensions = dimensions;
    config->cells[0] = side + 2;
    config->cells[1] = config->cells[2] = side;
    config->boundary[1] = THURIBLE_BOUNDARY_PERIODIC;
    config->steps = steps;
    config->keyframes = scene->keyframes;
    config->keyframe_count = 2;
    config->force_weight = 10.0;
    config->viscosity = 1e-3;
    config->length = 2.0;
    config->dt = 0.5;
    config->method = method;
    config->iterations = 3;
    if (dimensions == 3) config->direct_history_precision = config->lbfgs_history_precision = THURIBLE_HISTORY_PRECISION_HALF;
    scene->number = precision;
    scene->cells = (side + 2) * side * (dimensions == 3 ? side : 1);
    scene->source = aligned(scene->cells * scene->number);
    scene->target = aligned(scene->cells * scene->number);
    for (size_t cell = 0; cell < scene->cells; cell++) {
        double x = (double)(cell % (side + 2)), y = (double)(cell / (side + 2) % side), r = 0.08 * (double)side;
        double z = dimensions == 3 ? (double)(cell / (side + 2) / side) - 0.5 * (double)side : 0.0;
        double a = x - 0.4 * (double)side, b = x - 0.6 * (double)side, c = y - 0.5 * (double)side;
        put(scene->source, scene->number, cell, exp(-(a * a + c * c + z * z) / (r * r + 2.0)));
        put(scene->target, scene->number, cell, exp(-(b * b + c * c + z * z) / (r * r + 2.0)));
    }
    size_t alignment = 0;
    OK(thurible_plan(config, &scene->bytes, &alignment, &scene->saved));
    CHECK(alignment == 64 && scene->bytes > 0 && scene->saved > 0);
}

static void drop_scene(Scene *scene) {
    free(scene->source);
    free(scene->target);
}

/* An instance without densities, and with them. */
static Thurible *empty(const Scene *scene) {
    Thurible *solver = NULL;
    OK(thurible_init(aligned(scene->bytes), scene->bytes, &scene->config, &solver));
    return solver;
}

static Thurible *full(const Scene *scene) {
    Thurible *solver = empty(scene);
    double factor = 0.0;
    OK(thurible_set_source(solver, scene->source, scene->cells * scene->number));
    OK(thurible_set_keyframe(solver, 0, scene->target, scene->cells * scene->number, NULL));
    OK(thurible_set_keyframe(solver, 1, scene->target, scene->cells * scene->number, &factor));
    CHECK(factor > 0.5 && factor < 2.0);
    return solver;
}

/* The handle is where the memory began. */
static void drop(Thurible *solver) {
    OK(thurible_close(solver));
    free((void *)solver);
}

/* All numbers of the result one after the other. */
static unsigned char *result(const Scene *scene, const Thurible *solver, size_t *bytes) {
    unsigned char *all = NULL;
    *bytes = 0;
    const uint32_t fields[] = {THURIBLE_FIELD_DENSITY, THURIBLE_FIELD_KEYFRAME, THURIBLE_FIELD_VELOCITY, THURIBLE_FIELD_FORCE};
    const size_t counts[] = {scene->config.steps + 1, scene->config.keyframe_count, scene->config.steps, scene->config.steps - 1};
    for (int f = 0; f < 4; f++)
        for (size_t step = 0; step < counts[f]; step++)
            for (size_t axis = 0; axis < (f < 2 ? 1 : scene->config.dimensions); axis++) {
                size_t more = 0;
                OK(thurible_copy_bytes(solver, fields[f], axis, &more));
                all = (unsigned char *)realloc(all, *bytes + more);
                if (!all) exit(99);
                void *field = aligned(more); /* aligned for its numbers */
                OK(thurible_copy(solver, fields[f], step, axis, field, more));
                memcpy(all + *bytes, field, more);
                free(field);
                *bytes += more;
            }
    return all;
}

static void same(const char *what, const unsigned char *left, size_t left_bytes, const unsigned char *right, size_t right_bytes) {
    if (left_bytes != right_bytes || memcmp(left, right, left_bytes) != 0) {
        failures++;
        fprintf(stderr, "%s: other bits\n", what);
    }
}

static void versions_and_texts(void) {
    CHECK(thurible_version() == THURIBLE_VERSION);
    for (uint32_t code = THURIBLE_RESULT_OK; code <= THURIBLE_RESULT_NO_EMISSION; code++) CHECK(strcmp(thurible_result_text(code), "no such code") != 0);
    CHECK(strcmp(thurible_result_text(THURIBLE_RESULT_NO_EMISSION + 1), "no such code") == 0);
    CHECK(strcmp(thurible_status_text(THURIBLE_STATUS_CONVERGED), "converged") == 0);
    CHECK(strcmp(thurible_status_text(99), "no such code") == 0);
}

/* Refused by both, with these words. */
static void refused(const ThuribleConfig *config, ThuribleResult result, const char *words) {
    char text[200];
    size_t bytes = 1, length = thurible_explain(config, text, sizeof text);
    check_result(__LINE__, words, thurible_plan(config, &bytes, NULL, NULL), result);
    CHECK(bytes == 1);
    if (!strstr(text, words) || length != strlen(text)) {
        failures++;
        fprintf(stderr, "\"%s\" does not say \"%s\"\n", text, words);
    }
}

static void configurations(void) {
    Scene scene;
    make_scene(&scene, THURIBLE_PRECISION_F32, 2, 8, 4, THURIBLE_METHOD_DIRECT);
    const ThuribleConfig good = scene.config;
    char text[16];
    CHECK(thurible_explain(&good, text, sizeof text) == 0 && text[0] == 0);
    IS(thurible_plan(NULL, NULL, NULL, NULL), NULL);
    OK(thurible_plan(&good, NULL, NULL, NULL));
    CHECK(good.direct_history == THURIBLE_AUTOMATIC && good.direct_nested == 1 && good.lbfgs_nested == 0);
    CHECK(good.admm_ao_iterations == 2 && good.nso_cycles == 30 && good.admm_penalty == 1e3 && good.pd_drive == 10.0);
    CHECK(good.nso_solver == THURIBLE_NSO_SOLVER_STFAS && good.nso_colours == THURIBLE_COLOURS_RED_BLACK);
    IS(thurible_defaults(NULL, sizeof good), NULL);
    ThuribleConfig config = good;
    IS(thurible_defaults(&config, sizeof config - 1), CONFIG_SIZE);
#define WRONG(change, words) config = good, config.change, refused(&config, THURIBLE_RESULT_CONFIG, words)
    WRONG(cells[1] = 3, "cells[1] is 3");
    WRONG(cells[0] = 5000, "cells[0] is 5000");
    WRONG(precision = 16, "precision is 16");
    WRONG(dimensions = 4, "dimensions is 4");
    WRONG(boundary[0] = 5, "boundary is 5");
    WRONG(method = 7, "method is 7");
    WRONG(length = -1.0, "length is -1");
    WRONG(dt = 0.0, "dt is 0");
    WRONG(steps = 1, "steps is 1");
    WRONG(keyframe_count = 0, "no keyframe");
    WRONG(keyframe_count = 200000, "keyframe_count is 200000");
    WRONG(keyframes = NULL, "keyframes is null");
    WRONG(keyframes = (const size_t *)((const char *)scene.keyframes + 1), "misaligned");
    WRONG(steps = 3, "keyframe is at step 4");
    WRONG(force_weight = (double)NAN, "force_weight is NaN");
    WRONG(viscosity = -1.0, "viscosity is -1");
    config = good, config.viscosity = 0.0, config.no_slip = 1;
    refused(&config, THURIBLE_RESULT_CONFIG, "by its viscosity, and that is 0");
    config.viscosity = 1e-3;
    OK(thurible_plan(&config, NULL, NULL, NULL));
    WRONG(smoothness = -2.0, "smoothness is -2; it must be from 0 to 64");
    WRONG(smoothness = 65.0, "smoothness is 65");
    WRONG(smoothness = (double)NAN, "smoothness is NaN");
    CHECK(good.scheme == THURIBLE_SCHEME_LIMITED && good.smoothness == -1.0);
    WRONG(filters = 13, "filters is 13");
    WRONG(match_mass = 2, "match_mass is 2");
    WRONG(scheme = 4, "scheme is 4");
    WRONG(advection_tolerance = 0.0, "advection.tolerance");
    WRONG(projection_tolerance = (double)INFINITY, "projection.tolerance");
    WRONG(iterations = 0, "iterations is 0");
    WRONG(threads = 1025, "threads is 1025");
    WRONG(direct_history = 9, "direct.history is 9");
    WRONG(direct_nested = 7, "direct_nested is 7");
    WRONG(direct_tolerance = 0.0, "direct.tolerance is 0");
    WRONG(direct_coarse_force_weight = 100.0, "direct.coarse_force_weight is 100");
    WRONG(admm_penalty = 0.0, "admm.penalty is 0");
    WRONG(admm_relaxation = -1.0, "admm.relaxation is -1");
    WRONG(admm_density_tolerance = 0.0, "admm.density_tolerance is 0");
    WRONG(admm_ao_iterations = 0, "admm.ao_iterations is 0; it must be from 1 to 1000");
    WRONG(admm_nested = 2, "admm_nested is 2");
    WRONG(admm_ao_momentum = 1.0, "ao_momentum is 1");
    WRONG(nso_solver = 2, "nso_solver is 2");
    WRONG(nso_colours = 2, "nso_colours is 2");
    WRONG(nso_norm = 2, "nso_norm is 2");
    WRONG(nso_cycles = 64, "nso_cycles is 64");
    WRONG(nso_tolerance = 0.0, "admm.nso_tolerance is 0");
    WRONG(lbfgs_history = 0, "lbfgs.history is 0");
    WRONG(lbfgs_tolerance = (double)NAN, "lbfgs.tolerance is NaN");
    WRONG(lbfgs_nested = 2, "lbfgs_nested is 2");
    WRONG(pd_drive = -1.0, "pd.drive is -1");
    WRONG(pd_attenuation = -1.0, "pd.attenuation is -1");
    WRONG(pd_gathering = -1.0, "pd.gathering is -1");
    WRONG(simulation_tolerance = 0.0, "simulation.tolerance is 0");
    WRONG(buoyancy[1] = (double)NAN, "buoyancy is NaN");
    WRONG(keyframe_regions = 2, "keyframe_regions is 2");
    WRONG(solids = 2, "solids is 2");
    WRONG(mask = 2, "mask is 2");
    config = good;
    config.solids = 1;
    OK(thurible_plan(&config, NULL, NULL, NULL));
    config.scheme = THURIBLE_SCHEME_QUICK;
    refused(&config, THURIBLE_RESULT_CONFIG, "only limited transport");
    WRONG(release = 4, "release is 4; it must be from 2");
    WRONG(release = 3, "a keyframe is at step 4, after the release at step 3");
    double weights[2] = {2.0, 0.0};
    ThuribleEmitter emitter = {1, 3, 0.5, 0.0, {0.0, 0.0, 0.0}, 0, 0};
    ThuribleFactor factors[2] = {{1, 1.0}, {3, 0.5}};
    WRONG(keyframe_weights = weights, "keyframe.weight is 0");
    WRONG(keyframe_weights = (const double *)((const char *)weights + 1), "keyframe_weights is null or misaligned");
    ThuribleConfig effects = good;
    weights[1] = 0.5;
    effects.keyframe_weights = weights;
    effects.keyframe_regions = 1;
    effects.emitters = &emitter;
    effects.schedule = factors;
    effects.emitter_count = 1;
    effects.schedule_count = 2;
    effects.buoyancy[1] = -0.1;
    effects.buoyancy[2] = (double)NAN; /* nobody looks there in 2D */
    OK(thurible_plan(&effects, NULL, NULL, NULL));
#define ODD(change, words) config = effects, config.change, refused(&config, THURIBLE_RESULT_CONFIG, words)
    ODD(emitters = NULL, "emitters is null or misaligned, but emitter_count is not 0");
    ODD(emitters = (const ThuribleEmitter *)((const char *)&emitter + 1), "emitters is null or misaligned");
    ODD(emitter_count = THURIBLE_MOST_EMITTERS + 1, "emitter_count is 33; it must be at most 32");
    ODD(schedule = NULL, "schedule is null or misaligned, but schedule_count is not 0");
    ODD(schedule_count = THURIBLE_MOST_FACTORS + 1, "schedule_count is 65; it must be at most 64");
    ODD(method = THURIBLE_METHOD_ADMM, "the method admm knows no schedule");
#define EMITS(change, words) emitter.change, refused(&effects, THURIBLE_RESULT_CONFIG, words), emitter = good_emitter
    const ThuribleEmitter good_emitter = emitter;
    EMITS(to = 1, "emitter 0 must emit from a step to a later one");
    EMITS(to = 5, "at most steps = 4");
    EMITS(rate = 0.0, "emitters[0] must have either a rate or a target above 0, and the other 0");
    EMITS(target = 1.0, "emitters[0] must have either a rate or a target");
    EMITS(rate = -1.0, "emitter.rate is -1");
    EMITS(rate = (double)NAN, "emitter.rate is NaN");
    EMITS(pushes = 2, "emitter.pushes is 2");
    EMITS(reserved = 1, "emitter.reserved is 1");
    emitter.pushes = 1;
    OK(thurible_plan(&effects, NULL, NULL, NULL));
    EMITS(velocity[1] = (double)NAN, "emitter.velocity is NaN");
    emitter.target = 1.0;
    EMITS(rate = 0.0, "so the mass of the smoke is not known before");
    ThuribleTemplate fan = {THURIBLE_TEMPLATE_KIND_VORTEX, 1, 0, 4, 0, {0.5, 0.5, 9.0}, 0.2, {0.0, 0.0, 0.0}, 0.0, 0, 0};
    const ThuribleTemplate good_template = fan;
    effects.templates = &fan;
    effects.template_count = 1;
    refused(&effects, THURIBLE_RESULT_CONFIG, "the method direct knows no templates");
    effects.method = THURIBLE_METHOD_TEMPLATES;
    OK(thurible_plan(&effects, NULL, NULL, NULL));
#define FORM(change, words) fan.change, refused(&effects, THURIBLE_RESULT_CONFIG, words), fan = good_template
    FORM(kind = 9, "template.kind is 9, which stands for nothing");
    FORM(moves = 2, "template.moves is 2");
    FORM(reserved = 1, "template.reserved is 1");
    FORM(to = 5, "template 0 must act from a force to a later one; there are 3 of them");
    FORM(from = 3, "template 0 must act from a force to a later one");
    FORM(radius = 0.0, "template.radius is 0");
    FORM(size = -1.0, "template.size is -1");
    FORM(amplitude[0] = (double)NAN, "template.amplitude is NaN");
    FORM(center[1] = 9.0, "template 0 has its middle at 9 along axis 1, which is outside the box");
    ODD(templates = NULL, "templates is null or misaligned, but template_count is not 0");
    ODD(template_count = THURIBLE_MOST_TEMPLATES + 1, "template_count is 17; it must be at most 16");
    ODD(template_count = 0, "there is no template");
    ODD(templates_history = 9, "templates.history is 9");
    ODD(direct_coarse_iterations = 100001, "direct.coarse_iterations is 100001");
    ODD(direct_history_precision = 2, "direct_history_precision is 2");
    ODD(lbfgs_history_precision = 2, "lbfgs_history_precision is 2");
    ODD(guide_radius = 0.0, "guide.radius is 0");
    ODD(guide_solver = 3, "guide_solver is 3");
    ODD(guide_noise_sigma = 0.0, "guide.noise_sigma is 0");
    ODD(no_slip = 2, "no_slip is 2");
    effects.template_count = 0;
    effects.method = THURIBLE_METHOD_DIRECT;
    factors[1].step = 1;
    refused(&effects, THURIBLE_RESULT_CONFIG, "the schedule's step 1 is not after the one before it");
    factors[0].factor = 0.0;
    refused(&effects, THURIBLE_RESULT_CONFIG, "schedule is 0");
    config = good;
    config.size -= 1;
    refused(&config, THURIBLE_RESULT_CONFIG_SIZE, "no known version");
    refused(NULL, THURIBLE_RESULT_NULL, "null");
    CHECK(thurible_explain(&config, text, sizeof text) > sizeof text && strlen(text) == sizeof text - 1);
    CHECK(thurible_explain(&config, NULL, 0) > 0);
    /* A program of a later version: what it added is accepted as long as it is nothing. */
    struct {
        ThuribleConfig config;
        double added;
    } later;
    OK(thurible_defaults(&later.config, sizeof later));
    CHECK(later.config.size == sizeof later && later.added == 0.0);
    later.config = good;
    later.config.size = sizeof later;
    OK(thurible_plan(&later.config, NULL, NULL, NULL));
    later.added = 1.0;
    refused(&later.config, THURIBLE_RESULT_CONFIG_SIZE, "no known version");
    drop_scene(&scene);
}

static void handles(void) {
    Scene scene;
    make_scene(&scene, THURIBLE_PRECISION_F32, 2, 8, 4, THURIBLE_METHOD_DIRECT);
    unsigned char *memory = (unsigned char *)aligned(scene.bytes + 64);
    Thurible *solver = (Thurible *)memory;
    IS(thurible_init(memory, scene.bytes, &scene.config, NULL), NULL);
    IS(thurible_init(NULL, scene.bytes, &scene.config, &solver), NULL);
    CHECK(solver == NULL);
    IS(thurible_init(memory + 8, scene.bytes, &scene.config, &solver), MISALIGNED);
    IS(thurible_init(memory, scene.bytes - 1, &scene.config, &solver), TOO_SMALL);
    IS(thurible_init(memory, 0, &scene.config, &solver), TOO_SMALL);
    IS(thurible_init(memory, scene.bytes, NULL, &solver), NULL);
    ThuribleProgress progress;
    IS(thurible_progress((Thurible *)memory, &progress), NO_INSTANCE);
    OK(thurible_init(memory, scene.bytes, &scene.config, &solver));
    CHECK((void *)solver == (void *)memory);
    OK(thurible_progress(solver, &progress));
    CHECK(progress.status == THURIBLE_STATUS_GOES && progress.iteration == 0);
    IS(thurible_progress(NULL, &progress), NULL);
    IS(thurible_progress((Thurible *)(memory + 8), &progress), MISALIGNED);
    unsigned char *copy = (unsigned char *)aligned(scene.bytes);
    memcpy(copy, memory, scene.bytes);
    IS(thurible_progress((Thurible *)copy, &progress), NO_INSTANCE);
    OK(thurible_close(solver));
    IS(thurible_close(solver), NO_INSTANCE);
    IS(thurible_step(solver, NULL, NULL, NULL), NO_INSTANCE);
    /* The same memory again. */
    OK(thurible_init(memory, scene.bytes + 64, &scene.config, &solver));
    OK(thurible_close(solver));
    free(copy);
    free(memory);
    drop_scene(&scene);
}

static void inputs(void) {
    Scene scene;
    make_scene(&scene, THURIBLE_PRECISION_F64, 2, 8, 4, THURIBLE_METHOD_DIRECT);
    Thurible *solver = empty(&scene);
    double *field = (double *)aligned(scene.cells * 8);
    memcpy(field, scene.source, scene.cells * 8);
    size_t bytes = scene.cells * 8;
    IS(thurible_step(solver, NULL, NULL, NULL), NO_SOURCE);
    SAYS(thurible_message, solver, "there is no smoke yet");
    IS(thurible_set_keyframe(solver, 0, field, bytes, NULL), NO_SOURCE);
    IS(thurible_set_source(solver, NULL, bytes), NULL);
    IS(thurible_set_source(solver, (char *)field + 4, bytes), MISALIGNED);
    IS(thurible_set_source(solver, field, bytes - 1), LENGTH);
    IS(thurible_set_source(solver, field, bytes / 2), LENGTH); /* as floats */
    SAYS(thurible_message, solver, "40 values where 80 are needed");
    IS(thurible_set_source(solver, field, SIZE_MAX), LENGTH);
    field[3] = -1.0;
    IS(thurible_set_source(solver, field, bytes), NEGATIVE);
    SAYS(thurible_message, solver, "value 3 is negative");
    field[3] = (double)NAN;
    IS(thurible_set_source(solver, field, bytes), NOT_FINITE);
    memset(field, 0, bytes);
    IS(thurible_set_source(solver, field, bytes), EMPTY);
    OK(thurible_set_source(solver, scene.source, bytes));
    SAYS(thurible_message, solver, "");
    OK(thurible_set_keyframe(solver, 1, scene.target, bytes, NULL));
    IS(thurible_set_keyframe(solver, 2, scene.target, bytes, NULL), INDEX);
    IS(thurible_solve(solver, NULL, NULL, NULL), NO_KEYFRAME);
    SAYS(thurible_message, solver, "keyframe 0 was not set");
    IS(thurible_finish(solver, NULL, NULL), NO_KEYFRAME);
    IS(thurible_set_initial_velocity(solver, 2, field, bytes), INDEX);
    IS(thurible_set_initial_velocity(solver, 0, field, bytes), LENGTH);
    size_t faces = 0;
    OK(thurible_copy_bytes(solver, THURIBLE_FIELD_VELOCITY, 0, &faces));
    CHECK(faces == 11 * 8 * 8);
    OK(thurible_copy_bytes(solver, THURIBLE_FIELD_FORCE, 1, &faces));
    CHECK(faces == 10 * 8 * 8);
    IS(thurible_copy_bytes(solver, THURIBLE_FIELD_DENSITY, 1, &faces), INDEX);
    IS(thurible_copy_bytes(solver, 6, 0, &faces), INDEX);
    IS(thurible_copy_bytes(solver, THURIBLE_FIELD_REGION, 0, &faces), INDEX);
    IS(thurible_copy_bytes(solver, THURIBLE_FIELD_EMISSION, 0, &faces), INDEX);
    IS(thurible_set_emitter(solver, 0, scene.source, bytes), INDEX);
    IS(thurible_set_region(solver, 0, scene.source, bytes), INDEX);
    IS(thurible_set_solids(solver, (const uint8_t *)field, scene.cells), INDEX);
    IS(thurible_copy_bytes(solver, 0, 0, NULL), NULL);
    for (size_t face = 0; face < 80; face++) field[face] = 0.25;
    OK(thurible_set_initial_velocity(solver, 1, field, bytes)); /* a uniform wind along the periodic axis */
    ThuribleView view;
    OK(thurible_view(solver, THURIBLE_FIELD_VELOCITY, 0, 1, &view));
    CHECK(fabs(((const double *)view.data)[0] * view.unit - 0.25) < 1e-15 && view.bytes_per_number == 8);
    IS(thurible_view(solver, THURIBLE_FIELD_VELOCITY, 1, 1, &view), NO_RESULT);
    IS(thurible_view(solver, THURIBLE_FIELD_FORCE, 0, 0, &view), NO_RESULT);
    IS(thurible_copy(solver, THURIBLE_FIELD_DENSITY, 1, 0, field, bytes), NO_RESULT);
    OK(thurible_copy(solver, THURIBLE_FIELD_DENSITY, 0, 0, field, bytes));
    CHECK(memcmp(field, scene.source, bytes) == 0);
    IS(thurible_view(solver, THURIBLE_FIELD_VELOCITY, 0, 1, NULL), NULL);
    IS(thurible_copy(solver, THURIBLE_FIELD_DENSITY, 0, 0, NULL, bytes), NULL);
    IS(thurible_copy(solver, THURIBLE_FIELD_DENSITY, 0, 0, (char *)field + 1, bytes), MISALIGNED);
    IS(thurible_copy(solver, THURIBLE_FIELD_DENSITY, 0, 0, field, bytes - 8), LENGTH);
    IS(thurible_copy(solver, THURIBLE_FIELD_DENSITY, 5, 0, field, bytes), INDEX);
    IS(thurible_copy(solver, THURIBLE_FIELD_VELOCITY, 4, 0, field, bytes), INDEX);
    IS(thurible_copy(solver, THURIBLE_FIELD_FORCE, 3, 0, field, bytes), INDEX);
    IS(thurible_copy(solver, THURIBLE_FIELD_KEYFRAME, 2, 0, field, bytes), INDEX);
    IS(thurible_copy(solver, THURIBLE_FIELD_VELOCITY, 0, 2, field, bytes), INDEX);
    IS(thurible_copy(solver, 9, 0, 0, field, bytes), INDEX);
    IS(thurible_save(solver, NULL, scene.saved), NULL);
    IS(thurible_save(solver, field, 8), LENGTH);
    IS(thurible_restore(solver, NULL, 8), NULL);
    IS(thurible_restore(solver, field, 8), LENGTH);
    /* A place that cannot be written is refused before anything is done. */
    OK(thurible_set_keyframe(solver, 0, scene.target, bytes, NULL));
    ThuribleProgress places[2], before, after;
    OK(thurible_step(solver, NULL, NULL, &before));
    IS(thurible_step(solver, NULL, NULL, (ThuribleProgress *)((char *)places + 1)), MISALIGNED);
    IS(thurible_set_keyframe(solver, 0, scene.source, bytes, (double *)((char *)places + 1)), MISALIGNED);
    IS(thurible_plan(&scene.config, (size_t *)((char *)places + 1), NULL, NULL), MISALIGNED);
    OK(thurible_progress(solver, &after));
    CHECK(after.iteration == before.iteration);
    OK(thurible_copy(solver, THURIBLE_FIELD_KEYFRAME, 0, 0, field, bytes));
    CHECK(fabs(field[10] / ((double *)scene.target)[10] - field[50] / ((double *)scene.target)[50]) < 1e-12);
    drop(solver);
    free(field);
    drop_scene(&scene);
}

/* Solves to the end step by step, saving after each, and goes on from each of them elsewhere. */
static void saves_and_goes_on(uint32_t precision, uint32_t dimensions, size_t side, uint32_t method) {
    Scene scene;
    make_scene(&scene, precision, dimensions, side, 6, method);
    Thurible *solver = full(&scene);
    unsigned char *saved[16];
    size_t count = 0, bytes = 0;
    ThuribleProgress progress;
    progress.status = THURIBLE_STATUS_GOES;
    while (progress.status == THURIBLE_STATUS_GOES && count < 16) {
        saved[count] = (unsigned char *)aligned(scene.saved);
        OK(thurible_save(solver, saved[count++], scene.saved));
        OK(thurible_step(solver, NULL, NULL, &progress));
    }
    CHECK(progress.status != THURIBLE_STATUS_GOES && progress.status != THURIBLE_STATUS_NOT_FINITE);
    OK(thurible_finish(solver, NULL, &progress));
    unsigned char *whole = result(&scene, solver, &bytes);
    for (size_t step = 0; step < count; step++) {
        Thurible *other = empty(&scene);
        OK(thurible_restore(other, saved[step], scene.saved));
        ThuribleProgress end;
        OK(thurible_solve(other, NULL, NULL, &end));
        CHECK(end.status == progress.status && end.data == progress.data && end.force == progress.force && end.iteration == progress.iteration);
        size_t other_bytes = 0;
        unsigned char *again = result(&scene, other, &other_bytes);
        same("restored", whole, bytes, again, other_bytes);
        free(again);
        drop(other);
    }
    Thurible *other = empty(&scene);
    for (size_t place = 0; place < scene.saved; place += 1 + place / 8) {
        saved[0][place] ^= 0x10;
        ThuribleResult found = thurible_restore(other, saved[0], scene.saved);
        CHECK(found == THURIBLE_RESULT_SAVED_DAMAGED || found == THURIBLE_RESULT_SAVED_OTHER || found == THURIBLE_RESULT_SAVED_FORMAT ||
              found == THURIBLE_RESULT_NOT_SAVED || found == THURIBLE_RESULT_LENGTH);
        saved[0][place] ^= 0x10;
    }
    IS(thurible_restore(other, saved[0], scene.saved - 1), LENGTH);
    IS(thurible_step(other, NULL, NULL, NULL), NO_SOURCE);
    drop(other);
    scene.config.force_weight = 11.0;
    other = empty(&scene);
    IS(thurible_restore(other, saved[0], scene.saved), SAVED_OTHER);
    SAYS(thurible_message, other, "another problem");
    drop(other);
    while (count > 0) free(saved[--count]);
    free(whole);
    drop(solver);
    drop_scene(&scene);
}

/* Two instances of different kinds, step by step in turn, find what they find alone. */
static void side_by_side(void) {
    Scene scenes[2];
    make_scene(&scenes[0], THURIBLE_PRECISION_F32, 2, 16, 6, THURIBLE_METHOD_DIRECT);
    make_scene(&scenes[1], THURIBLE_PRECISION_F64, 3, 6, 4, THURIBLE_METHOD_ADMM);
    unsigned char *alone[2];
    size_t bytes[2];
    for (int i = 0; i < 2; i++) {
        Thurible *solver = full(&scenes[i]);
        OK(thurible_solve(solver, NULL, NULL, NULL));
        alone[i] = result(&scenes[i], solver, &bytes[i]);
        drop(solver);
    }
    Thurible *both[2] = {full(&scenes[0]), full(&scenes[1])};
    ThuribleProgress progress[2];
    progress[0].status = progress[1].status = THURIBLE_STATUS_GOES;
    while (progress[0].status == THURIBLE_STATUS_GOES || progress[1].status == THURIBLE_STATUS_GOES)
        for (int i = 0; i < 2; i++)
            if (progress[i].status == THURIBLE_STATUS_GOES) OK(thurible_step(both[i], NULL, NULL, &progress[i]));
    for (int i = 0; i < 2; i++) {
        OK(thurible_finish(both[i], NULL, NULL));
        size_t found_bytes = 0;
        unsigned char *found = result(&scenes[i], both[i], &found_bytes);
        same("side by side", alone[i], bytes[i], found, found_bytes);
        free(found);
        free(alone[i]);
        drop(both[i]);
        drop_scene(&scenes[i]);
    }
}

/* Views show what copies hold. */
static void views(void) {
    Scene scene;
    make_scene(&scene, THURIBLE_PRECISION_F32, 3, 6, 4, THURIBLE_METHOD_DIRECT);
    Thurible *solver = full(&scene);
    OK(thurible_solve(solver, NULL, NULL, NULL));
    const uint32_t fields[] = {THURIBLE_FIELD_DENSITY, THURIBLE_FIELD_KEYFRAME, THURIBLE_FIELD_VELOCITY, THURIBLE_FIELD_FORCE};
    const size_t counts[] = {5, 2, 4, 3};
    double largest[4] = {0};
    for (int f = 0; f < 4; f++)
        for (size_t step = 0; step < counts[f]; step++)
            for (size_t axis = 0; axis < (f < 2 ? 1u : 3u); axis++) {
                ThuribleView view;
                size_t bytes = 0;
                OK(thurible_view(solver, fields[f], step, axis, &view));
                OK(thurible_copy_bytes(solver, fields[f], axis, &bytes));
                float *copy = (float *)aligned(bytes);
                OK(thurible_copy(solver, fields[f], step, axis, copy, bytes));
                CHECK(view.extent[0] == 8 && view.extent[1] == 6 && view.extent[2] == 6 && view.bytes_per_number == 4);
                /* Files have one more along x and z, whose axes end in walls. */
                size_t nx = 8 + (f >= 2 && axis == 0), ny = 6;
                for (size_t z = 0; z < 6; z++)
                    for (size_t y = 0; y < 6; y++)
                        for (size_t x = 0; x < 8; x++) {
                            float seen = ((const float *)view.data)[x * view.strides[0] + y * view.strides[1] + z * view.strides[2]];
                            float held = copy[(z * ny + y) * nx + x];
                            CHECK(seen * (float)view.unit == held);
                            if (fabs(held) > largest[f]) largest[f] = fabs(held);
                        }
                free(copy);
            }
    for (int f = 0; f < 4; f++) CHECK(largest[f] > 0.0);
    OK(thurible_step(solver, NULL, NULL, NULL));
    ThuribleView view;
    IS(thurible_view(solver, THURIBLE_FIELD_DENSITY, 1, 0, &view), NO_RESULT);
    drop(solver);
    drop_scene(&scene);
}

/* What the method gives, one output after the other, is what the codes of fields stand for. */
static void outputs(uint32_t precision, uint32_t dimensions, uint32_t method) {
    Scene scene;
    make_scene(&scene, precision, dimensions, 8, 4, method);
    Thurible *solver = full(&scene);
    const char *names[] = {"density", "velocity", "force"};
    const uint32_t fields[] = {THURIBLE_FIELD_DENSITY, THURIBLE_FIELD_VELOCITY, THURIBLE_FIELD_FORCE};
    size_t count = 0;
    IS(thurible_output_count(solver, NULL), NULL);
    IS(thurible_output_count(NULL, &count), NULL);
    OK(thurible_output_count(solver, &count));
    CHECK(count == 3);
    ThuribleOutput output;
    IS(thurible_output(solver, count, &output), INDEX);
    IS(thurible_output(solver, 0, NULL), NULL);
    ThuribleView seen, view;
    IS(thurible_view_output(solver, 0, 1, 0, &view), NO_RESULT);
    OK(thurible_view_output(solver, 0, 0, 0, &view)); /* what was given */
    OK(thurible_solve(solver, NULL, NULL, NULL));
    for (size_t i = 0; i < count && i < 3; i++) {
        OK(thurible_output(solver, i, &output));
        CHECK(strcmp(output.name, names[i]) == 0 && output.words[0] != 0 && output.unit == (ThuribleUnit)i);
        CHECK(output.place == (i == 0 ? THURIBLE_PLACE_CELLS : THURIBLE_PLACE_FACES));
        CHECK(output.steps == scene.config.steps + 1 - i && output.given == (i < 2 ? 1u : 0u));
        CHECK(output.components == (i == 0 ? 1 : dimensions));
        for (size_t axis = 0; axis < 3; axis++) {
            size_t bytes = 0;
            if (axis >= output.components) {
                CHECK(output.bytes[axis] == 0);
                IS(thurible_view_output(solver, i, 0, axis, &view), INDEX);
                continue;
            }
            OK(thurible_copy_bytes(solver, fields[i], axis, &bytes));
            CHECK(output.bytes[axis] == bytes);
            void *by_number = aligned(bytes), *by_code = aligned(bytes);
            for (size_t step = 0; step < output.steps; step++) {
                OK(thurible_read_output(solver, i, step, axis, by_number, bytes));
                OK(thurible_copy(solver, fields[i], step, axis, by_code, bytes));
                CHECK(memcmp(by_number, by_code, bytes) == 0);
                OK(thurible_view_output(solver, i, step, axis, &seen));
                OK(thurible_view(solver, fields[i], step, axis, &view));
                CHECK(seen.data == view.data && seen.strides[1] == view.strides[1] && seen.unit == view.unit);
            }
            IS(thurible_read_output(solver, i, output.steps, axis, by_number, bytes), INDEX);
            IS(thurible_read_output(solver, i, 0, axis, by_number, bytes - 1), LENGTH);
            IS(thurible_read_output(solver, i, 0, axis, (char *)by_number + 1, bytes), MISALIGNED);
            IS(thurible_read_output(solver, i, 0, axis, NULL, bytes), NULL);
            free(by_number);
            free(by_code);
        }
    }
    drop(solver);
    drop_scene(&scene);
}

/* The one value of the fact `name` of the last iteration; NaN where it was not told. */
static double fact_of(const Thurible *solver, const char *name) {
    size_t count = 0;
    double found = (double)NAN;
    OK(thurible_fact_count(solver, &count));
    for (size_t i = 0; i < count; i++) {
        ThuribleFact fact;
        OK(thurible_fact(solver, i, &fact));
        if (strcmp(fact.name, name) == 0 && fact.values == 1) OK(thurible_fact_values(solver, i, &found, sizeof found));
    }
    return found;
}

/* What the method reports, one fact after the other, is what the progress has fields for, and more. */
static void facts(void) {
    Scene scene;
    make_scene(&scene, THURIBLE_PRECISION_F32, 2, 12, 4, THURIBLE_METHOD_ADMM);
    Thurible *solver = full(&scene);
    size_t count = 1, series = 0;
    ThuribleFact fact;
    OK(thurible_fact_count(solver, &count));
    CHECK(count == 0);
    IS(thurible_fact(solver, 0, &fact), INDEX);
    unsigned char *saved = (unsigned char *)aligned(scene.saved);
    OK(thurible_save(solver, saved, scene.saved));
    ThuribleProgress progress;
    for (int step = 0; step < 2; step++) {
        OK(thurible_step(solver, NULL, NULL, &progress));
        CHECK(fact_of(solver, "density_change") == progress.density_change && fact_of(solver, "gap") == progress.gap);
        CHECK(fact_of(solver, "ao_step") == progress.step && isnan(fact_of(solver, "no such fact")));
    }
    OK(thurible_fact_count(solver, &count));
    for (size_t i = 0; i < count; i++) {
        OK(thurible_fact(solver, i, &fact));
        CHECK(fact.name[0] != 0 && fact.words[0] != 0 && (fact.values == 1 || fact.kind == THURIBLE_FACT_KIND_SERIES));
        double *values = (double *)aligned(fact.values * sizeof *values);
        OK(thurible_fact_values(solver, i, values, fact.values * sizeof *values));
        for (size_t value = 0; value < fact.values; value++) CHECK(isfinite(values[value]));
        IS(thurible_fact_values(solver, i, values, fact.values * sizeof *values + 1), LENGTH);
        IS(thurible_fact_values(solver, i, NULL, fact.values * sizeof *values), NULL);
        free(values);
        series += fact.kind == THURIBLE_FACT_KIND_SERIES && fact.values > 1;
    }
    CHECK(count > 3 && series > 0);
    IS(thurible_fact(solver, count, &fact), INDEX);
    IS(thurible_fact_values(solver, count, &progress.gap, sizeof progress.gap), INDEX);
    IS(thurible_fact(solver, 0, NULL), NULL);
    IS(thurible_fact_count(solver, NULL), NULL);
    OK(thurible_restore(solver, saved, scene.saved));
    OK(thurible_fact_count(solver, &count));
    CHECK(count == 0);
    free(saved);
    drop(solver);
    drop_scene(&scene);
}

/* Threads of the host. */
typedef struct {
    ThuribleTask task;
    void *argument;
    size_t index;
} Job;

static void *work(void *job_) {
    Job *job = (Job *)job_;
    job->task(job->argument, job->index);
    return NULL;
}

static size_t parallel = 0;

static void on_threads(void *context, size_t tasks, ThuribleTask task, void *argument) {
    pthread_t threads[8];
    Job jobs[8];
    CHECK(context == (void *)&parallel && tasks >= 2 && tasks <= 3);
    parallel++;
    for (size_t i = 1; i < tasks; i++) {
        jobs[i].task = task;
        jobs[i].argument = argument;
        jobs[i].index = i;
        if (pthread_create(&threads[i], NULL, work, &jobs[i]) != 0) exit(99);
    }
    task(argument, 0);
    for (size_t i = 1; i < tasks; i++) pthread_join(threads[i], NULL);
}

/* Hosts that do not keep to the contract: nothing, everything twice and more than there is. */
static void lazy(void *context, size_t tasks, ThuribleTask task, void *argument) {
    (void)context, (void)tasks, (void)task, (void)argument;
}

static void eager(void *context, size_t tasks, ThuribleTask task, void *argument) {
    (void)context;
    for (size_t i = tasks + 2; i-- > 0;) task(argument, i);
    for (size_t i = 0; i < tasks; i++) task(argument, i);
    task(argument, SIZE_MAX);
}

static void executors(void) {
    Scene scene;
    make_scene(&scene, THURIBLE_PRECISION_F32, 2, 72, 24, THURIBLE_METHOD_DIRECT);
    scene.config.iterations = 2;
    scene.config.threads = 3;
    OK(thurible_plan(&scene.config, &scene.bytes, NULL, &scene.saved));
    Thurible *solver = full(&scene);
    size_t bytes = 0;
    OK(thurible_solve(solver, NULL, NULL, NULL));
    unsigned char *alone = result(&scene, solver, &bytes);
    drop(solver);
    const ThuribleRun runs[] = {on_threads, lazy, eager};
    for (int i = 0; i < 3; i++) {
        ThuribleExecutor executor = {3, runs[i], &parallel};
        solver = full(&scene);
        OK(thurible_solve(solver, &executor, NULL, NULL));
        size_t found_bytes = 0;
        unsigned char *found = result(&scene, solver, &found_bytes);
        same("threads", alone, bytes, found, found_bytes);
        free(found);
        executor.threads = 4;
        IS(thurible_step(solver, &executor, NULL, NULL), EXECUTOR);
        executor.threads = 0;
        IS(thurible_step(solver, &executor, NULL, NULL), EXECUTOR);
        executor.threads = 3;
        executor.run = NULL;
        IS(thurible_step(solver, &executor, NULL, NULL), EXECUTOR);
        drop(solver);
    }
    CHECK(parallel > 10);
    free(alone);
    drop_scene(&scene);
}

typedef struct {
    Thurible *solver;
    size_t events, iterations, stop_at;
    ThuribleResult inside;
} Watch;

static int32_t watch(void *context, const ThuribleEvent *event) {
    Watch *seen = (Watch *)context;
    seen->events++;
    if (event->kind == THURIBLE_EVENT_KIND_ITERATION) CHECK(event->iteration == ++seen->iterations);
    ThuribleProgress progress;
    seen->inside = thurible_progress(seen->solver, &progress);
    return seen->events >= seen->stop_at;
}

static void observers(void) {
    Scene scene;
    make_scene(&scene, THURIBLE_PRECISION_F64, 2, 12, 4, THURIBLE_METHOD_ADMM);
    Watch seen = {full(&scene), 0, 0, SIZE_MAX, THURIBLE_RESULT_OK};
    ThuribleObserver observer = {watch, &seen};
    ThuribleProgress progress;
    OK(thurible_solve(seen.solver, NULL, &observer, &progress));
    CHECK(seen.iterations == progress.iteration && seen.events > 20 && seen.inside == THURIBLE_RESULT_BUSY);
    CHECK(progress.status == THURIBLE_STATUS_MAX_ITERATIONS && progress.gap > 0.0 && progress.step > 0.0);
    drop(seen.solver);
    seen.solver = full(&scene);
    seen.stop_at = seen.events / 2;
    seen.events = seen.iterations = 0;
    OK(thurible_solve(seen.solver, NULL, &observer, &progress));
    CHECK(progress.status == THURIBLE_STATUS_CANCELLED && seen.events >= seen.stop_at && seen.events <= seen.stop_at + 1);
    ThuribleView view;
    OK(thurible_view(seen.solver, THURIBLE_FIELD_FORCE, 0, 0, &view)); /* finished all the same */
    observer.on = NULL;
    OK(thurible_step(seen.solver, NULL, &observer, &progress));
    CHECK(progress.status != THURIBLE_STATUS_CANCELLED);
    drop(seen.solver);
    drop_scene(&scene);
}

/* No keyframes, smoke that rises. */
static void free_flow(void) {
    Scene scene;
    make_scene(&scene, THURIBLE_PRECISION_F64, 2, 12, 6, THURIBLE_METHOD_SIMULATE);
    scene.config.keyframe_count = 0;
    scene.config.keyframes = NULL;
    scene.config.buoyancy[1] = 0.2;
    OK(thurible_plan(&scene.config, &scene.bytes, NULL, NULL));
    Thurible *solver = empty(&scene);
    OK(thurible_set_source(solver, scene.source, scene.cells * 8));
    ThuribleProgress progress;
    OK(thurible_solve(solver, NULL, NULL, &progress));
    CHECK(progress.status == THURIBLE_STATUS_CONVERGED);
    ThuribleView view;
    OK(thurible_view(solver, THURIBLE_FIELD_VELOCITY, 5, 1, &view));
    double fastest = 0.0;
    for (size_t y = 0; y < view.extent[1]; y++)
        for (size_t x = 0; x < view.extent[0]; x++) fastest = fmax(fastest, get(view.data, 8, x * view.strides[0] + y * view.strides[1]) * view.unit);
    CHECK(fastest > 0.01);
    drop(solver);
    drop_scene(&scene);
}

/* All that a field holds of a cell, added up. */
static double mass_of(const Scene *scene, const void *field) {
    double mass = 0.0;
    for (size_t cell = 0; cell < scene->cells; cell++) mass += get(field, scene->number, cell);
    return mass;
}

static double mass_at(const Scene *scene, const Thurible *solver, uint32_t field, size_t step) {
    void *copy = aligned(scene->cells * scene->number);
    OK(thurible_copy(solver, field, step, 0, copy, scene->cells * scene->number));
    double mass = mass_of(scene, copy);
    free(copy);
    return mass;
}

/* A scene of eight steps with everything: an emitter by a rate and one that fills up, a keyframe at step 4 with weight and region, a schedule,
 * buoyancy, walls to which the flow sticks, and a release at step 6. What it points to is the caller's. */
static void add_effects(Scene *scene, uint32_t method, ThuribleEmitter emitters[2], const double *weight, const ThuribleFactor *factors) {
    ThuribleConfig *config = &scene->config;
    memset(emitters, 0, 2 * sizeof emitters[0]);
    emitters[0].velocity[1] = 0.05;
    emitters[0].pushes = method != THURIBLE_METHOD_ADMM;
    emitters[0].from = 1;
    emitters[0].to = 5;
    emitters[0].rate = 0.25;
    emitters[0].target = 0.0;
    emitters[1].from = 3;
    emitters[1].to = 7;
    emitters[1].rate = 0.0;
    emitters[1].target = 1.5;
    config->emitters = emitters;
    config->emitter_count = 2;
    config->keyframe_count = 1;
    config->keyframe_weights = weight;
    config->keyframe_regions = 1;
    config->match_mass = 0;
    config->release = 6;
    config->buoyancy[1] = 0.02;
    if (method != THURIBLE_METHOD_ADMM) {
        config->schedule = factors;
        config->schedule_count = 2;
        config->mask = 1;
        config->no_slip = 1;
    }
    OK(thurible_plan(config, &scene->bytes, NULL, &scene->saved));
}

/* One of it with its fields; the targets of both emitters are the scene's target. */
static Thurible *with_effects(const Scene *scene) {
    Thurible *solver = empty(scene);
    size_t bytes = scene->cells * scene->number;
    OK(thurible_set_source(solver, scene->source, bytes));
    IS(thurible_set_keyframe(solver, 0, scene->target, bytes, NULL), NO_EMITTER);
    OK(thurible_set_emitter(solver, 0, scene->target, bytes));
    IS(thurible_step(solver, NULL, NULL, NULL), NO_EMITTER);
    SAYS(thurible_message, solver, "the shape of emitter 1 must be set first");
    OK(thurible_set_emitter(solver, 1, scene->target, bytes));
    OK(thurible_set_keyframe(solver, 0, scene->target, bytes, NULL));
    OK(thurible_set_region(solver, 0, scene->target, bytes));
    if (scene->config.mask) OK(thurible_set_mask(solver, scene->target, bytes));
    else IS(thurible_set_mask(solver, scene->target, bytes), INDEX);
    return solver;
}

/* In a box that is open at the top of y no smoke is made, and the densities have the cells inside. */
static void leaves(uint32_t precision, uint32_t dimensions) {
    Scene scene;
    make_scene(&scene, precision, dimensions, 8, 8, THURIBLE_METHOD_DIRECT);
    scene.config.boundary[1] = THURIBLE_BOUNDARY_OPEN_HIGH;
    refused(&scene.config, THURIBLE_RESULT_CONFIG, "take match_mass = false");
    scene.config.match_mass = 0;
    OK(thurible_plan(&scene.config, &scene.bytes, NULL, &scene.saved));
    Thurible *solver = empty(&scene);
    size_t bytes = scene.cells * scene.number, faces = 0;
    OK(thurible_set_source(solver, scene.source, bytes));
    OK(thurible_set_keyframe(solver, 0, scene.target, bytes, NULL));
    OK(thurible_set_keyframe(solver, 1, scene.target, bytes, NULL));
    OK(thurible_step(solver, NULL, NULL, NULL));
    OK(thurible_finish(solver, NULL, NULL));
    double before = mass_of(&scene, scene.source);
    for (size_t step = 0; step < 8; step++) {
        double after = mass_at(&scene, solver, THURIBLE_FIELD_DENSITY, step + 1);
        CHECK(after < before * (1.0 + 1e-6));
        before = after;
    }
    ThuribleView view;
    OK(thurible_view(solver, THURIBLE_FIELD_VELOCITY, 1, 1, &view));
    CHECK(view.extent[1] == 9 && view.extent[0] == 10);
    OK(thurible_view(solver, THURIBLE_FIELD_DENSITY, 1, 0, &view));
    CHECK(view.extent[1] == 8);
    OK(thurible_copy_bytes(solver, THURIBLE_FIELD_VELOCITY, 1, &faces));
    CHECK(faces == scene.number * 10 * 9 * (dimensions == 3 ? 8 : 1));
    void *field = aligned(bytes);
    OK(thurible_copy(solver, THURIBLE_FIELD_KEYFRAME, 0, 0, field, bytes));
    CHECK(memcmp(field, scene.target, bytes) == 0);
    free(field);
    drop(solver);
    drop_scene(&scene);
}

/* The mass grows by what is emitted, no force acts after the release, and looking at what was emitted changes nothing. */
static void emits(uint32_t precision, uint32_t dimensions, uint32_t method) {
    Scene scene;
    ThuribleEmitter emitters[2];
    const double weight = 2.0;
    const ThuribleFactor factors[2] = {{0, 1.0}, {5, 0.25}};
    make_scene(&scene, precision, dimensions, 8, 8, method);
    add_effects(&scene, method, emitters, &weight, factors);
    Thurible *solver = with_effects(&scene), *other = with_effects(&scene);
    const double shape = mass_of(&scene, scene.target), exact = (precision == THURIBLE_PRECISION_F32 ? 1e-4 : 1e-9) * shape;
    size_t bytes = scene.cells * scene.number, whole_bytes = 0, again_bytes = 0;
    void *field = aligned(bytes);
    ThuribleView view;
    IS(thurible_copy(solver, THURIBLE_FIELD_EMISSION, 1, 0, field, bytes), NO_RESULT);
    OK(thurible_step(solver, NULL, NULL, NULL));
    OK(thurible_finish(solver, NULL, NULL));
    double before = mass_of(&scene, scene.source);
    for (size_t step = 0; step < 8; step++) {
        double emitted = mass_at(&scene, solver, THURIBLE_FIELD_EMISSION, step);
        double after = mass_at(&scene, solver, THURIBLE_FIELD_DENSITY, step + 1);
        CHECK(fabs(after - before - emitted) < exact);
        if (step == 0 || step == 7) CHECK(emitted == 0.0);
        if (step == 1 || step == 2) CHECK(fabs(emitted - 0.25 * shape) < exact);
        if (step == 3) CHECK(emitted > 0.26 * shape && emitted < 1.75 * shape);
        before = after;
        for (size_t axis = 0; axis < dimensions && step < 7; axis++) {
            size_t faces = 0;
            double largest = 0.0;
            OK(thurible_copy_bytes(solver, THURIBLE_FIELD_FORCE, axis, &faces));
            void *force = aligned(faces);
            OK(thurible_copy(solver, THURIBLE_FIELD_FORCE, step, axis, force, faces));
            for (size_t face = 0; face < faces / scene.number; face++) largest = fmax(largest, fabs(get(force, scene.number, face)));
            CHECK(step < 5 || largest == 0.0);
            free(force);
        }
    }
    /* Emitter 0 pushes from its first step on: there it adds something, and after its last nothing. */
    for (size_t step = 0; step < 7 && method != THURIBLE_METHOD_ADMM; step++) {
        double largest = 0.0;
        for (size_t axis = 0; axis < dimensions; axis++) {
            size_t faces = 0;
            OK(thurible_copy_bytes(solver, THURIBLE_FIELD_EMITTER_FORCE, axis, &faces));
            void *push = aligned(faces);
            OK(thurible_copy(solver, THURIBLE_FIELD_EMITTER_FORCE, step, axis, push, faces));
            for (size_t face = 0; face < faces / scene.number; face++) largest = fmax(largest, fabs(get(push, scene.number, face)));
            IS(thurible_copy(solver, THURIBLE_FIELD_EMITTER_FORCE, step, axis, push, faces - 1), LENGTH);
            free(push);
        }
        CHECK((largest > 0.0) == (step + 1 > emitters[0].from && step + 1 <= emitters[0].to));
    }
    if (method == THURIBLE_METHOD_ADMM) IS(thurible_copy(solver, THURIBLE_FIELD_EMITTER_FORCE, 0, 0, field, bytes), INDEX);
    else IS(thurible_copy(solver, THURIBLE_FIELD_EMITTER_FORCE, 7, 0, field, bytes), INDEX);
    IS(thurible_copy(solver, THURIBLE_FIELD_EMISSION, 8, 0, field, bytes), INDEX);
    IS(thurible_copy(solver, THURIBLE_FIELD_EMISSION, 1, 1, field, bytes), INDEX);
    IS(thurible_copy(solver, THURIBLE_FIELD_EMISSION, 1, 0, field, bytes - 1), LENGTH);
    IS(thurible_copy(solver, THURIBLE_FIELD_EMISSION, 1, 0, NULL, bytes), NULL);
    IS(thurible_view(solver, THURIBLE_FIELD_EMISSION, 1, 0, &view), INDEX);
    OK(thurible_step(other, NULL, NULL, NULL));
    OK(thurible_finish(other, NULL, NULL));
    /* The same now, and after another step. */
    for (int round = 0; round < 2; round++) {
        unsigned char *whole = result(&scene, solver, &whole_bytes), *again = result(&scene, other, &again_bytes);
        same("looked at what was emitted", whole, whole_bytes, again, again_bytes);
        free(whole);
        free(again);
        ThuribleProgress left, right;
        OK(thurible_step(solver, NULL, NULL, &left));
        OK(thurible_step(other, NULL, NULL, &right));
        CHECK(left.status == right.status);
        OK(thurible_finish(solver, NULL, NULL));
        OK(thurible_finish(other, NULL, NULL));
    }
    drop(other);
    /* Regions. */
    OK(thurible_copy(solver, THURIBLE_FIELD_REGION, 0, 0, field, bytes));
    CHECK(memcmp(field, scene.target, bytes) == 0);
    OK(thurible_view(solver, THURIBLE_FIELD_REGION, 0, 0, &view));
    CHECK(get(view.data, scene.number, 3 + 2 * view.strides[1]) == get(scene.target, scene.number, 3 + 2 * (size_t)10));
    IS(thurible_copy(solver, THURIBLE_FIELD_REGION, 1, 0, field, bytes), INDEX);
    IS(thurible_set_region(solver, 1, scene.target, bytes), INDEX);
    put(field, scene.number, 5, 1.25);
    IS(thurible_set_region(solver, 0, field, bytes), ABOVE_ONE);
    SAYS(thurible_message, solver, "value 5 is above 1");
    IS(thurible_set_region(solver, 0, field, bytes - 1), LENGTH);
    IS(thurible_set_region(solver, 0, NULL, bytes), NULL);
    put(field, scene.number, 5, -1.0);
    IS(thurible_set_emitter(solver, 1, field, bytes), NEGATIVE);
    IS(thurible_set_emitter(solver, 2, scene.target, bytes), INDEX);
    IS(thurible_set_emitter(solver, 0, (char *)field + 1, bytes), MISALIGNED);
    /* Saved of other effects. */
    unsigned char *saved = (unsigned char *)aligned(scene.saved);
    OK(thurible_save(solver, saved, scene.saved));
    emitters[0].rate = 0.5;
    other = empty(&scene);
    IS(thurible_restore(other, saved, scene.saved), SAVED_OTHER);
    drop(other);
    free(saved);
    free(field);
    drop(solver);
    drop_scene(&scene);
}

/* Smoke of an emitter alone, which the keyframe is scaled to; and the order in which source and emitter are given does not matter. */
static void emits_alone(void) {
    Scene scene;
    make_scene(&scene, THURIBLE_PRECISION_F64, 2, 8, 6, THURIBLE_METHOD_DIRECT);
    const ThuribleEmitter emitter = {2, 5, 4.0, 0.0, {0.0, 0.0, 0.0}, 0, 0};
    size_t bytes = scene.cells * 8, left_bytes = 0, right_bytes = 0;
    double factor = 0.0;
    scene.config.emitters = &emitter;
    scene.config.emitter_count = 1;
    OK(thurible_plan(&scene.config, &scene.bytes, NULL, &scene.saved));
    Thurible *left = empty(&scene);
    OK(thurible_set_emitter(left, 0, scene.source, bytes));
    OK(thurible_set_keyframe(left, 0, scene.target, bytes, &factor));
    CHECK(fabs(factor * mass_of(&scene, scene.target) - 4.0 * mass_of(&scene, scene.source)) < 1e-9);
    OK(thurible_set_keyframe(left, 1, scene.target, bytes, &factor));
    CHECK(fabs(factor * mass_of(&scene, scene.target) - 12.0 * mass_of(&scene, scene.source)) < 1e-9);
    OK(thurible_solve(left, NULL, NULL, NULL));
    CHECK(mass_at(&scene, left, THURIBLE_FIELD_DENSITY, 2) == 0.0);
    CHECK(fabs(mass_at(&scene, left, THURIBLE_FIELD_DENSITY, 6) - 12.0 * mass_of(&scene, scene.source)) < 1e-9);
    drop(left);
    scene.keyframes[0] = 2; /* before there is any smoke */
    left = empty(&scene);
    OK(thurible_set_emitter(left, 0, scene.source, bytes));
    IS(thurible_set_keyframe(left, 0, scene.target, bytes, &factor), NO_SOURCE);
    SAYS(thurible_message, left, "there is no smoke yet");
    drop(left);
    scene.keyframes[0] = 3;
    left = empty(&scene);
    Thurible *right = empty(&scene);
    OK(thurible_set_source(left, scene.source, bytes));
    OK(thurible_set_emitter(left, 0, scene.source, bytes));
    OK(thurible_set_emitter(right, 0, scene.source, bytes));
    OK(thurible_set_source(right, scene.source, bytes));
    for (size_t index = 0; index < 2; index++) {
        OK(thurible_set_keyframe(left, index, scene.target, bytes, NULL));
        OK(thurible_set_keyframe(right, index, scene.target, bytes, NULL));
    }
    OK(thurible_solve(left, NULL, NULL, NULL));
    OK(thurible_solve(right, NULL, NULL, NULL));
    unsigned char *first = result(&scene, left, &left_bytes), *second = result(&scene, right, &right_bytes);
    same("source and emitter in any order", first, left_bytes, second, right_bytes);
    free(first);
    free(second);
    drop(left);
    drop(right);
    drop_scene(&scene);
}

/* A wall across the box with a gap: no smoke gets into it, and no flow through it. */
static void solids(uint32_t precision, uint32_t dimensions, uint32_t method) {
    Scene scene;
    make_scene(&scene, precision, dimensions, 8, 6, method);
    scene.config.solids = 1;
    OK(thurible_plan(&scene.config, &scene.bytes, NULL, &scene.saved));
    Thurible *solver = empty(&scene);
    uint8_t *solid = (uint8_t *)aligned(scene.cells);
    size_t bytes = scene.cells * scene.number, faces = 0;
    for (size_t cell = 0; cell < scene.cells; cell++) solid[cell] = 1;
    IS(thurible_set_solids(solver, solid, scene.cells), NO_FLUID);
    for (size_t cell = 0; cell < scene.cells; cell++) solid[cell] = cell % 10 == 4 && cell / 10 % 8 > 2;
    IS(thurible_set_solids(solver, NULL, scene.cells), NULL);
    IS(thurible_set_solids(solver, solid, scene.cells - 1), LENGTH);
    IS(thurible_set_solids(solver, solid, SIZE_MAX), LENGTH);
    solid[7] = 2;
    IS(thurible_set_solids(solver, solid, scene.cells), ABOVE_ONE);
    solid[7] = 0;
    OK(thurible_set_solids(solver, solid, scene.cells));
    OK(thurible_set_source(solver, scene.source, bytes));
    for (size_t index = 0; index < 2; index++) OK(thurible_set_keyframe(solver, index, scene.target, bytes, NULL));
    OK(thurible_solve(solver, NULL, NULL, NULL));
    void *density = aligned(bytes);
    OK(thurible_copy(solver, THURIBLE_FIELD_DENSITY, 6, 0, density, bytes));
    OK(thurible_copy_bytes(solver, THURIBLE_FIELD_VELOCITY, 0, &faces));
    void *velocity = aligned(faces);
    OK(thurible_copy(solver, THURIBLE_FIELD_VELOCITY, 5, 0, velocity, faces));
    double fastest = 0.0;
    for (size_t cell = 0; cell < scene.cells; cell++) {
        size_t face = cell / 10 * 11 + cell % 10; /* files have a face more along x, which ends in walls */
        fastest = fmax(fastest, fabs(get(velocity, scene.number, face)));
        if (solid[cell]) CHECK(get(density, scene.number, cell) == 0.0 && get(velocity, scene.number, face) == 0.0 && get(velocity, scene.number, face + 1) == 0.0);
    }
    CHECK(mass_of(&scene, density) > 0.0 && (fastest > 0.0 || method == THURIBLE_METHOD_SIMULATE));
    free(velocity);
    free(density);
    free(solid);
    drop(solver);
    drop_scene(&scene);
}

/* A wind and a vortex that moves: what they were found to be, the same after saving, and a simulation of what is given. */
static void templates(uint32_t precision, uint32_t dimensions) {
    Scene scene;
    ThuribleTemplate forms[2] = {
        {THURIBLE_TEMPLATE_KIND_WIND, 0, 0, 6, 3, {0.4, 0.5, 0.5}, 0.3, {0.0, 0.0, 0.0}, 0.0, 0, 0},
        {THURIBLE_TEMPLATE_KIND_VORTEX, 1, 1, 5, 0, {0.5, 0.4, 0.4}, 0.25, {0.0, 0.0, 0.0}, 0.0, 0, 0},
    };
    make_scene(&scene, precision, dimensions, 10, 6, THURIBLE_METHOD_SIMULATE);
    scene.config.method = THURIBLE_METHOD_TEMPLATES;
    scene.config.templates = forms;
    scene.config.template_count = 2;
    scene.config.iterations = 4;
    scene.config.force_weight = 1.0;
    OK(thurible_plan(&scene.config, &scene.bytes, NULL, &scene.saved));
    size_t bytes = scene.cells * scene.number;
    Thurible *solver = empty(&scene);
    ThuribleTemplate found;
    double amplitude[3], later[3];
    IS(thurible_template(solver, 0, &found), NO_RESULT);
    OK(thurible_set_source(solver, scene.source, bytes));
    for (size_t index = 0; index < 2; index++) OK(thurible_set_keyframe(solver, index, scene.target, bytes, NULL));
    OK(thurible_solve(solver, NULL, NULL, NULL));
    IS(thurible_template(solver, 2, &found), INDEX);
    IS(thurible_template(solver, 0, NULL), NULL);
    OK(thurible_template(solver, 0, &found));
    CHECK(found.kind == THURIBLE_TEMPLATE_KIND_WIND && found.to == 5 && found.interval == 3 && found.radius == 0.3);
    OK(thurible_template_amplitude(solver, 0, 2, amplitude));
    OK(thurible_template_amplitude(solver, 0, 3, later));
    CHECK(amplitude[0] == found.amplitude[0] && amplitude[0] != later[0] && amplitude[0] != 0.0);
    CHECK(dimensions == 3 || amplitude[2] == 0.0);
    IS(thurible_template_amplitude(solver, 0, 5, amplitude), INDEX);
    IS(thurible_template_amplitude(solver, 0, 0, NULL), NULL);
    OK(thurible_template(solver, 1, &found));
    CHECK(found.moves == 1 && found.radius != 0.25 && found.center[0] != 0.5 && found.amplitude[0] != 0.0);
    unsigned char *saved = (unsigned char *)aligned(scene.saved);
    OK(thurible_save(solver, saved, scene.saved));
    Thurible *other = empty(&scene);
    OK(thurible_restore(other, saved, scene.saved));
    OK(thurible_template(other, 1, &forms[1]));
    CHECK(forms[1].radius == found.radius && forms[1].amplitude[0] == found.amplitude[0]);
    drop(other);
    drop(solver);
    free(saved);
    /* By its amplitudes a simulation is pushed. */
    scene.config.method = THURIBLE_METHOD_SIMULATE;
    scene.config.keyframe_count = 0;
    forms[0].amplitude[0] = 0.01;
    OK(thurible_plan(&scene.config, &scene.bytes, NULL, &scene.saved));
    solver = empty(&scene);
    OK(thurible_set_source(solver, scene.source, bytes));
    OK(thurible_solve(solver, NULL, NULL, NULL));
    size_t faces = 0;
    OK(thurible_copy_bytes(solver, THURIBLE_FIELD_VELOCITY, 0, &faces));
    void *velocity = aligned(faces);
    OK(thurible_copy(solver, THURIBLE_FIELD_VELOCITY, 5, 0, velocity, faces));
    double fastest = 0.0;
    for (size_t face = 0; face < faces / scene.number; face++) fastest = fmax(fastest, get(velocity, scene.number, face));
    CHECK(fastest > 0.01);
    OK(thurible_template(solver, 0, &found));
    CHECK(fabs(found.amplitude[0] - 0.01) < 1e-8);
    free(velocity);
    drop(solver);
    drop_scene(&scene);
}

/* A flow that is given guides another, which begins at rest. */
static void guides(uint32_t precision, uint32_t dimensions) {
    Scene scene;
    make_scene(&scene, precision, dimensions, 10, 4, THURIBLE_METHOD_GUIDE);
    scene.config.keyframe_count = 0;
    OK(thurible_plan(&scene.config, &scene.bytes, NULL, &scene.saved));
    Thurible *solver = empty(&scene);
    OK(thurible_set_source(solver, scene.source, scene.cells * scene.number));
    IS(thurible_solve(solver, NULL, NULL, NULL), NO_REFERENCE);
    size_t bytes = 0;
    OK(thurible_copy_bytes(solver, THURIBLE_FIELD_VELOCITY, 1, &bytes));
    void *wind = aligned(bytes);
    for (size_t face = 0; face < bytes / scene.number; face++) put(wind, scene.number, face, 0.02);
    IS(thurible_set_reference(solver, 1, 4, wind, bytes), INDEX);
    IS(thurible_set_reference(solver, 3, 1, wind, bytes), INDEX);
    IS(thurible_set_reference(solver, 1, 1, wind, bytes - scene.number), LENGTH);
    for (size_t step = 1; step < 4; step++) OK(thurible_set_reference(solver, 1, step, wind, bytes));
    OK(thurible_solve(solver, NULL, NULL, NULL));
    /* A wind along a ring is met, whatever the rest does. */
    OK(thurible_copy(solver, THURIBLE_FIELD_VELOCITY, 3, 1, wind, bytes));
    double mean = 0.0;
    for (size_t face = 0; face < bytes / scene.number; face++) mean += get(wind, scene.number, face);
    mean /= (double)(bytes / scene.number);
    CHECK(fabs(mean - 0.02) < 1e-3);
    free(wind);
    drop(solver);
    drop_scene(&scene);
}

int main(void) {
    versions_and_texts();
    configurations();
    handles();
    inputs();
    views();
    facts();
    side_by_side();
    leaves(THURIBLE_PRECISION_F64, 2);
    leaves(THURIBLE_PRECISION_F32, 3);
    for (uint32_t method = THURIBLE_METHOD_DIRECT; method <= THURIBLE_METHOD_SIMULATE; method++) {
        outputs(THURIBLE_PRECISION_F32, 2, method);
        outputs(THURIBLE_PRECISION_F64, 3, method);
        emits(THURIBLE_PRECISION_F64, 2, method);
        emits(THURIBLE_PRECISION_F32, 3, method);
        saves_and_goes_on(THURIBLE_PRECISION_F32, 2, 16, method);
        saves_and_goes_on(THURIBLE_PRECISION_F64, 2, 9, method);
        saves_and_goes_on(THURIBLE_PRECISION_F32, 3, 6, method);
        saves_and_goes_on(THURIBLE_PRECISION_F64, 3, 8, method);
        solids(THURIBLE_PRECISION_F32, 2, method);
        solids(THURIBLE_PRECISION_F64, 3, method);
    }
    executors();
    observers();
    free_flow();
    templates(THURIBLE_PRECISION_F32, 2);
    templates(THURIBLE_PRECISION_F64, 3);
    guides(THURIBLE_PRECISION_F32, 2);
    guides(THURIBLE_PRECISION_F64, 3);
    emits_alone();
    if (failures) fprintf(stderr, "%d checks failed\n", failures);
    return failures != 0;
}

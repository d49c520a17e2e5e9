/* A simulation and its adjoint through thurible.h, by both simulators, and the search by Stable Fluids, as C11 and as C++17. Ends with 0 when every check holds. */
#include "check.h"

/* The density, then the components. */
enum { PARTS = 4 };

static uint64_t state = 0x9E3779B97F4A7C15u;

static double unit(void) { /* xorshift64*, Vigna 2016: from 0 to 1 */
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (double)((state * 0x2545F4914F6CDD1Du) >> 11) / 9007199254740992.0;
}

static double both(void) { return 2.0 * unit() - 1.0; }

#define STEPS 5
#define PARTS 4

/* An operator, and every array that it is given or gives. Fields of all steps lie one after the other. */
typedef struct {
    ThuribleConfig scene;
    ThuribleFluidsConfig fluids;
    ThuribleOperatorConfig config;
    ThuribleEmitter emitter;
    ThuribleTemplate wind;
    void *memory;
    size_t bytes, slots, repeated, ran;
    ThuribleOperator *handle;
    size_t number, len[PARTS];                   /* numbers of a density and of each component */
    void *start[PARTS], *force[PARTS], *states[PARTS], *covector[PARTS], *shape;
    void *by_start[PARTS], *by_force[PARTS], *by_shape;
    double by_buoyancy[3];
    ThuribleEmitterGradient by_emitter;
} Work;

static ThuribleSteps arrays(Work *work, void *const fields[PARTS], size_t steps) {
    ThuribleSteps all;
    memset(&all, 0, sizeof all);
    if (fields[0]) all.density = fields[0], all.density_bytes = steps * work->len[0] * work->number;
    for (int axis = 0; axis < 3; axis++)
        if (fields[1 + axis]) all.vector[axis] = fields[1 + axis], all.vector_bytes[axis] = steps * work->len[1 + axis] * work->number;
    return all;
}

static void *field(Work *work, size_t count, double low, double high) {
    void *made = aligned(count * work->number);
    for (size_t index = 0; index < count; index++) put(made, work->number, index, low + (high - low) * unit());
    return made;
}

/* Makes the operator of the configurations, and sets what does not change. */
static void begin(Work *work) {
    size_t alignment = 0;
    OK(thurible_operator_plan(&work->scene, &work->config, &work->bytes, &alignment, &work->slots, &work->repeated));
    CHECK(alignment == 64 && work->bytes > 0);
    CHECK(thurible_operator_explain(&work->scene, &work->config, NULL, 0) == 0);
    work->memory = aligned(work->bytes);
    IS(thurible_operator_init(work->memory, work->bytes - 1, &work->scene, &work->config, &work->handle), TOO_SMALL);
    CHECK(work->handle == NULL);
    OK(thurible_operator_init(work->memory, work->bytes, &work->scene, &work->config, &work->handle));
    for (size_t part = 0; part < PARTS; part++) {
        size_t bytes = 0;
        if (part > work->scene.dimensions) {
            IS(thurible_operator_bytes(work->handle, part, &bytes), INDEX);
        } else {
            OK(thurible_operator_bytes(work->handle, part, &bytes));
        }
        work->len[part] = bytes / work->number;
    }
    size_t none = 0;
    IS(thurible_operator_bytes(work->handle, PARTS, &none), INDEX);
    if (work->scene.solids) {
        uint8_t *solid = (uint8_t *)aligned(work->len[0]);
        memset(solid, 0, work->len[0]);
        solid[28] = solid[29] = 1;
        OK(thurible_operator_set_solids(work->handle, solid, work->len[0]));
        free(solid);
    }
    if (work->shape) OK(thurible_operator_set_emitter(work->handle, 0, work->shape, work->len[0] * work->number));
}

static void end(Work *work) {
    OK(thurible_operator_close(work->handle));
    IS(thurible_operator_close(work->handle), NO_INSTANCE);
    free(work->memory);
}

/* A scene with all that a simulator takes, and random fields. */
static void make(Work *work, uint32_t simulator, uint32_t precision, uint32_t dimensions) {
    memset(work, 0, sizeof *work);
    OK(thurible_defaults(&work->scene, sizeof work->scene));
    OK(thurible_fluids_defaults(&work->fluids, sizeof work->fluids));
    OK(thurible_operator_defaults(&work->config, sizeof work->config));
    ThuribleConfig *scene = &work->scene;
    scene->precision = precision;
    scene->dimensions = dimensions;
    scene->cells[0] = dimensions == 2 ? 11 : 7, scene->cells[1] = dimensions == 2 ? 9 : 6, scene->cells[2] = 5;
    scene->boundary[1] = THURIBLE_BOUNDARY_PERIODIC;
    scene->steps = STEPS;
    scene->length = 2.0;
    scene->dt = 0.5;
    scene->viscosity = 1e-3;
    scene->buoyancy[1] = 0.3;
    scene->templates = &work->wind;
    scene->template_count = 1;
    work->wind.kind = THURIBLE_TEMPLATE_KIND_WIND;
    work->wind.to = STEPS - 1;
    for (int axis = 0; axis < 3; axis++) work->wind.center[axis] = 0.8, work->wind.amplitude[axis] = 0.1 * axis - 0.05;
    work->wind.radius = 0.5;
    work->number = precision;
    work->fluids.diffusion = 1e-3;
    work->config.simulator = simulator;
    work->config.fluids = &work->fluids;
    if (simulator == THURIBLE_SIMULATOR_IMPLICIT) {
        scene->solids = dimensions == 2;
        scene->emitters = &work->emitter;
        scene->emitter_count = 1;
        work->emitter.from = 1, work->emitter.to = 4;
        work->emitter.rate = 0.4;
        work->emitter.velocity[0] = 0.3;
        work->emitter.pushes = 1;
        work->shape = field(work, dimensions == 2 ? 99 : 210, 0.1, 0.9);
    }
    begin(work);
    const double slow = 0.2;
    for (size_t part = 0; part < PARTS; part++) {
        if (!work->len[part]) continue;
        work->start[part] = field(work, work->len[part], part ? -slow : 0.2, part ? slow : 1.0);
        if (part) work->force[part] = field(work, STEPS * work->len[part], -slow, slow);
        work->states[part] = field(work, (STEPS + 1) * work->len[part], 0.0, 1.0);
        work->covector[part] = field(work, (STEPS + 1) * work->len[part], -1.0, 1.0);
        work->by_start[part] = field(work, work->len[part], 0.0, 1.0);
        if (part) work->by_force[part] = field(work, STEPS * work->len[part], 0.0, 1.0);
    }
    work->by_shape = field(work, work->len[0], 0.0, 1.0);
}

static void drop(Work *work) {
    end(work);
    for (size_t part = 0; part < PARTS; part++) {
        free(work->start[part]), free(work->force[part]), free(work->states[part]), free(work->covector[part]);
        free(work->by_start[part]), free(work->by_force[part]);
    }
    free(work->shape), free(work->by_shape);
}

/* <covectors, states>. */
static double value(Work *work) {
    ThuribleRan ran;
    const ThuribleSteps start = arrays(work, work->start, 1), force = arrays(work, work->force, STEPS), states = arrays(work, work->states, STEPS + 1);
    OK(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran));
    CHECK(ran.status == THURIBLE_STATUS_CONVERGED);
    double sum = 0.0;
    for (size_t part = 0; part < PARTS; part++)
        for (size_t index = 0; index < (STEPS + 1) * work->len[part]; index++)
            sum += get(work->covector[part], work->number, index) * get(work->states[part], work->number, index);
    return sum;
}

static void back(Work *work) {
    ThuribleRan ran;
    const ThuribleSteps force = arrays(work, work->force, STEPS), covector = arrays(work, work->covector, STEPS + 1), by_force = arrays(work, work->by_force, STEPS);
    OK(thurible_operator_vjp(work->handle, NULL, NULL, &force, &covector, &by_force, &ran));
    CHECK(ran.status == THURIBLE_STATUS_CONVERGED);
    work->ran = ran.repeated;
    for (size_t part = 0; part < PARTS; part++)
        if (work->len[part]) OK(thurible_operator_gradient(work->handle, part, work->by_start[part], work->len[part] * work->number));
    OK(thurible_operator_buoyancy(work->handle, work->by_buoyancy));
    if (work->shape) OK(thurible_operator_emitter(work->handle, 0, &work->by_emitter, work->by_shape, work->len[0] * work->number));
    else IS(thurible_operator_emitter(work->handle, 0, &work->by_emitter, NULL, 0), INDEX);
}

/* Goes along a field, whose gradient is given; its derivative along that way. */
static double go(Work *work, void *field, const void *gradient, size_t count, double h) {
    double along = 0.0;
    for (size_t index = 0; field && index < count; index++) {
        const double way = both(), at = get(field, work->number, index);
        put(field, work->number, index, at + h * way);
        if (gradient) along += way * get(gradient, work->number, index);
    }
    return along;
}

/* Moves all inputs at once by h along the random way that `seed` gives; the derivative along it. */
static double move(Work *work, uint64_t seed, double h) {
    state = seed;
    double along = 0.0;
    for (size_t part = 0; part < PARTS; part++) {
        along += go(work, work->start[part], work->by_start[part], work->len[part], h);
        along += go(work, work->force[part], work->by_force[part], STEPS * work->len[part], h);
    }
    for (uint32_t axis = 0; axis < work->scene.dimensions; axis++) {
        const double way = both();
        work->scene.buoyancy[axis] += h * way;
        along += way * work->by_buoyancy[axis];
    }
    if (work->shape) {
        along += go(work, work->shape, work->by_shape, work->len[0], h);
        const double way = both(), turn = both();
        work->emitter.rate += h * way;
        work->emitter.velocity[0] += h * turn;
        along += way * work->by_emitter.supply + turn * work->by_emitter.velocity[0];
    }
    end(work);
    begin(work);
    return along;
}

/* Taylor's test in all inputs at once: density, velocity, forces, buoyancy, and rate, velocity and shape of an emitter. */
static void taylor(Work *work) {
    value(work);
    back(work);
    CHECK(work->ran == work->repeated);
    double best = 1e300;
    for (double h = 1e-5; h > 5e-8; h /= 10.0) {
        const double along = move(work, 77, h), ahead = value(work);
        move(work, 77, -2.0 * h);
        const double behind = value(work);
        move(work, 77, h);
        best = fmin(best, fabs((ahead - behind) / (2.0 * h) - along) / fabs(along));
    }
    CHECK(best < 1e-6);
    if (!(best < 1e-6)) fprintf(stderr, "simulator %u, %uD: %g\n", (unsigned)work->config.simulator, (unsigned)work->scene.dimensions, best);
}

/* A covector that is the same everywhere is all gradient: no velocity gets anything by it, and no cycle of the adjoint is needed. */
static void gradient_alone(void) {
    Work work;
    make(&work, THURIBLE_SIMULATOR_IMPLICIT, THURIBLE_PRECISION_F64, 3);
    value(&work);
    for (size_t part = 0; part < PARTS; part++)
        for (size_t index = 0; index < (STEPS + 1) * work.len[part]; index++) put(work.covector[part], work.number, index, part == 1);
    back(&work);
    for (size_t index = 0; index < work.len[0]; index++) CHECK(fabs(get(work.by_start[0], work.number, index)) < 1e-9);
    drop(&work);
}

/* What callbacks of a step see and do. */
typedef struct {
    Work *work;
    void *const *whole;   /* what is given, of all steps */
    void *one[PARTS];     /* a step of it, or of what is handed out */
    void *const *collect; /* where that goes to */
    size_t calls, last, nothing, stop;
} Told;

static int32_t gives(void *context, size_t step) {
    Told *told = (Told *)context;
    told->calls++, told->last = step;
    if (step == told->stop) return -1;
    if (step == told->nothing) return THURIBLE_NOTHING;
    for (size_t part = 0; part < PARTS; part++)
        if (told->one[part]) {
            const size_t bytes = told->work->len[part] * told->work->number;
            memcpy(told->one[part], (const char *)told->whole[part] + step * bytes, bytes);
        }
    return 0;
}

static int32_t takes(void *context, size_t step) {
    Told *told = (Told *)context;
    told->calls++, told->last = step;
    for (size_t part = 0; part < PARTS; part++)
        if (told->one[part]) {
            const size_t bytes = told->work->len[part] * told->work->number;
            memcpy((char *)told->collect[part] + step * bytes, told->one[part], bytes);
        }
    return step == told->stop ? -1 : 0;
}

static ThuribleSteps calls(Told *told, Work *work, void *const whole[PARTS], void *const collect[PARTS]) {
    memset(told, 0, sizeof *told);
    told->work = work, told->whole = whole, told->collect = collect;
    told->nothing = told->stop = SIZE_MAX;
    for (size_t part = 0; part < PARTS; part++)
        if ((whole ? whole : collect)[part]) told->one[part] = aligned(work->len[part] * work->number);
    ThuribleSteps steps = arrays(work, told->one, 1);
    steps.on = whole ? gives : takes;
    steps.context = told;
    return steps;
}

static void forget(Told *told) {
    for (size_t part = 0; part < PARTS; part++) free(told->one[part]);
}

/* Copies of all that a run gives, to compare. */
static void *copied(Work *work) {
    size_t bytes = 0, at = 0;
    for (size_t part = 0; part < PARTS; part++) bytes += (2 * STEPS + 2) * work->len[part] * work->number;
    char *copy = (char *)aligned(bytes);
    memset(copy, 0, bytes);
    for (size_t part = 0; part < PARTS; part++) {
        const size_t one = work->len[part] * work->number;
        if (!one) continue;
        memcpy(copy + at, work->states[part], (STEPS + 1) * one), at += (STEPS + 1) * one;
        memcpy(copy + at, work->by_start[part], one), at += one;
        if (part) memcpy(copy + at, work->by_force[part], STEPS * one), at += STEPS * one;
    }
    return copy;
}

static int alike(Work *work, const void *before) {
    size_t bytes = 0;
    for (size_t part = 0; part < PARTS; part++) bytes += (2 * STEPS + 2) * work->len[part] * work->number;
    void *now = copied(work);
    const int same = memcmp(now, before, bytes) == 0;
    free(now);
    return same;
}

/* Any number of kept states, and step by step through callbacks: the same bits. */
static void same_bits(Work *work) {
    value(work);
    back(work);
    void *before = copied(work);
    const uint32_t automatic = work->config.slots;
    for (uint32_t slots = 1; slots <= 3; slots++) {
        end(work);
        work->config.slots = slots;
        begin(work);
        CHECK(work->slots == slots);
        value(work);
        back(work);
        CHECK(work->ran == work->repeated && work->ran > 0);
        CHECK(alike(work, before));
        back(work);
        CHECK(alike(work, before));
    }
    Told forces, states, covectors, by_force;
    ThuribleRan ran;
    const ThuribleSteps start = arrays(work, work->start, 1);
    ThuribleSteps force = calls(&forces, work, work->force, NULL), shown = calls(&states, work, NULL, work->states);
    for (size_t part = 0; part <= work->scene.dimensions; part++) {
        memset(work->states[part], 0, (STEPS + 1) * work->len[part] * work->number);
        memset(work->by_start[part], 0, work->len[part] * work->number);
        if (part) memset(work->by_force[part], 0, STEPS * work->len[part] * work->number);
    }
    OK(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &shown, &ran));
    CHECK(states.calls == STEPS + 1 && states.last == STEPS && forces.calls == STEPS);
    ThuribleSteps covector = calls(&covectors, work, work->covector, NULL), taken = calls(&by_force, work, NULL, work->by_force);
    OK(thurible_operator_vjp(work->handle, NULL, NULL, &force, &covector, &taken, &ran));
    CHECK(ran.status == THURIBLE_STATUS_CONVERGED && covectors.calls == STEPS + 1 && covectors.last == 0);
    CHECK(by_force.calls == STEPS && by_force.last == 0);
    for (size_t part = 0; part < PARTS; part++)
        if (work->len[part]) OK(thurible_operator_gradient(work->handle, part, work->by_start[part], work->len[part] * work->number));
    CHECK(alike(work, before));
    /* Nothing at a step is the same as an array of 0. */
    covectors.nothing = 2;
    OK(thurible_operator_vjp(work->handle, NULL, NULL, &force, &covector, NULL, &ran));
    OK(thurible_operator_gradient(work->handle, 0, work->by_start[0], work->len[0] * work->number));
    for (size_t part = 0; part < PARTS; part++)
        if (work->len[part]) memset((char *)work->covector[part] + 2 * work->len[part] * work->number, 0, work->len[part] * work->number);
    void *first = aligned(work->len[0] * work->number);
    memcpy(first, work->by_start[0], work->len[0] * work->number);
    back(work);
    CHECK(memcmp(first, work->by_start[0], work->len[0] * work->number) == 0);
    free(first);
    /* A callback stops, whichever it is; then there is nothing to read. */
    covectors.stop = 3;
    OK(thurible_operator_vjp(work->handle, NULL, NULL, &force, &covector, NULL, &ran));
    CHECK(ran.status == THURIBLE_STATUS_CANCELLED);
    IS(thurible_operator_gradient(work->handle, 0, work->by_start[0], work->len[0] * work->number), NO_RESULT);
    covectors.stop = SIZE_MAX, covectors.calls = 0;
    OK(thurible_operator_vjp(work->handle, NULL, NULL, &force, &covector, NULL, &ran));
    CHECK(ran.status == THURIBLE_STATUS_CONVERGED);
    states.stop = 2, states.calls = 0;
    OK(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &shown, &ran));
    CHECK(ran.status == THURIBLE_STATUS_CANCELLED && states.calls == 3);
    IS(thurible_operator_vjp(work->handle, NULL, NULL, &force, &covector, NULL, &ran), NO_RESULT);
    SAYS(thurible_operator_message, work->handle, "nothing was simulated");
    forget(&forces), forget(&states), forget(&covectors), forget(&by_force);
    free(before);
    end(work);
    work->config.slots = automatic;
    begin(work);
}

static int32_t stop(void *context, const ThuribleEvent *event) {
    (void)event;
    return ++*(int *)context > 4;
}

/* Everything that is wrong is refused, and changes nothing. */
static void refusals(Work *work) {
    ThuribleRan ran;
    const double before = value(work);
    ThuribleSteps start = arrays(work, work->start, 1), force = arrays(work, work->force, STEPS), states = arrays(work, work->states, STEPS + 1);
    IS(thurible_operator_simulate(NULL, NULL, NULL, &start, &force, &states, &ran), NULL);
    IS(thurible_operator_simulate(work->handle, NULL, NULL, NULL, &force, &states, &ran), NULL);
    IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, NULL), NULL);
    start.density = NULL;
    IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran), NULL);
    start.density = work->start[0];
    start.density_bytes -= work->number;
    IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran), LENGTH);
    start.density_bytes += work->number;
    states.vector_bytes[1] -= work->number;
    IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran), LENGTH);
    states.vector_bytes[1] += work->number;
    force.vector[0] = (char *)work->force[1] + 1;
    IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran), MISALIGNED);
    force.vector[0] = work->force[1];
    force.density = work->start[0], force.density_bytes = start.density_bytes;
    IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran), INDEX);
    force.density = NULL;
    if (work->scene.dimensions == 2) {
        force.vector[2] = work->force[1], force.vector_bytes[2] = force.vector_bytes[0];
        IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran), INDEX);
        force.vector[2] = NULL;
    }
    const ThuribleExecutor none = {1, NULL, NULL};
    IS(thurible_operator_simulate(work->handle, &none, NULL, &start, &force, &states, &ran), EXECUTOR);
    /* None of these took the simulation away. */
    back(work);
    IS(thurible_operator_gradient(work->handle, 0, work->by_start[0], work->number), LENGTH);
    IS(thurible_operator_gradient(work->handle, PARTS, work->by_start[0], work->number), INDEX);
    IS(thurible_operator_gradient(work->handle, 0, NULL, work->len[0] * work->number), NULL);
    IS(thurible_operator_buoyancy(work->handle, NULL), NULL);
    const size_t at = 2 * work->len[2] + 5;
    const double kept = get(work->force[2], work->number, at);
    put(work->force[2], work->number, at, NAN);
    IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran), NOT_FINITE);
    SAYS(thurible_operator_message, work->handle, "the force of step 2 is refused: value 5 is not finite");
    put(work->force[2], work->number, at, kept);
    IS(thurible_operator_buoyancy(work->handle, work->by_buoyancy), NO_RESULT);
    put(work->start[1], work->number, 3, INFINITY);
    IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran), NOT_FINITE);
    SAYS(thurible_operator_message, work->handle, "the velocity at the start is refused");
    put(work->start[1], work->number, 3, 0.0);
    int heard = 0;
    const ThuribleObserver observer = {stop, &heard};
    OK(thurible_operator_simulate(work->handle, NULL, &observer, &start, &force, &states, &ran));
    CHECK(ran.status == THURIBLE_STATUS_CANCELLED && heard > 4);
    void *pushed = aligned(STEPS * work->len[2] * work->number);
    memcpy(pushed, work->force[2], STEPS * work->len[2] * work->number);
    for (size_t face = 0; face < STEPS * work->len[2]; face++) put(work->force[2], work->number, face, work->number == 4 ? 3.4e38 : 1.79e308);
    OK(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran));
    CHECK(ran.status == THURIBLE_STATUS_NOT_FINITE);
    memcpy(work->force[2], pushed, STEPS * work->len[2] * work->number);
    free(pushed);
    CHECK(isfinite(before) && isfinite(value(work)));
    IS(thurible_operator_set_emitter(work->handle, 1, work->start[0], start.density_bytes), INDEX);
    IS(thurible_operator_set_solids(work->handle, NULL, 0), NULL);
    /* Configurations. */
    work->scene.memory_ceiling = work->bytes;
    work->config.slots = 0;
    if (work->config.simulator == THURIBLE_SIMULATOR_IMPLICIT) {
        IS(thurible_operator_plan(&work->scene, &work->config, NULL, NULL, NULL, NULL), CONFIG);
        thurible_operator_explain(&work->scene, &work->config, text, sizeof text);
        CHECK(strstr(text, "slots"));
    }
    work->config.slots = STEPS + 1;
    IS(thurible_operator_plan(&work->scene, &work->config, NULL, NULL, NULL, NULL), CONFIG);
    work->config.slots = THURIBLE_AUTOMATIC;
    work->scene.memory_ceiling = 1000;
    IS(thurible_operator_plan(&work->scene, &work->config, NULL, NULL, NULL, NULL), CONFIG);
    thurible_operator_explain(&work->scene, &work->config, text, sizeof text);
    CHECK(strstr(text, "ceiling"));
    work->scene.memory_ceiling = 0;
    work->config.simulator = 2;
    thurible_operator_explain(&work->scene, &work->config, text, sizeof text);
    CHECK(strstr(text, "simulator is 2, which stands for nothing"));
    work->config.simulator = THURIBLE_SIMULATOR_STABLE_FLUIDS;
    work->fluids.adjoint = THURIBLE_ADJOINT_SECOND_SOLVE;
    thurible_operator_explain(&work->scene, &work->config, text, sizeof text);
    CHECK(text[0]);
    IS(thurible_operator_plan(NULL, NULL, NULL, NULL, NULL, NULL), NULL);
    OK(thurible_operator_close(work->handle));
    IS(thurible_operator_simulate(work->handle, NULL, NULL, &start, &force, &states, &ran), NO_INSTANCE);
    work->fluids.adjoint = THURIBLE_ADJOINT_EXACT;
}

/* The most states that a ceiling holds; one byte less, and there is one state less. */
static void ceilings(uint32_t simulator) {
    Work work;
    make(&work, simulator, THURIBLE_PRECISION_F64, 2);
    size_t bytes[3], slots = 0;
    for (uint32_t states = 1; states <= 2; states++) {
        work.config.slots = states;
        OK(thurible_operator_plan(&work.scene, &work.config, &bytes[states], NULL, NULL, NULL));
    }
    CHECK(bytes[2] > bytes[1]);
    work.config.slots = THURIBLE_AUTOMATIC;
    size_t place = 0; /* the place of the handle is beside the ceiling */
    work.scene.memory_ceiling = bytes[2];
    OK(thurible_operator_plan(&work.scene, &work.config, &place, NULL, &slots, NULL));
    CHECK(slots >= 2 && place >= bytes[2]);
    for (work.scene.memory_ceiling = bytes[2]; slots >= 2; work.scene.memory_ceiling -= 64)
        OK(thurible_operator_plan(&work.scene, &work.config, &place, NULL, &slots, NULL));
    CHECK(slots == 1 && place == bytes[1]);
    work.scene.memory_ceiling = 0;
    drop(&work);
}

/* ------------------------------------------------------------------------------------------------------- the search */

#define SIDE 16

static double blob(double x, double y, double at) { return exp(-((x - at) * (x - at) + (y - 7.5) * (y - 7.5)) / 8.0); }

/* The search in another block, planned for other states, from its saved bytes; damaged and other ones are refused and change nothing. */
static ThuribleFluids *elsewhere(ThuribleFluids *fluids, ThuribleConfig scene, ThuribleFluidsConfig config, void **memory) {
    size_t bytes = 0, saved_bytes = 0;
    OK(thurible_fluids_saved_bytes(&scene, &config, &saved_bytes));
    IS(thurible_fluids_saved_bytes(NULL, &config, &saved_bytes), NULL);
    unsigned char *saved = (unsigned char *)aligned(saved_bytes + 1);
    IS(thurible_fluids_save(fluids, saved, saved_bytes - 1), LENGTH);
    IS(thurible_fluids_save(fluids, NULL, saved_bytes), NULL);
    OK(thurible_fluids_save(fluids, saved, saved_bytes + 1));
    CHECK(saved[saved_bytes] == 0xA5);
    config.slots = 0;
    config.sweeps += 1;
    OK(thurible_fluids_plan(&scene, &config, &bytes, NULL, NULL, NULL));
    void *other = aligned(bytes);
    ThuribleFluids *there = NULL;
    OK(thurible_fluids_init(other, bytes, &scene, &config, &there));
    IS(thurible_fluids_restore(there, saved, saved_bytes), SAVED_OTHER);
    OK(thurible_fluids_close(there));
    config.sweeps -= 1;
    OK(thurible_fluids_init(other, bytes, &scene, &config, &there));
    ThuribleSearched searched;
    IS(thurible_fluids_restore(there, saved, saved_bytes - 1), LENGTH);
    IS(thurible_fluids_restore(there, NULL, saved_bytes), NULL);
    const size_t places[] = {0, 8, 40, saved_bytes / 2, saved_bytes - 1};
    const ThuribleResult wanted[] = {THURIBLE_RESULT_NOT_SAVED, THURIBLE_RESULT_SAVED_FORMAT, THURIBLE_RESULT_SAVED_DAMAGED, THURIBLE_RESULT_SAVED_DAMAGED, THURIBLE_RESULT_SAVED_DAMAGED};
    for (size_t place = 0; place < 5; place++) {
        saved[places[place]] ^= 4;
        check_result(__LINE__, "a damaged state", thurible_fluids_restore(there, saved, saved_bytes), wanted[place]);
        OK(thurible_fluids_step(there, NULL, NULL, &searched));
        CHECK(searched.status == THURIBLE_STATUS_NOT_READY);
        saved[places[place]] ^= 4;
    }
    OK(thurible_fluids_restore(there, saved, saved_bytes));
    unsigned char *again = (unsigned char *)aligned(saved_bytes);
    OK(thurible_fluids_save(there, again, saved_bytes));
    CHECK(memcmp(again, saved, saved_bytes) == 0);
    OK(thurible_fluids_close(fluids));
    free(*memory), free(saved), free(again);
    *memory = other;
    return there;
}

/* A blob goes to the right by each control; what is found is read, and steps are the same as a solve. */
static void searches(uint32_t precision, uint32_t controls) {
    const size_t keyframe = 6, number = precision, cells = SIDE * SIDE, bytes_of = cells * number;
    ThuribleConfig scene;
    ThuribleFluidsConfig config;
    ThuribleTemplate wind;
    memset(&wind, 0, sizeof wind);
    wind.kind = THURIBLE_TEMPLATE_KIND_WIND;
    wind.to = 6, wind.interval = 3, wind.moves = 1;
    wind.center[0] = wind.center[1] = 0.5, wind.radius = 0.4;
    OK(thurible_defaults(&scene, sizeof scene));
    OK(thurible_fluids_defaults(&config, sizeof config));
    CHECK(config.size == sizeof config && config.sweeps == 20 && config.history == 5 && config.iterations == 60);
    scene.precision = precision;
    scene.cells[0] = scene.cells[1] = SIDE;
    scene.steps = 6;
    scene.keyframes = &keyframe;
    scene.keyframe_count = 1;
    scene.force_weight = 0.1;
    if (controls == THURIBLE_CONTROL_TEMPLATES) scene.templates = &wind, scene.template_count = 1;
    config.controls = controls;
    config.initial_weight = 0.1;
    config.iterations = 15;
    config.slots = 2;
    void *source = aligned(bytes_of), *target = aligned(bytes_of), *last = aligned(7 * bytes_of), *velocity = aligned(7 * bytes_of), *force = aligned(6 * bytes_of);
    for (size_t cell = 0; cell < cells; cell++) {
        const double x = (double)(cell % SIDE), y = (double)(cell / SIDE);
        put(source, number, cell, blob(x, y, 5.0));
        put(target, number, cell, blob(x, y, 9.0));
    }
    size_t bytes = 0, slots = 0, repeated = 0;
    OK(thurible_fluids_plan(&scene, &config, &bytes, NULL, &slots, &repeated));
    CHECK(slots == 2 && repeated > 0);
    double objective[2] = {0.0, 0.0};
    for (int whole = 0; whole < 2; whole++) {
        void *memory = aligned(bytes);
        ThuribleFluids *fluids = NULL;
        ThuribleSearched searched, first;
        IS(thurible_fluids_init(memory, bytes - 1, &scene, &config, &fluids), TOO_SMALL);
        OK(thurible_fluids_init(memory, bytes, &scene, &config, &fluids));
        OK(thurible_fluids_step(fluids, NULL, NULL, &searched));
        CHECK(searched.status == THURIBLE_STATUS_NOT_READY);
        IS(thurible_fluids_set_keyframe(fluids, 0, target, bytes_of, NULL), NO_SOURCE);
        IS(thurible_fluids_set_source(fluids, source, bytes_of - number), LENGTH);
        SAYS(thurible_fluids_message, fluids, "values where");
        OK(thurible_fluids_set_source(fluids, source, bytes_of));
        double factor = 0.0;
        IS(thurible_fluids_set_keyframe(fluids, 1, target, bytes_of, NULL), INDEX);
        OK(thurible_fluids_set_keyframe(fluids, 0, target, bytes_of, &factor));
        CHECK(fabs(factor - 1.0) < 0.05);
        IS(thurible_fluids_set_initial_velocity(fluids, 0, source, bytes_of), INDEX);
        OK(thurible_fluids_step(fluids, NULL, NULL, &first));
        CHECK(first.status == THURIBLE_STATUS_GOES && first.repeated == repeated);
        if (!whole) fluids = elsewhere(fluids, scene, config, &memory);
        if (whole) {
            OK(thurible_fluids_solve(fluids, NULL, NULL, &searched));
        } else {
            do OK(thurible_fluids_step(fluids, NULL, NULL, &searched));
            while (searched.status == THURIBLE_STATUS_GOES);
        }
        CHECK(searched.status == THURIBLE_STATUS_CONVERGED || searched.status == THURIBLE_STATUS_MAX_ITERATIONS);
        objective[whole] = searched.data + searched.force + searched.initial;
        CHECK(objective[whole] < 0.5 * (first.data + first.force + first.initial));
        CHECK((searched.initial > 0.0) == (controls == THURIBLE_CONTROL_INITIAL_VELOCITY));
        CHECK((searched.force > 0.0) == (controls != THURIBLE_CONTROL_INITIAL_VELOCITY));
        ThuribleSteps states, forces;
        memset(&states, 0, sizeof states), memset(&forces, 0, sizeof forces);
        states.density = last, states.density_bytes = 7 * bytes_of;
        states.vector[0] = velocity, states.vector_bytes[0] = 7 * bytes_of;
        forces.vector[0] = force, forces.vector_bytes[0] = 6 * bytes_of;
        ThuribleStatus status;
        OK(thurible_fluids_replay(fluids, NULL, NULL, &states, &forces, &status));
        CHECK(status == THURIBLE_STATUS_CONVERGED);
        double mass = 0.0, moment = 0.0, fastest = 0.0, strongest = 0.0;
        for (size_t cell = 0; cell < cells; cell++) {
            mass += get(last, number, 6 * cells + cell), moment += get(last, number, 6 * cells + cell) * (double)(cell % SIDE);
            fastest = fmax(fastest, fabs(get(velocity, number, cell)));
            for (size_t step = 0; step < 6; step++) strongest = fmax(strongest, fabs(get(force, number, step * cells + cell)));
            CHECK(get(last, number, cell) == get(source, number, cell));
        }
        CHECK(moment / mass > 7.5);
        CHECK((fastest > 0.0) == (controls == THURIBLE_CONTROL_INITIAL_VELOCITY));
        CHECK((strongest > 0.0) == (controls != THURIBLE_CONTROL_INITIAL_VELOCITY));
        size_t count = 0;
        OK(thurible_fluids_unknowns(fluids, &count, NULL, 0));
        /* Of the wind: 2 amplitudes in each of 2 intervals, its middle and its radius. */
        CHECK(count == (controls == THURIBLE_CONTROL_TEMPLATES ? 4 + 3 : 2 * cells * (controls == THURIBLE_CONTROL_FORCES ? 6 : 1)));
        void *unknowns = aligned(count * number);
        IS(thurible_fluids_unknowns(fluids, NULL, unknowns, count * number + number), LENGTH);
        OK(thurible_fluids_unknowns(fluids, NULL, unknowns, count * number));
        CHECK(get(unknowns, number, 0) != 0.0);
        free(unknowns);
        if (controls == THURIBLE_CONTROL_TEMPLATES) {
            ThuribleTemplate found;
            double amplitude[3] = {0.0, 0.0, 0.0};
            OK(thurible_fluids_template(fluids, 0, &found));
            CHECK(found.amplitude[0] > 0.0 && found.radius != wind.radius);
            OK(thurible_fluids_template_amplitude(fluids, 0, 2, amplitude));
            CHECK(amplitude[0] == found.amplitude[0]);
            OK(thurible_fluids_template_amplitude(fluids, 0, 3, amplitude));
            CHECK(amplitude[0] != found.amplitude[0]);
            IS(thurible_fluids_template_amplitude(fluids, 0, 6, amplitude), INDEX);
        } else {
            ThuribleTemplate found;
            IS(thurible_fluids_template(fluids, 0, &found), INDEX);
        }
        int heard = 0;
        const ThuribleObserver observer = {stop, &heard};
        OK(thurible_fluids_replay(fluids, NULL, &observer, &states, NULL, &status));
        CHECK(status == THURIBLE_STATUS_CANCELLED);
        OK(thurible_fluids_close(fluids));
        IS(thurible_fluids_step(fluids, NULL, NULL, NULL), NO_INSTANCE);
        free(memory);
    }
    CHECK(objective[0] == objective[1]);
    free(source), free(target), free(last), free(velocity), free(force);
}

static void search_refusals(void) {
    const size_t keyframe = 1;
    ThuribleConfig scene;
    ThuribleFluidsConfig config;
    OK(thurible_defaults(&scene, sizeof scene));
    OK(thurible_fluids_defaults(&config, sizeof config));
    scene.cells[0] = scene.cells[1] = SIDE;
    scene.steps = 6;
    scene.keyframes = &keyframe;
    scene.keyframe_count = 1;
    OK(thurible_fluids_plan(&scene, &config, NULL, NULL, NULL, NULL));
    CHECK(thurible_fluids_explain(&scene, &config, text, sizeof text) == 0);
    const struct {
        const char *words;
        uint32_t *field, given;
    } wrong[] = {
        {"controls is 8", &config.controls, 8},
        {"reserved is 1", &config.reserved, 1},
        {"pressure is 2", &config.pressure, 2},
        {"adjoint is 9", &config.adjoint, 9},
        {"second", &config.adjoint, THURIBLE_ADJOINT_SECOND_SOLVE},
        {"initial_velocity is 2", &config.initial_velocity, 2},
        {"slots", &config.slots, 7},
        {"iterations", &config.iterations, 0},
        {"history", &config.history, 0},
        {"template", &config.controls, THURIBLE_CONTROL_TEMPLATES},
        {"precision is 5", &scene.precision, 5},
        {"solid cells", &scene.solids, 1},
        {"sticks", &scene.no_slip, 1},
    };
    for (size_t index = 0; index < sizeof wrong / sizeof wrong[0]; index++) {
        const uint32_t kept = *wrong[index].field;
        *wrong[index].field = wrong[index].given;
        IS(thurible_fluids_plan(&scene, &config, NULL, NULL, NULL, NULL), CONFIG);
        const size_t written = thurible_fluids_explain(&scene, &config, text, sizeof text);
        says(__LINE__, written, written, wrong[index].words);
        *wrong[index].field = kept;
    }
    scene.memory_ceiling = 1000;
    IS(thurible_fluids_plan(&scene, &config, NULL, NULL, NULL, NULL), CONFIG);
    scene.memory_ceiling = 0;
    config.size = 8;
    IS(thurible_fluids_plan(&scene, &config, NULL, NULL, NULL, NULL), CONFIG_SIZE);
    IS(thurible_fluids_plan(&scene, NULL, NULL, NULL, NULL, NULL), NULL);
    IS(thurible_fluids_defaults(NULL, sizeof config), NULL);
    IS(thurible_fluids_defaults(&config, 8), CONFIG_SIZE);
}

int main(void) {
    for (uint32_t simulator = THURIBLE_SIMULATOR_IMPLICIT; simulator <= THURIBLE_SIMULATOR_STABLE_FLUIDS; simulator++)
        for (uint32_t dimensions = 2; dimensions <= 3; dimensions++) {
            Work work;
            make(&work, simulator, THURIBLE_PRECISION_F64, dimensions);
            taylor(&work);
            same_bits(&work);
            drop(&work);
            make(&work, simulator, THURIBLE_PRECISION_F32, dimensions);
            same_bits(&work);
            refusals(&work);
            free(work.memory);
            for (size_t part = 0; part < PARTS; part++) {
                free(work.start[part]), free(work.force[part]), free(work.states[part]), free(work.covector[part]);
                free(work.by_start[part]), free(work.by_force[part]);
            }
            free(work.shape), free(work.by_shape);
        }
    gradient_alone();
    ceilings(THURIBLE_SIMULATOR_IMPLICIT);
    ceilings(THURIBLE_SIMULATOR_STABLE_FLUIDS);
    for (uint32_t controls = 1; controls <= 4; controls *= 2) {
        searches(THURIBLE_PRECISION_F32, controls);
        searches(THURIBLE_PRECISION_F64, controls);
    }
    search_refusals();
    if (failures) fprintf(stderr, "%d checks failed\n", failures);
    return failures != 0;
}

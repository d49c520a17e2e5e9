/* Elastic bodies: the counts and energies of a second program, memory to the byte, lists that are copied, every refusal. */
#include "check.h"

#define MOST 4096

typedef struct {
    ThuribleCondenseConfig config;
    double rest[3 * MOST];
    uint32_t elements[32 * MOST];
    uint8_t held[MOST];
    ThuribleSpring spring;
    size_t sides[3];
    void *memory, *scratch;
    size_t bytes, scratch_bytes;
    ThuribleCondenser *handle;
    double shift[3 * MOST], found[3 * MOST];
} Body;

static size_t numbers(const Body *body) { return body->config.vertex_count * body->config.dimensions; }

static size_t vertex(const Body *body, const size_t *at) { return (at[2] * body->sides[1] + at[1]) * body->sides[0] + at[0]; }

static void add(Body *body, const size_t *low, const int steps[][3], size_t corners) {
    for (size_t corner = 0; corner < corners; corner++) {
        const size_t at[3] = {low[0] + (size_t)steps[corner][0], low[1] + (size_t)steps[corner][1], low[2] + (size_t)steps[corner][2]};
        body->elements[body->config.element_count * corners + corner] = (uint32_t)vertex(body, at);
    }
    body->config.element_count++;
}

/* A rod, a rectangle or a box of so many cells along each axis and side 1, held where x is 0, and where it is 1 if `both`. */
static void shape(Body *body, uint32_t dimensions, size_t cells, int both) {
    static const int line[2][3] = {{0, 0, 0}, {1, 0, 0}};
    static const int squares[4][3][3] = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
    static const int ways[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
    memset(body, 0, sizeof *body);
    OK(thurible_condense_defaults(&body->config, sizeof body->config));
    ThuribleCondenseConfig *config = &body->config;
    config->dimensions = dimensions;
    for (uint32_t axis = 0; axis < 3; axis++) {
        body->sides[axis] = axis < dimensions ? cells + 1 : 1;
        config->regular[axis] = axis < dimensions ? cells + 1 : 0;
    }
    config->vertex_count = body->sides[0] * body->sides[1] * body->sides[2];
    for (size_t at = 0; at < config->vertex_count; at++) {
        const size_t place[3] = {at % body->sides[0], at / body->sides[0] % body->sides[1], at / (body->sides[0] * body->sides[1])};
        for (uint32_t axis = 0; axis < dimensions; axis++) body->rest[at * dimensions + axis] = (double)place[axis] / (double)cells;
        body->held[at] = place[0] == 0 || (both && place[0] == cells);
    }
    for (size_t z = 0; z < (dimensions > 2 ? cells : 1); z++)
        for (size_t y = 0; y < (dimensions > 1 ? cells : 1); y++)
            for (size_t x = 0; x < cells; x++) {
                const size_t low[3] = {x, y, z};
                if (dimensions == 1) add(body, low, line, 2);
                else if (dimensions == 2)
                    for (int kind = 0; kind < 2; kind++) add(body, low, squares[2 * ((x + y) % 2) + (size_t)kind], 3);
                else
                    for (int kind = 0; kind < 6; kind++) {
                        int steps[4][3] = {{0}};
                        for (int place = 0; place < 3; place++)
                            for (int corner = place + 1; corner < 4; corner++) steps[corner][ways[kind][place]] = 1;
                        if (kind >= 3)
                            for (int axis = 0; axis < 3; axis++) {
                                const int other = steps[1][axis];
                                steps[1][axis] = steps[2][axis], steps[2][axis] = other;
                            }
                        add(body, low, steps, 4);
                    }
            }
    config->rest = body->rest, config->held = body->held, config->elements = body->elements;
}

/* Plans and makes it, in exactly as many bytes as were planned. */
static void begin(Body *body) {
    size_t alignment = 0;
    OK(thurible_condense_scratch(&body->config, &body->scratch_bytes));
    body->scratch = aligned(body->scratch_bytes);
    OK(thurible_condense_plan(&body->config, body->scratch, body->scratch_bytes, &body->bytes, &alignment));
    CHECK(alignment == 64);
    body->memory = aligned(body->bytes);
    ThuribleCondenser *none = (ThuribleCondenser *)body;
    IS(thurible_condense_init(body->memory, body->bytes - 1, &body->config, &none), TOO_SMALL);
    CHECK(none == NULL);
    OK(thurible_condense_init(body->memory, body->bytes, &body->config, &body->handle));
}

static void end(Body *body) {
    OK(thurible_condense_close(body->handle));
    IS(thurible_condense_close(body->handle), NO_INSTANCE);
    free(body->memory), free(body->scratch);
}

/* What the right end moves by. */
static void pull(Body *body, double by) {
    for (size_t at = 0; at < body->config.vertex_count; at++) {
        const size_t first = at * body->config.dimensions;
        body->shift[first] = body->held[at] && body->rest[first] == 1.0 ? by : 0.0;
    }
}

static ThuribleIteration states[12000];

static ThuribleCondensed step(Body *body, const ThuribleExecutor *executor, const double *gravity) {
    ThuribleCondensed stepped;
    memset(states, 0xA5, sizeof states);
    OK(thurible_condense_step(body->handle, executor, NULL, body->shift, numbers(body) * 8, gravity, states, 12000, &stepped));
    CHECK(stepped.told == stepped.iterations + 1 && states[0].iteration == 0 && states[0].length == 0.0);
    return stepped;
}

static int near(size_t found, size_t expected) {
    const double most = expected < 20 ? 1.0 : 0.05 * (double)expected;
    return fabs((double)found - (double)expected) <= most;
}

/* Iterations of a rod of 100 nodes after an impulse (condensation_iterations.json). */
static void rods(Body *body) {
    static const struct { uint32_t method, order; size_t counts[3]; } rows[] = {
        {THURIBLE_CONDENSE_METHOD_NEWTON, THURIBLE_CONDENSE_ORDER_JACOBI, {1, 1, 1}},
        {THURIBLE_CONDENSE_METHOD_CC, THURIBLE_CONDENSE_ORDER_JACOBI, {1, 1, 1}},
        {THURIBLE_CONDENSE_METHOD_PLAIN, THURIBLE_CONDENSE_ORDER_JACOBI, {46, 368, 3279}},
        {THURIBLE_CONDENSE_METHOD_PLAIN, THURIBLE_CONDENSE_ORDER_COLOURS, {24, 185, 1640}},
        {THURIBLE_CONDENSE_METHOD_JGS2_LOCAL, THURIBLE_CONDENSE_ORDER_COLOURS, {45, 467, 0}},
        {THURIBLE_CONDENSE_METHOD_JGS2, THURIBLE_CONDENSE_ORDER_COLOURS, {32, 183, 0}},
    };
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++)
        for (size_t column = 0; column < 3 && rows[row].counts[column]; column++) {
            shape(body, 1, 100, 0);
            body->config.method = rows[row].method, body->config.order = rows[row].order;
            body->config.young = pow(10.0, 2.0 + (double)column);
            body->config.dt = 0.04, body->config.cap = 10000, body->config.search = 0;
            begin(body);
            body->shift[100] = 1.0 / (1000.0 * 0.01 * 0.01 / 2.0);
            OK(thurible_condense_set_velocity(body->handle, body->shift, 101 * 8));
            body->shift[100] = 0.0;
            const ThuribleCondensed stepped = step(body, NULL, NULL);
            CHECK(stepped.status == THURIBLE_STATUS_CONVERGED && near(stepped.iterations, rows[row].counts[column]));
            if (!near(stepped.iterations, rows[row].counts[column])) fprintf(stderr, "row %zu, column %zu: %zu\n", row, column, stepped.iterations);
            end(body);
        }
}

/* Iterations of three steps of a square that is stretched, and the energy at the end (the same file). */
static void squares(Body *body) {
    static const struct { uint32_t method; size_t cells, counts[3]; double energy, tolerance; } rows[] = {
        {THURIBLE_CONDENSE_METHOD_NEWTON, 4, {3, 3, 3}, 5387.930238538486, 1e-8},
        {THURIBLE_CONDENSE_METHOD_NEWTON, 8, {5, 4, 4}, 5153.283641958985, 1e-8},
        {THURIBLE_CONDENSE_METHOD_CC, 4, {5, 5, 7}, 5387.930239926218, 1e-6},
        {THURIBLE_CONDENSE_METHOD_CC, 8, {6, 6, 7}, 5153.283857255449, 1e-6},
        {THURIBLE_CONDENSE_METHOD_JGS2, 4, {69, 69, 68}, 5387.930242420058, 1e-6},
        {THURIBLE_CONDENSE_METHOD_JGS2, 8, {98, 93, 90}, 5153.283679937112, 1e-6},
        {THURIBLE_CONDENSE_METHOD_PLAIN, 4, {52, 47, 46}, 5387.930282416572, 1e-6},
        {THURIBLE_CONDENSE_METHOD_PLAIN, 8, {180, 172, 178}, 5153.284684524024, 1e-6},
        {THURIBLE_CONDENSE_METHOD_CHORD, 4, {7, 9, 11}, 5387.930247969751, 1e-6},
        {THURIBLE_CONDENSE_METHOD_CHORD, 8, {7, 8, 10}, 5153.283790137756, 1e-6},
    };
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
        shape(body, 2, rows[row].cells, 1);
        body->config.method = rows[row].method;
        begin(body);
        pull(body, 0.1);
        double energy = 0.0;
        for (size_t which = 0; which < 3; which++) {
            const ThuribleCondensed stepped = step(body, NULL, NULL);
            CHECK(stepped.status == THURIBLE_STATUS_CONVERGED && near(stepped.iterations, rows[row].counts[which]));
            energy = states[stepped.iterations].energy;
        }
        CHECK(fabs(energy - rows[row].energy) < rows[row].tolerance * rows[row].energy);
        end(body);
    }
}

/* Runs tasks from the last to the first. */
static void backwards(void *context, size_t tasks, ThuribleTask task, void *argument) {
    (void)context;
    while (tasks > 0) task(argument, --tasks);
}

/* A box goes where Newton's method goes, in either precision; threads change no bit, nor do lists that the caller has changed since. */
static void boxes(Body *body) {
    const double gravity[3] = {0.0, 0.0, -2.0};
    const ThuribleExecutor executor = {2, backwards, NULL};
    double energies[3] = {0.0}, *before = (double *)aligned(sizeof body->found);
    const uint32_t methods[3] = {THURIBLE_CONDENSE_METHOD_NEWTON, THURIBLE_CONDENSE_METHOD_CC, THURIBLE_CONDENSE_METHOD_CC};
    for (int which = 0; which < 3; which++) {
        shape(body, 3, 3, 1);
        body->config.method = methods[which];
        body->config.precision = which == 2 ? THURIBLE_PRECISION_F32 : THURIBLE_PRECISION_F64;
        for (size_t threads = 1; threads < 3; threads++) {
            body->config.threads = threads;
            begin(body);
            pull(body, 0.1);
            const ThuribleCondensed stepped = step(body, threads > 1 ? &executor : NULL, gravity);
            CHECK(stepped.status == THURIBLE_STATUS_CONVERGED && stepped.builds == (which > 0));
            energies[which] = states[stepped.iterations].energy;
            OK(thurible_condense_read(body->handle, THURIBLE_CONDENSE_PART_POSITION, body->found, numbers(body) * 8));
            if (threads > 1) CHECK(memcmp(before, body->found, numbers(body) * 8) == 0);
            memcpy(before, body->found, numbers(body) * 8);
            end(body);
        }
        begin(body);
        memset(body->elements, 0xFF, sizeof body->elements);
        const double first = body->rest[0];
        body->rest[0] = NAN;
        step(body, NULL, gravity);
        OK(thurible_condense_read(body->handle, THURIBLE_CONDENSE_PART_POSITION, body->found, numbers(body) * 8));
        CHECK(memcmp(before, body->found, numbers(body) * 8) == 0);
        /* The displacement is what the position is from rest, and the gradient is small where the body is free, and 0 where it is held. */
        body->rest[0] = first;
        memcpy(before, body->found, numbers(body) * 8);
        OK(thurible_condense_read(body->handle, THURIBLE_CONDENSE_PART_DISPLACEMENT, body->found, numbers(body) * 8));
        for (size_t at = 0; at < numbers(body); at++) CHECK(fabs(body->rest[at] + body->found[at] - before[at]) < 1e-12);
        OK(thurible_condense_read(body->handle, THURIBLE_CONDENSE_PART_GRADIENT, body->found, numbers(body) * 8));
        for (size_t at = 0; at < numbers(body); at++) CHECK(body->held[at / 3] ? body->found[at] == 0.0 : fabs(body->found[at]) < 10.0);
        OK(thurible_condense_read(body->handle, THURIBLE_CONDENSE_PART_DIRECTION, body->found, numbers(body) * 8));
        end(body);
    }
    CHECK(fabs(energies[1] - energies[0]) < 1e-6 * fabs(energies[0]) && fabs(energies[2] - energies[0]) < 1e-4 * fabs(energies[0]));
    free(before);
}

static int32_t stops(void *context, const ThuribleEvent *event) {
    size_t *left = (size_t *)context;
    (void)event;
    if (*left == 0) return 1;
    --*left;
    return 0;
}

static void refused(Body *body, ThuribleResult result, const char *words) {
    ThuribleCondenser *handle = NULL;
    size_t bytes = 0;
    check_result(__LINE__, words, thurible_condense_plan(&body->config, body->scratch, body->scratch_bytes, &bytes, NULL), result);
    check_result(__LINE__, words, thurible_condense_init(body->memory, body->bytes, &body->config, &handle), result);
    const size_t counted = thurible_condense_explain(&body->config, body->scratch, body->scratch_bytes, NULL, 0);
    says(__LINE__, counted, thurible_condense_explain(&body->config, body->scratch, body->scratch_bytes, text, sizeof text), words);
    CHECK(handle == NULL);
}

static void refusals(Body *body) {
    shape(body, 2, 4, 1);
    body->spring.ends[0] = 7, body->spring.ends[1] = 8;
    body->spring.stiffness = 2.0, body->spring.rest_length = 0.3, body->spring.in_basis = 1;
    body->config.springs = &body->spring, body->config.spring_count = 1;
    begin(body);
    pull(body, 0.1);
    const ThuribleCondenseConfig good = body->config;
#define REFUSED(change, result, words) do { change; refused(body, THURIBLE_RESULT_##result, words); body->config = good; } while (0)
    REFUSED(body->config.size = 8, CONFIG_SIZE, "size");
    REFUSED(body->config.precision = 5, CONFIG, "precision is 5");
    REFUSED(body->config.dimensions = 4, CONFIG, "dimensions is 4");
    REFUSED(body->config.method = 8, CONFIG, "method is 8");
    REFUSED(body->config.basis = 6, CONFIG, "basis is 6");
    REFUSED(body->config.block = 2, CONFIG, "block is 2");
    REFUSED(body->config.order = 2, CONFIG, "order is 2");
    REFUSED(body->config.search = 2, CONFIG, "search is 2");
    REFUSED(body->config.order = THURIBLE_CONDENSE_ORDER_COLOURS, CONFIG, "order \"colours\"");
    REFUSED(body->config.method = THURIBLE_CONDENSE_METHOD_PLAIN; body->config.basis = THURIBLE_CONDENSE_BASIS_REBUILT, CONFIG, "has no basis");
    REFUSED(body->config.young = 0.0, CONFIG, "`young` must be above 0");
    REFUSED(body->config.poisson = 0.5, CONFIG, "`poisson`");
    REFUSED(body->config.tolerance = NAN, CONFIG, "`tolerance`");
    REFUSED(body->config.cap = 0, CONFIG, "`cap`");
    REFUSED(body->config.rebuild = 0, CONFIG, "`rebuild`");
    REFUSED(body->config.dt = -1.0, CONFIG, "`dt`");
    REFUSED(body->config.threads = 0, CONFIG, "`threads`");
    REFUSED(body->config.rest = NULL, CONFIG, "rest is null");
    REFUSED(body->config.held = NULL, CONFIG, "held is null");
    REFUSED(body->config.elements = NULL, CONFIG, "elements is null");
    REFUSED(body->config.springs = NULL, CONFIG, "springs is null");
    REFUSED(body->config.vertex_count = THURIBLE_MOST_VERTICES + 1, CONFIG, "vertex_count is");
    REFUSED(body->config.element_count = SIZE_MAX, CONFIG, "element_count is");
    REFUSED(body->config.spring_count = SIZE_MAX, CONFIG, "spring_count is");
#define CHANGED(place, value, words) do { const double old = (double)(place); place = value; refused(body, THURIBLE_RESULT_CONFIG, words); place = old; } while (0)
    CHANGED(body->rest[3], NAN, "vertex 1 is at no finite place");
    CHANGED(body->rest[12], -4.0, "inverted");
    body->elements[4] = 25, refused(body, THURIBLE_RESULT_CONFIG, "element 1 names"), body->elements[4] = 6;
    body->held[3] = 2, refused(body, THURIBLE_RESULT_CONFIG, "held is 2"), body->held[3] = 0;
    body->spring.in_basis = 2, refused(body, THURIBLE_RESULT_CONFIG, "in_basis is 2"), body->spring.in_basis = 1;
    body->spring.reserved = 1, refused(body, THURIBLE_RESULT_CONFIG, "reserved is 1"), body->spring.reserved = 0;
    body->spring.ends[0] = 8, refused(body, THURIBLE_RESULT_CONFIG, "spring 0"), body->spring.ends[0] = 7;
    uint8_t held[25];
    memcpy(held, body->held, 25);
    memset(body->held, 1, 25), refused(body, THURIBLE_RESULT_CONFIG, "no vertex is free");
    memset(body->held, 0, 25), refused(body, THURIBLE_RESULT_CONFIG, "must hold a vertex");
    memcpy(body->held, held, 25);
    /* Of memory. */
    size_t bytes = 0;
    ThuribleCondenser *handle = NULL;
    IS(thurible_condense_scratch(NULL, &bytes), NULL);
    IS(thurible_condense_plan(NULL, body->scratch, body->scratch_bytes, &bytes, NULL), NULL);
    IS(thurible_condense_plan(&good, NULL, body->scratch_bytes, &bytes, NULL), NULL);
    IS(thurible_condense_plan(&good, (char *)body->scratch + 4, body->scratch_bytes, &bytes, NULL), MISALIGNED);
    IS(thurible_condense_plan(&good, body->scratch, body->scratch_bytes - 1, &bytes, NULL), TOO_SMALL);
    IS(thurible_condense_init(NULL, body->bytes, &good, &handle), NULL);
    IS(thurible_condense_init((char *)body->memory + 8, body->bytes, &good, &handle), MISALIGNED);
    IS(thurible_condense_init(body->memory, 64, &good, &handle), TOO_SMALL);
    IS(thurible_condense_init(body->memory, SIZE_MAX, &good, &handle), TOO_LARGE);
    IS(thurible_condense_init(body->memory, body->bytes, &good, NULL), NULL);
    IS(thurible_condense_defaults(&body->config, 8), CONFIG_SIZE);
    IS(thurible_condense_defaults(NULL, sizeof good), NULL);
    end(body);
    /* Of a step, which then changes nothing. */
    body->config = good;
    begin(body);
    const size_t size = numbers(body) * 8;
    ThuribleCondensed stepped;
    memset(&stepped, 0, sizeof stepped);
    ThuribleCondenser *one = body->handle;
    const double fast[3] = {0.0, INFINITY, 0.0};
    const ThuribleExecutor many = {2, backwards, NULL};
    IS(thurible_condense_step(NULL, NULL, NULL, NULL, 0, NULL, NULL, 0, NULL), NULL);
    IS(thurible_condense_step(one, &many, NULL, NULL, 0, NULL, NULL, 0, NULL), EXECUTOR);
    IS(thurible_condense_step(one, NULL, NULL, body->shift, size - 8, NULL, NULL, 0, NULL), LENGTH);
    IS(thurible_condense_step(one, NULL, NULL, NULL, size, NULL, NULL, 0, NULL), NULL);
    IS(thurible_condense_step(one, NULL, NULL, (const double *)((const char *)body->shift + 4), size, NULL, NULL, 0, NULL), MISALIGNED);
    IS(thurible_condense_step(one, NULL, NULL, NULL, 0, fast, NULL, 0, NULL), NOT_FINITE);
    SAYS(thurible_condense_message, one, "not finite");
    body->shift[0] = NAN;
    IS(thurible_condense_step(one, NULL, NULL, body->shift, size, NULL, NULL, 0, NULL), NOT_FINITE);
    IS(thurible_condense_shift(one, body->shift, size), NOT_FINITE);
    body->shift[0] = 0.0;
    IS(thurible_condense_set_velocity(one, body->shift, size), CONFIG);
    IS(thurible_condense_set_velocity(one, NULL, 0), NULL);
    IS(thurible_condense_read(one, 4, body->found, size), INDEX);
    IS(thurible_condense_read(one, 0, body->found, size - 8), LENGTH);
    IS(thurible_condense_read(one, 0, NULL, size), NULL);
    OK(thurible_condense_read(one, THURIBLE_CONDENSE_PART_POSITION, body->found, size));
    CHECK(memcmp(body->found, body->rest, size) == 0);
    /* Stopped before a build it has changed nothing, and nobody was told. */
    for (size_t after = 0; after < 4; after++) {
        size_t left = after;
        const ThuribleObserver observer = {stops, &left};
        OK(thurible_condense_step(one, NULL, &observer, body->shift, size, NULL, states, 1, &stepped));
        CHECK(stepped.status == THURIBLE_STATUS_CANCELLED && (after > 0 || stepped.told == 0));
        OK(thurible_condense_read(one, THURIBLE_CONDENSE_PART_POSITION, body->found, size));
        CHECK(after > 0 || memcmp(body->found, body->rest, size) == 0);
    }
    OK(thurible_condense_shift(one, body->shift, size));
    OK(thurible_condense_shift(one, NULL, 0));
    OK(thurible_condense_step(one, NULL, NULL, NULL, 0, NULL, NULL, 0, NULL));
    ThuribleCondenser *moved = (ThuribleCondenser *)aligned(body->bytes);
    memcpy(moved, body->memory, body->bytes);
    IS(thurible_condense_step(moved, NULL, NULL, NULL, 0, NULL, NULL, 0, NULL), NO_INSTANCE);
    free(moved);
    end(body);
}

int main(void) {
    Body *body = (Body *)aligned(sizeof(Body));
    rods(body);
    squares(body);
    boxes(body);
    refusals(body);
    free(body);
    if (failures == 0) printf("condensation: all checks hold\n");
    return failures != 0;
}

/* Tracking and tomography through thurible.h, as C11 and as C++17, against answers that are known. Ends with 0 when every check holds. */
#include "check.h"

/* ---------------------------------------------------------------------------------------------------------------- tracking */

#define NX 32
#define NY 24
#define NZ 8

/* Waves on a ring, moved by so many cells, between 0 and 1. */
static void waves(void *frame, size_t number, uint32_t dimensions, double right, double up) {
    const double turn = 2.0 * 3.14159265358979323846;
    for (size_t cell = 0; cell < (size_t)(NX * NY) * (dimensions == 3 ? NZ : 1); cell++) {
        double x = turn * ((double)(cell % NX) + 0.5 - right) / NX, y = turn * ((double)(cell / NX % NY) + 0.5 - up) / NY;
        double z = dimensions == 3 ? turn * ((double)(cell / (NX * NY)) + 0.5) / NZ : 0.0;
        put(frame, number, cell, 0.5 + 0.12 * (sin(2 * x + 1) + sin(2 * y) + sin(3 * x - y + 0.3) + sin(x + 2 * y + z)));
    }
}

static size_t track_memory(const ThuribleTrackConfig *config) {
    size_t bytes = 0, alignment = 0;
    OK(thurible_track_plan(config, &bytes, &alignment));
    CHECK(alignment == 64 && bytes > 0);
    return bytes;
}

/* A motion of (1.25, -0.5) cells a frame, in lengths and times: the box is 2 long, a frame takes 0.1. */
static void tracks(uint32_t precision, uint32_t dimensions, uint32_t method) {
    ThuribleTrackConfig config;
    OK(thurible_track_defaults(&config, sizeof config, method));
    CHECK(config.size == sizeof config && config.levels == 3 && config.method == method);
    config.precision = precision;
    config.dimensions = dimensions;
    config.cells[0] = NX, config.cells[1] = NY, config.cells[2] = NZ;
    for (int axis = 0; axis < 3; axis++) config.boundary[axis] = THURIBLE_BOUNDARY_PERIODIC;
    config.length = 2.0;
    config.dt = 0.1;
    config.alpha = 1.0;
    config.beta = 0.0;
    config.independent = 1;
    config.iterations = 60;
    config.forces = 1;
    const size_t bytes = track_memory(&config), number = precision;
    const size_t cells = (size_t)(NX * NY) * (dimensions == 3 ? NZ : 1);
    void *memory = aligned(bytes), *frame = aligned(cells * number);
    ThuribleTracker *tracker = NULL;
    IS(thurible_track_init(memory, bytes - 1, &config, &tracker), TOO_SMALL);
    CHECK(tracker == NULL);
    OK(thurible_track_init(memory, bytes, &config, &tracker));
    size_t faces = 0;
    OK(thurible_track_faces(tracker, 1, &faces));
    CHECK(faces == cells * number);
    IS(thurible_track_faces(tracker, dimensions, &faces), INDEX);
    IS(thurible_track_density(tracker, frame, cells * number), NO_RESULT);
    waves(frame, number, dimensions, 0.0, 0.0);
    IS(thurible_track_give(tracker, NULL, frame, NULL, cells * number - number), LENGTH);
    SAYS(thurible_track_message, tracker, "values where");
    IS(thurible_track_give(tracker, NULL, frame, frame, cells * number), NO_EMISSION);
    OK(thurible_track_give(tracker, NULL, frame, NULL, cells * number));
    IS(thurible_track_set_initial_velocity(tracker, 0, frame, cells * number), LATE);
    ThuriblePair pair;
    IS(thurible_track_step(tracker, NULL, NULL, NULL, NULL, NULL, NULL, &pair), NO_FRAME);
    void *out[4][3];
    ThuribleFaces parts[4];
    memset(parts, 0, sizeof parts);
    for (int part = 0; part < 4; part++)
        for (uint32_t axis = 0; axis < dimensions; axis++) {
            out[part][axis] = aligned(faces);
            memset(out[part][axis], 0, faces);
            parts[part].values[axis] = out[part][axis];
            parts[part].bytes[axis] = faces;
        }
    for (int time = 1; time <= 2; time++) {
        waves(frame, number, dimensions, 1.25 * time, -0.5 * time);
        OK(thurible_track_give(tracker, NULL, frame, NULL, cells * number));
        parts[0].bytes[1] -= number;
        IS(thurible_track_step(tracker, NULL, NULL, &parts[0], &parts[1], &parts[2], &parts[3], &pair), LENGTH);
        parts[0].bytes[1] += number;
        OK(thurible_track_step(tracker, NULL, NULL, &parts[0], &parts[1], &parts[2], &parts[3], &pair));
        CHECK(pair.status == THURIBLE_STATUS_CONVERGED && pair.frame == (size_t)(time - 1));
        CHECK(pair.levels == 3 && pair.products[0] > 0 && pair.products[3] == 0);
        CHECK(pair.misfit < 0.02 * pair.misfit_predicted && pair.fastest > 1.0 && pair.fastest < 2.0);
        /* A cell a frame is 2 / 32 / 0.1. */
        const double unit = 2.0 / NX / 0.1, truth[3] = {1.25, -0.5, 0.0};
        double far = 0.0, apart = 0.0, pushed = 0.0;
        for (uint32_t axis = 0; axis < dimensions; axis++)
            for (size_t face = 0; face < cells; face++) {
                const double v = get(out[0][axis], number, face) / unit;
                far += (v - truth[axis]) * (v - truth[axis]);
                apart = fmax(apart, fabs(get(out[0][axis], number, face) - get(out[1][axis], number, face) - get(out[2][axis], number, face)));
                pushed = fmax(pushed, fabs(get(out[3][axis], number, face)));
            }
        far = sqrt(far / (double)cells) / hypot(1.25, 0.5);
        CHECK(far < 0.06); /* of the motion */
        CHECK(apart < 1e-5 * unit); /* velocity = predicted + correction */
        /* The first pair has no force, and one that goes on as it was a small one. */
        CHECK(time == 1 ? pushed == 0.0 : pushed > 0.0 && pushed < 0.2 * unit / 0.1);
    }
    OK(thurible_track_density(tracker, frame, cells * number));
    CHECK(pair.readvection < 0.05);
    IS(thurible_track_step(tracker, NULL, NULL, NULL, NULL, NULL, NULL, NULL), NO_FRAME);
    OK(thurible_track_close(tracker));
    IS(thurible_track_give(tracker, NULL, frame, NULL, cells * number), NO_INSTANCE);
    for (int part = 0; part < 4; part++)
        for (uint32_t axis = 0; axis < dimensions; axis++) free(out[part][axis]);
    free(frame);
    free(memory);
}

static int32_t stop(void *context, const ThuribleEvent *event) {
    (void)context, (void)event;
    return 1;
}

/* Smoke that rests while a blob of it is made; and what becomes of a pair that is stopped. */
static void emits(void) {
    double fastest[2] = {0.0, 0.0};
    static float frame[16 * 16], made[16 * 16];
    for (uint32_t emission = 0; emission < 2; emission++) {
        ThuribleTrackConfig config;
        OK(thurible_track_defaults(&config, sizeof config, THURIBLE_MINIMISER_DIRECT));
        config.cells[0] = config.cells[1] = 16;
        config.emission = emission;
        const size_t bytes = track_memory(&config);
        void *memory = aligned(bytes);
        ThuribleTracker *tracker = NULL;
        OK(thurible_track_init(memory, bytes, &config, &tracker));
        for (int time = 0; time < 3; time++) {
            for (int cell = 0; cell < 256; cell++) {
                const float x = (float)(cell % 16) - 7.0f, y = (float)(cell / 16) - 6.0f;
                made[cell] = 0.2f * expf(-(x * x + y * y) / 6.0f);
                frame[cell] = 0.3f * expf(-x * x / 20.0f) + (float)time * made[cell];
            }
            if (emission && time == 1) {
                made[3] = -1.0f;
                IS(thurible_track_give(tracker, NULL, frame, made, sizeof frame), NEGATIVE);
                SAYS(thurible_track_message, tracker, "value 3 is negative");
                made[3] = 0.0f, frame[3] = (float)time * made[3] + frame[3];
            }
            OK(thurible_track_give(tracker, NULL, frame, emission && time ? made : NULL, sizeof frame));
            if (time == 0) continue;
            ThuriblePair pair;
            const ThuribleFaces unasked = {{NULL, NULL, NULL}, {0, 0, 0}};
            IS(thurible_track_step(tracker, NULL, NULL, NULL, NULL, NULL, &unasked, &pair), NO_RESULT);
            OK(thurible_track_step(tracker, NULL, NULL, NULL, NULL, NULL, NULL, &pair));
            fastest[emission] = fmax(fastest[emission], pair.fastest);
        }
        OK(thurible_track_give(tracker, NULL, frame, NULL, sizeof frame));
        const ThuribleObserver observer = {stop, NULL};
        ThuriblePair pair;
        OK(thurible_track_step(tracker, NULL, &observer, NULL, NULL, NULL, NULL, &pair));
        CHECK(pair.status == THURIBLE_STATUS_CANCELLED);
        IS(thurible_track_give(tracker, NULL, frame, NULL, sizeof frame), ENDED);
        IS(thurible_track_step(tracker, NULL, NULL, NULL, NULL, NULL, NULL, &pair), ENDED);
        OK(thurible_track_close(tracker));
        free(memory);
    }
    CHECK(fastest[0] > 0.05 && fastest[1] < 0.02 * fastest[0]);
}

static void track_refusals(void) {
    ThuribleTrackConfig config;
    IS(thurible_track_defaults(&config, sizeof config, 7), CONFIG);
    IS(thurible_track_defaults(NULL, sizeof config, 0), NULL);
    OK(thurible_track_defaults(&config, sizeof config, THURIBLE_MINIMISER_ADMM));
    CHECK(config.iterations == 5 && config.lambda == 1.0);
    config.cells[0] = config.cells[1] = 16;
    CHECK(thurible_track_explain(&config, text, sizeof text) == 0 && text[0] == 0);
    config.levels = 9;
    IS(thurible_track_plan(&config, NULL, NULL), CONFIG);
    thurible_track_explain(&config, text, sizeof text);
    CHECK(strstr(text, "track.levels"));
    config.levels = 3;
    config.boundary[1] = THURIBLE_BOUNDARY_OPEN;
    thurible_track_explain(&config, text, sizeof text);
    CHECK(strstr(text, "open"));
    config.boundary[1] = 9;
    thurible_track_explain(&config, text, sizeof text);
    CHECK(strstr(text, "boundary is 9"));
    config.boundary[1] = 0;
    config.predict = 3;
    thurible_track_explain(&config, text, sizeof text);
    CHECK(strstr(text, "predict is 3"));
    IS(thurible_track_give(NULL, NULL, NULL, NULL, 0), NULL);
}

/* -------------------------------------------------------------------------------------------------------------- tomography */

#define SIDE 48
#define WIDTH 70
#define VIEWS 12

/* A camera that looks along a direction of a plane. */
static ThuribleCamera turned(double angle) {
    ThuribleCamera camera;
    memset(&camera, 0, sizeof camera);
    camera.lens = THURIBLE_LENS_ORTHOGRAPHIC;
    camera.pixels[0] = WIDTH, camera.pixels[1] = 1;
    camera.pitch = 1.0;
    camera.across[0] = cos(angle), camera.across[1] = sin(angle);
    camera.forward[0] = -sin(angle), camera.forward[1] = cos(angle);
    camera.at[0] = 0.5 * WIDTH - 0.5 * SIDE * (cos(angle) + sin(angle));
    return camera;
}

/* A disc of density 1: how long the ray of a pixel is in it. */
static double chord(const ThuribleCamera *camera, int pixel) {
    const double x = 20.0, y = 27.0, radius = 11.0;
    double sum = 0.0;
    for (int part = 0; part < 8; part++) {
        double far = camera->across[0] * x + camera->across[1] * y + camera->at[0] - (pixel + (part + 0.5) / 8);
        sum += far * far < radius * radius ? 0.25 * sqrt(radius * radius - far * far) : 0.0;
    }
    return sum;
}

static void reconstructs(uint32_t precision, uint32_t method, uint32_t prior) {
    ThuribleCamera cameras[VIEWS], novel = turned(0.41);
    for (int view = 0; view < VIEWS; view++) cameras[view] = turned(3.14159265358979323846 * view / VIEWS);
    ThuribleTomographyConfig config;
    OK(thurible_tomography_defaults(&config, sizeof config));
    config.precision = precision;
    config.cells[0] = config.cells[1] = SIDE;
    config.cameras = cameras;
    config.camera_count = VIEWS;
    config.novel = &novel;
    config.novel_count = 1;
    config.method = method;
    config.prior = prior;
    config.budget = 400000;
    config.sweeps = 20;
    const int on_images = prior == THURIBLE_PRIOR_IMAGE_TV;
    if (on_images) config.volume = 0;
    size_t bytes = 0;
    OK(thurible_tomography_plan(&config, &bytes, NULL));
    void *memory = aligned(bytes), *picture = aligned(WIDTH * precision), *density = aligned(SIDE * SIDE * precision);
    ThuribleTomography *found = NULL;
    IS(thurible_tomography_init(memory, bytes - 1, &config, &found), TOO_SMALL);
    OK(thurible_tomography_init(memory, bytes, &config, &found));
    memset(cameras, 0, sizeof cameras); /* they were copied */
    for (int view = 0; view < VIEWS; view++) cameras[view] = turned(3.14159265358979323846 * view / VIEWS);
    IS(thurible_tomography_advance(found, 1, NULL), NO_FRAME);
    for (int view = 0; view < VIEWS; view++) {
        IS(thurible_tomography_begin(found, 0, 0), NO_FRAME);
        for (int pixel = 0; pixel < WIDTH; pixel++) put(picture, precision, pixel, chord(&cameras[view], pixel));
        if (view == 3) {
            put(picture, precision, 5, NAN);
            IS(thurible_tomography_measure(found, view, picture, WIDTH * precision), NOT_FINITE);
            SAYS(thurible_tomography_message, found, "camera 3 has a pixel (5)");
            put(picture, precision, 5, 0.0);
        }
        OK(thurible_tomography_measure(found, view, picture, WIDTH * precision));
    }
    IS(thurible_tomography_measure(found, VIEWS, picture, WIDTH * precision), INDEX);
    IS(thurible_tomography_measure(found, 0, picture, precision), LENGTH);
    IS(thurible_tomography_begin(found, 0, 1), NO_FRAME); /* nothing to begin with */
    OK(thurible_tomography_begin(found, 0, 0));
    ThuribleWalked walked;
    do OK(thurible_tomography_advance(found, 50000, &walked));
    while (walked.status == THURIBLE_STATUS_GOES);
    CHECK(walked.residual < 0.05 && walked.data > 0.0 && walked.mutations > 0 && walked.recorded <= walked.mutations);
    if (on_images) IS(thurible_tomography_density(found, density, SIDE * SIDE * precision), NO_RESULT);
    else {
        OK(thurible_tomography_density(found, density, SIDE * SIDE * precision));
        double far = 0.0;
        for (int cell = 0; cell < SIDE * SIDE; cell++) {
            double x = cell % SIDE + 0.5 - 20.0, y = cell / SIDE + 0.5 - 27.0;
            double truth = hypot(x, y) < 11.0;
            far += pow(get(density, precision, cell) - truth, 2);
        }
        CHECK(sqrt(far / (SIDE * SIDE)) < 0.09);
    }
    /* What a camera would see is what it saw; what a novel one would see are the chords of the disc. */
    double apart[2] = {0.0, 0.0}, size = 0.0;
    OK(thurible_tomography_picture(found, 7, picture, WIDTH * precision));
    for (int pixel = 0; pixel < WIDTH; pixel++) {
        apart[0] += pow(get(picture, precision, pixel) - chord(&cameras[7], pixel), 2);
        size += pow(chord(&cameras[7], pixel), 2);
    }
    OK(thurible_tomography_novel(found, 0, picture, WIDTH * precision));
    for (int pixel = 0; pixel < WIDTH; pixel++) apart[1] += pow(get(picture, precision, pixel) - chord(&novel, pixel), 2);
    CHECK(sqrt(apart[0] / size) < 0.05 && sqrt(apart[1] / size) < 0.08);
    IS(thurible_tomography_novel(found, 1, picture, WIDTH * precision), INDEX);
    IS(thurible_tomography_picture(found, VIEWS, picture, WIDTH * precision), INDEX);
    /* A picture of the next frame is none of this one's. */
    OK(thurible_tomography_measure(found, 0, picture, WIDTH * precision));
    IS(thurible_tomography_advance(found, 1, NULL), NO_FRAME);
    /* A dark frame. */
    memset(picture, 0, WIDTH * precision);
    for (int view = 0; view < VIEWS; view++) OK(thurible_tomography_measure(found, view, picture, WIDTH * precision));
    IS(thurible_tomography_begin(found, 1, 0), DARK);
    OK(thurible_tomography_close(found));
    IS(thurible_tomography_begin(found, 1, 0), NO_INSTANCE);
    free(density);
    free(picture);
    free(memory);
}

/* A box in 3D, seen by two parallel cameras: its bytes, and a uniform block of smoke. */
static void boxes(uint32_t precision) {
    ThuribleCamera cameras[2];
    memset(cameras, 0, sizeof cameras);
    for (int view = 0; view < 2; view++) {
        cameras[view].pixels[0] = cameras[view].pixels[1] = 10;
        cameras[view].pitch = 1.0;
        cameras[view].across[view == 0 ? 0 : 1] = 1.0;
        cameras[view].down[2] = -1.0;
        cameras[view].at[1] = 10.0;
        cameras[view].forward[view == 0 ? 1 : 0] = 1.0;
    }
    ThuribleTomographyConfig config;
    OK(thurible_tomography_defaults(&config, sizeof config));
    config.precision = precision;
    config.dimensions = 3;
    config.cells[0] = config.cells[1] = config.cells[2] = 10;
    config.cameras = cameras;
    config.camera_count = 2;
    config.gamma = 0.001;
    config.budget = 200000;
    size_t bytes = 0;
    OK(thurible_tomography_plan(&config, &bytes, NULL));
    void *memory = aligned(bytes), *picture = aligned(100 * precision), *density = aligned(1000 * precision);
    ThuribleTomography *found = NULL;
    OK(thurible_tomography_init(memory, bytes, &config, &found));
    for (int pixel = 0; pixel < 100; pixel++) put(picture, precision, pixel, pixel % 10 > 1 && pixel % 10 < 8 && pixel / 10 > 2 && pixel / 10 < 8 ? 6.0 : 0.0);
    for (int view = 0; view < 2; view++) OK(thurible_tomography_measure(found, view, picture, 100 * precision));
    OK(thurible_tomography_begin(found, 0, 0));
    ThuribleWalked walked;
    do OK(thurible_tomography_advance(found, 100000, &walked));
    while (walked.status == THURIBLE_STATUS_GOES);
    OK(thurible_tomography_density(found, density, 1000 * precision));
    double mass = 0.0, middle = 0.0;
    for (int cell = 0; cell < 1000; cell++) {
        const double value = get(density, precision, cell);
        const int x = cell % 10, y = cell / 10 % 10, z = cell / 100;
        mass += value;
        if (x > 2 && x < 7 && y > 2 && y < 7 && z > 2 && z < 6) middle += value / 48.0;
    }
    CHECK(fabs(mass / 180.0 - 1.0) < 0.05 && fabs(middle - 1.0) < 0.15);
    OK(thurible_tomography_close(found));
    free(density);
    free(picture);
    free(memory);
}

static void tomography_refusals(void) {
    ThuribleCamera camera = turned(0.3);
    ThuribleTomographyConfig config;
    IS(thurible_tomography_defaults(&config, 8), CONFIG_SIZE);
    OK(thurible_tomography_defaults(&config, sizeof config));
    config.cells[0] = config.cells[1] = SIDE;
    thurible_tomography_explain(&config, text, sizeof text);
    CHECK(strstr(text, "at least one camera"));
    config.camera_count = 1;
    thurible_tomography_explain(&config, text, sizeof text);
    CHECK(strstr(text, "cameras is null"));
    config.cameras = &camera;
    CHECK(thurible_tomography_explain(&config, text, sizeof text) == 0);
    config.camera_count = THURIBLE_MOST_CAMERAS + 1;
    thurible_tomography_explain(&config, text, sizeof text);
    CHECK(strstr(text, "camera_count is 65"));
    config.camera_count = 1;
    config.prior = THURIBLE_PRIOR_IMAGE_SAD;
    IS(thurible_tomography_plan(&config, NULL, NULL), CONFIG);
    thurible_tomography_explain(&config, text, sizeof text);
    CHECK(strstr(text, "novel view"));
    config.prior = 6;
    thurible_tomography_explain(&config, text, sizeof text);
    CHECK(strstr(text, "prior is 6"));
    config.prior = THURIBLE_PRIOR_SAD;
    config.sigma = 0.0;
    thurible_tomography_explain(&config, text, sizeof text);
    CHECK(strstr(text, "`sigma` must be above 0"));
    config.sigma = 0.07;
    camera.at[0] += 1000.0;
    thurible_tomography_explain(&config, text, sizeof text);
    CHECK(strstr(text, "camera 0 sees nothing of the box"));
    camera.lens = 2;
    thurible_tomography_explain(&config, text, sizeof text);
    CHECK(strstr(text, "camera.lens is 2"));
}

int main(void) {
    for (uint32_t method = THURIBLE_MINIMISER_DIRECT; method <= THURIBLE_MINIMISER_ADMM; method++) {
        tracks(THURIBLE_PRECISION_F32, 2, method);
        tracks(THURIBLE_PRECISION_F64, 2, method);
    }
    tracks(THURIBLE_PRECISION_F32, 3, THURIBLE_MINIMISER_DIRECT);
    tracks(THURIBLE_PRECISION_F64, 3, THURIBLE_MINIMISER_DIRECT);
    emits();
    track_refusals();
    reconstructs(THURIBLE_PRECISION_F32, THURIBLE_RECONSTRUCTOR_WALK, THURIBLE_PRIOR_SAD);
    reconstructs(THURIBLE_PRECISION_F64, THURIBLE_RECONSTRUCTOR_WALK, THURIBLE_PRIOR_TV);
    reconstructs(THURIBLE_PRECISION_F32, THURIBLE_RECONSTRUCTOR_SART, THURIBLE_PRIOR_NONE);
    reconstructs(THURIBLE_PRECISION_F64, THURIBLE_RECONSTRUCTOR_WALK, THURIBLE_PRIOR_IMAGE_TV);
    boxes(THURIBLE_PRECISION_F32);
    boxes(THURIBLE_PRECISION_F64);
    tomography_refusals();
    if (failures) fprintf(stderr, "%d checks failed\n", failures);
    return failures != 0;
}

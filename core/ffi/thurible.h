#ifndef THURIBLE_H
#define THURIBLE_H

/* Made by core/ffi/tools from the sources beside this file: change those. See docs/integrators.md. */

#include <stddef.h>
#include <stdint.h>

// The version of this library: major * 65536 + minor * 256 + patch.
#define THURIBLE_VERSION 256

// Emitters at most.
#define THURIBLE_MOST_EMITTERS 32

// Factors of a schedule at most.
#define THURIBLE_MOST_FACTORS 64

// What a number of the configuration holds to leave the choice to the library.
#define THURIBLE_AUTOMATIC UINT32_MAX

// Templates at most.
#define THURIBLE_MOST_TEMPLATES 16

// Bytes of a name in a structure, the zero byte at its end included.
#define THURIBLE_NAME_BYTES 32

// Bytes of a few words in a structure, likewise. What does not fit is cut.
#define THURIBLE_WORDS_BYTES 128

// Grids of a pyramid at most.
#define THURIBLE_MOST_LEVELS 8

// Cameras at most, and novel views at most.
#define THURIBLE_MOST_CAMERAS 64

// What a `ThuribleOnStep` returns where all of a step is 0.
#define THURIBLE_NOTHING 1

// `slots` of a configuration where nothing is kept for a way back: the flow alone, without gradients.
#define THURIBLE_NO_WAY_BACK (UINT32_MAX - 1)

// Vertices of a body at most,
#define THURIBLE_MOST_VERTICES (1 << 24)

// its simplices,
#define THURIBLE_MOST_ELEMENTS (1 << 25)

// and its springs.
#define THURIBLE_MOST_SPRINGS (1 << 24)

// What a call returns: 0, or why it was refused. What is refused changes nothing.
typedef enum {
    // The call did what it was asked to do.
    THURIBLE_RESULT_OK = 0,
    // A pointer that must not be null is.
    THURIBLE_RESULT_NULL = 1,
    // A pointer is not aligned for what it points to.
    THURIBLE_RESULT_MISALIGNED = 2,
    // The handle points to no instance: never made, closed, overwritten, or moved to another address.
    THURIBLE_RESULT_NO_INSTANCE = 3,
    // The instance is in another call: of another thread, or of the callback that made this one.
    THURIBLE_RESULT_BUSY = 4,
    // The size of the configuration is that of no version this library knows.
    THURIBLE_RESULT_CONFIG_SIZE = 5,
    // A field of the configuration is wrong; `thurible_explain` says which.
    THURIBLE_RESULT_CONFIG = 6,
    // The sizes do not fit this machine's addresses.
    THURIBLE_RESULT_TOO_LARGE = 7,
    // The memory has fewer bytes than planned.
    THURIBLE_RESULT_TOO_SMALL = 8,
    // An array has the wrong number of bytes.
    THURIBLE_RESULT_LENGTH = 9,
    // There is no such keyframe, emitter, axis, step, field, output or fact.
    THURIBLE_RESULT_INDEX = 10,
    // A value is NaN or infinite.
    THURIBLE_RESULT_NOT_FINITE = 11,
    // A density is negative.
    THURIBLE_RESULT_NEGATIVE = 12,
    // A density has no mass outside of solid cells.
    THURIBLE_RESULT_EMPTY = 13,
    // There is no smoke yet: the source must be set first, or an emitter that has begun.
    THURIBLE_RESULT_NO_SOURCE = 14,
    // A keyframe was not set.
    THURIBLE_RESULT_NO_KEYFRAME = 15,
    // There is no result: the solve was not finished, or went on since; an operator did not simulate or differentiate before.
    THURIBLE_RESULT_NO_RESULT = 16,
    // The executor has no function, no thread, or more threads than were planned for.
    THURIBLE_RESULT_EXECUTOR = 17,
    // The bytes are no saved instance.
    THURIBLE_RESULT_NOT_SAVED = 18,
    // The saved instance is in a format that this library does not read.
    THURIBLE_RESULT_SAVED_FORMAT = 19,
    // The saved instance is of another scene, precision, method or choice.
    THURIBLE_RESULT_SAVED_OTHER = 20,
    // The saved instance is damaged.
    THURIBLE_RESULT_SAVED_DAMAGED = 21,
    // A value of a region, or a flag of a solid cell, is above 1.
    THURIBLE_RESULT_ABOVE_ONE = 22,
    // The shape of an emitter must be set first.
    THURIBLE_RESULT_NO_EMITTER = 23,
    // All cells are solid.
    THURIBLE_RESULT_NO_FLUID = 24,
    // The flow that the method follows was not set.
    THURIBLE_RESULT_NO_REFERENCE = 25,
    // The library's fault: a refusal that this interface has no word for.
    THURIBLE_RESULT_UNKNOWN = 26,
    // A frame, or the picture of a camera, that this needs was not given or not begun.
    THURIBLE_RESULT_NO_FRAME = 27,
    // The tracker was stopped in a pair, or left the finite numbers there: begin another one.
    THURIBLE_RESULT_ENDED = 28,
    // It must be given before the first frame, solid cells before every density.
    THURIBLE_RESULT_LATE = 29,
    // All pictures are dark.
    THURIBLE_RESULT_DARK = 30,
    // What is made between frames was given where the configuration has no `emission`.
    THURIBLE_RESULT_NO_EMISSION = 31,
} ThuribleResult;

// What an event is about.
typedef enum {
    // An iteration begins: `iteration`.
    THURIBLE_EVENT_KIND_ITERATION = 0,
    // The advection problem of ADMM begins.
    THURIBLE_EVENT_KIND_AO_BEGIN = 1,
    // An iteration of it is over: `iteration` counts them from 1, `value` is its objective, `step` its blending step.
    THURIBLE_EVENT_KIND_AO_ITERATION = 2,
    // The advection problem of ADMM is over.
    THURIBLE_EVENT_KIND_AO_END = 3,
    // The Navier-Stokes problem of ADMM begins.
    THURIBLE_EVENT_KIND_NSO_BEGIN = 4,
    // A cycle of it is over: `iteration` counts them from 1, `value` is the residual.
    THURIBLE_EVENT_KIND_NSO_CYCLE = 5,
    // The Navier-Stokes problem of ADMM is over.
    THURIBLE_EVENT_KIND_NSO_END = 6,
    // A piece of work well below a second at ordinary sizes is over.
    THURIBLE_EVENT_KIND_WORK = 7,
} ThuribleEventKind;

// How a solve ended. Data, not an error.
typedef enum {
    // It did not end: there is more to do.
    THURIBLE_STATUS_GOES = 0,
    // The method's own rule says so.
    THURIBLE_STATUS_CONVERGED = 1,
    // The iterations were used up.
    THURIBLE_STATUS_MAX_ITERATIONS = 2,
    // It no longer moves, but does not satisfy the rule of convergence.
    THURIBLE_STATUS_STALLED = 3,
    // Of a step: nothing that it tries is finite, or slow enough to be transported, and finishing gives the last flow that was. Of a
    // finish or a solve: there is no such flow.
    THURIBLE_STATUS_NOT_FINITE = 4,
    // The observer said stop.
    THURIBLE_STATUS_CANCELLED = 5,
    // The source, a keyframe or the shape of an emitter is missing.
    THURIBLE_STATUS_NOT_READY = 6,
} ThuribleStatus;

// Where the elements of an output are.
typedef enum {
    // At the centres of cells: one component.
    THURIBLE_PLACE_CELLS = 0,
    // On the faces of cells: a component for each axis, on the faces across it.
    THURIBLE_PLACE_FACES = 1,
} ThuriblePlace;

// In what an output is measured, in the scene's units.
typedef enum {
    // As the source.
    THURIBLE_UNIT_DENSITY = 0,
    // Length / time.
    THURIBLE_UNIT_VELOCITY = 1,
    // Length / time^2.
    THURIBLE_UNIT_FORCE = 2,
} ThuribleUnit;

// What the values of a fact are.
typedef enum {
    // A number.
    THURIBLE_FACT_KIND_NUMBER = 0,
    // A whole number from 0.
    THURIBLE_FACT_KIND_COUNT = 1,
    // 1 for yes, 0 for no.
    THURIBLE_FACT_KIND_FLAG = 2,
    // Any number of numbers, in order.
    THURIBLE_FACT_KIND_SERIES = 3,
} ThuribleFactKind;

// Precision of all fields: bytes of an element.
typedef enum {
    // `float`, 4 bytes an element.
    THURIBLE_PRECISION_F32 = 4,
    // `double`, 8 bytes an element.
    THURIBLE_PRECISION_F64 = 8,
} ThuriblePrecision;

// How an axis ends.
typedef enum {
    // Walls at both ends: no flow through them, free slip along them unless the flow sticks.
    THURIBLE_BOUNDARY_WALL = 0,
    // Both ends are the same place: what leaves at one enters at the other.
    THURIBLE_BOUNDARY_PERIODIC = 1,
    // Both ends are open: the pressure outside is 0, smoke leaves, and none comes in.
    THURIBLE_BOUNDARY_OPEN = 2,
    // The low end is open, the high one a wall.
    THURIBLE_BOUNDARY_OPEN_LOW = 3,
    // The high end is open, the low one a wall.
    THURIBLE_BOUNDARY_OPEN_HIGH = 4,
} ThuribleBoundary;

// How density is carried.
typedef enum {
    // Third-order upwind interpolation to faces, mass preserving.
    THURIBLE_SCHEME_QUICK = 0,
    // Central interpolation to faces: the mean of both cells, mass preserving.
    THURIBLE_SCHEME_CENTRAL = 1,
    // Back-tracing with linear interpolation.
    THURIBLE_SCHEME_SEMI_LAGRANGIAN = 2,
    // Third-order upwind with a limiter: no density outside 0 .. max, mass preserving.
    THURIBLE_SCHEME_LIMITED = 3,
} ThuribleScheme;

// How a scene is solved.
typedef enum {
    // Force elimination and quasi-Newton.
    THURIBLE_METHOD_DIRECT = 0,
    // ADMM over an advection and a Navier-Stokes problem.
    THURIBLE_METHOD_ADMM = 1,
    // L-BFGS over the forces by the adjoint of a simulation.
    THURIBLE_METHOD_LBFGS = 2,
    // Smoke driven to the next keyframe while it is simulated.
    THURIBLE_METHOD_PD = 3,
    // No control: the flow alone. There may be no keyframes.
    THURIBLE_METHOD_SIMULATE = 4,
    // L-BFGS over the amplitudes, middles and radii of templates. There must be some.
    THURIBLE_METHOD_TEMPLATES = 5,
    // A simulation that is guided by the flow that `thurible_set_reference` gives. There may be no keyframes.
    THURIBLE_METHOD_GUIDE = 6,
} ThuribleMethod;

// How ADMM solves its Navier-Stokes problems.
typedef enum {
    // Multigrid in space and time.
    THURIBLE_NSO_SOLVER_STFAS = 0,
    // Newton's method with conjugate gradients.
    THURIBLE_NSO_SOLVER_NEWTON_CG = 1,
} ThuribleNsoSolver;

// In how many bytes the numbers of the pairs of L-BFGS are kept.
typedef enum {
    // In those of an element.
    THURIBLE_HISTORY_PRECISION_FULL = 0,
    // In half of them: bfloat16 for `float`, `float` for `double`.
    THURIBLE_HISTORY_PRECISION_HALF = 1,
} ThuribleHistoryPrecision;

// The colours of the smoother of STFAS.
typedef enum {
    // Two, by the parity of x + y (+ z).
    THURIBLE_COLOURS_RED_BLACK = 0,
    // 2^d, by the parity of each coordinate.
    THURIBLE_COLOURS_POWER_OF_TWO = 1,
} ThuribleColours;

// In which units divergences count in the residual of STFAS.
typedef enum {
    // As accelerations, in which the other equations are.
    THURIBLE_NORM_SCALED = 0,
    // In their own units, as in the paper.
    THURIBLE_NORM_PLAIN = 1,
} ThuribleNorm;

// A field of the result.
typedef enum {
    // Density at step 0 .. N, one element for each cell.
    THURIBLE_FIELD_DENSITY = 0,
    // The target of keyframe 0 .., in place of a step, as it was scaled.
    THURIBLE_FIELD_KEYFRAME = 1,
    // A component of the velocity at step 0 .. N-1.
    THURIBLE_FIELD_VELOCITY = 2,
    // A component of the force at step 0 .. N-2, which turns the velocity of that step into the next one.
    THURIBLE_FIELD_FORCE = 3,
    // The region of keyframe 0 .., in place of a step, where keyframes have regions.
    THURIBLE_FIELD_REGION = 4,
    // What emitters added to the density after step 0 .. N-1, where there are emitters. It lies nowhere, so that it cannot be viewed.
    THURIBLE_FIELD_EMISSION = 5,
    // A component of what emitters with a velocity added beside the force at step 0 .. N-2, where there are any. It lies nowhere either.
    THURIBLE_FIELD_EMITTER_FORCE = 6,
} ThuribleField;

// What a template does around its middle.
typedef enum {
    // Blows one way: an amplitude for each axis.
    THURIBLE_TEMPLATE_KIND_WIND = 0,
    // Turns: anticlockwise in 2D by one amplitude, in 3D around an axis by three.
    THURIBLE_TEMPLATE_KIND_VORTEX = 1,
    // Stirs by swirls that look random: one amplitude.
    THURIBLE_TEMPLATE_KIND_NOISE = 2,
    // Pulls smoke to its middle: one amplitude.
    THURIBLE_TEMPLATE_KIND_ATTRACT = 3,
} ThuribleTemplateKind;

// How the flow between two frames is found.
typedef enum {
    // Conjugate gradients among flows without divergence.
    THURIBLE_MINIMISER_DIRECT = 0,
    // The alternating direction method.
    THURIBLE_MINIMISER_ADMM = 1,
    // Horn & Schunck: flows may have divergence, perhaps at a price.
    THURIBLE_MINIMISER_HORN_SCHUNCK = 2,
} ThuribleMinimiser;

// How a frame is pulled back by a flow.
typedef enum {
    // Traced back and forth, with an error compensation that is limited.
    THURIBLE_WARPING_BFECC = 0,
    // The transport of densities, with the flow turned round.
    THURIBLE_WARPING_QUICK = 1,
} ThuribleWarping;

// How the flow of the next pair of frames is predicted.
typedef enum {
    // The implicit step of a simulation.
    THURIBLE_PREDICTION_IMPLICIT = 0,
    // The flow carried by itself, then projected.
    THURIBLE_PREDICTION_BFECC = 1,
    // The flow before, as it is.
    THURIBLE_PREDICTION_NONE = 2,
} ThuriblePrediction;

// How a camera sees.
typedef enum {
    // Parallel rays: u = across . x + at[0], v = down . x + at[1].
    THURIBLE_LENS_ORTHOGRAPHIC = 0,
    // Rays through an eye: u = across . (x - eye) / Z + at[0] with Z = forward . (x - eye), v alike.
    THURIBLE_LENS_PINHOLE = 1,
} ThuribleLens;

// How a frame is reconstructed.
typedef enum {
    // The random walk.
    THURIBLE_RECONSTRUCTOR_WALK = 0,
    // Simultaneous algebraic reconstruction, camera after camera.
    THURIBLE_RECONSTRUCTOR_SART = 1,
} ThuribleReconstructor;

// What is charged beside the distance from the pictures.
typedef enum {
    // Nothing.
    THURIBLE_PRIOR_NONE = 0,
    // Half the squares of the Laplacian.
    THURIBLE_PRIOR_L2 = 1,
    // The lengths of the forward differences.
    THURIBLE_PRIOR_TV = 2,
    // The absolute differences of all cells that touch.
    THURIBLE_PRIOR_SAD = 3,
    // `THURIBLE_PRIOR_TV` of the novel views.
    THURIBLE_PRIOR_IMAGE_TV = 4,
    // `THURIBLE_PRIOR_SAD` of the novel views.
    THURIBLE_PRIOR_IMAGE_SAD = 5,
} ThuriblePrior;

// When a chain records.
typedef enum {
    // Where it walks to.
    THURIBLE_WALK_PATIENT = 0,
    // Whatever has a gain.
    THURIBLE_WALK_EAGER = 1,
} ThuribleWalk;

// How Stable Fluids finds the pressure.
typedef enum {
    // By Gauss-Seidel sweeps.
    THURIBLE_PRESSURE_GAUSS_SEIDEL = 0,
    // By conjugate gradients.
    THURIBLE_PRESSURE_CG = 1,
} ThuriblePressure;

// What the adjoint of conjugate gradients is.
typedef enum {
    // That of the iterations that were done.
    THURIBLE_ADJOINT_EXACT = 0,
    // One more solve: right in the limit, in less memory.
    THURIBLE_ADJOINT_SECOND_SOLVE = 1,
} ThuribleAdjoint;

// What Stable Fluids searches for: `controls` is a sum of these.
typedef enum {
    // The velocity at the start.
    THURIBLE_CONTROL_INITIAL_VELOCITY = 1,
    // A force in every cell and step.
    THURIBLE_CONTROL_FORCES = 2,
    // Amplitudes of templates, and middles and radii of those that move.
    THURIBLE_CONTROL_TEMPLATES = 4,
} ThuribleControl;

// What simulates.
typedef enum {
    // The implicit solver on the staggered grid, with all that a scene may have.
    THURIBLE_SIMULATOR_IMPLICIT = 0,
    // Stable Fluids: everything at the centres of cells.
    THURIBLE_SIMULATOR_STABLE_FLUIDS = 1,
} ThuribleSimulator;

// How far a block moves in a pass of a condensation.
typedef enum {
    // Coordinate condensation.
    THURIBLE_CONDENSE_METHOD_CC = 0,
    // Newton's method.
    THURIBLE_CONDENSE_METHOD_NEWTON = 1,
    // Each vertex by its own Hessian: vertex block descent.
    THURIBLE_CONDENSE_METHOD_PLAIN = 2,
    // JGS2.
    THURIBLE_CONDENSE_METHOD_JGS2 = 3,
    // The same by the gradient of the block alone.
    THURIBLE_CONDENSE_METHOD_JGS2_LOCAL = 4,
    // The energy along the basis of each block.
    THURIBLE_CONDENSE_METHOD_PROJECTED = 5,
    // The Hessian of the build in the place of today's.
    THURIBLE_CONDENSE_METHOD_CHORD = 6,
    // The same, turned with the body.
    THURIBLE_CONDENSE_METHOD_WARPED = 7,
} ThuribleCondenseMethod;

// When the basis of a condensation is built, and whether it turns with the body.
typedef enum {
    // Once, at rest.
    THURIBLE_CONDENSE_BASIS_FIXED = 0,
    // Every few steps, from the state before.
    THURIBLE_CONDENSE_BASIS_REBUILT = 1,
    // Once, and turned.
    THURIBLE_CONDENSE_BASIS_COROTATED = 2,
    // Every few steps, and turned.
    THURIBLE_CONDENSE_BASIS_COROTATED_REBUILT = 3,
    // When four iterations have not halved the residual.
    THURIBLE_CONDENSE_BASIS_ADAPTIVE = 4,
    // The same, and turned.
    THURIBLE_CONDENSE_BASIS_COROTATED_ADAPTIVE = 5,
} ThuribleCondenseBasis;

// What a block of a condensation is.
typedef enum {
    // All components of a vertex.
    THURIBLE_CONDENSE_BLOCK_VERTEX = 0,
    // One component.
    THURIBLE_CONDENSE_BLOCK_SCALAR = 1,
} ThuribleCondenseBlock;

// Who moves when in a condensation.
typedef enum {
    // All at once.
    THURIBLE_CONDENSE_ORDER_JACOBI = 0,
    // Colour by colour.
    THURIBLE_CONDENSE_ORDER_COLOURS = 1,
} ThuribleCondenseOrder;

// What is read of every vertex.
typedef enum {
    // Where it is.
    THURIBLE_CONDENSE_PART_POSITION = 0,
    // How far it is from rest.
    THURIBLE_CONDENSE_PART_DISPLACEMENT = 1,
    // The gradient of the energy by it, when that was made last; 0 of a held one.
    THURIBLE_CONDENSE_PART_GRADIENT = 2,
    // How far it goes along the direction that was found last; 0 of a held one.
    THURIBLE_CONDENSE_PART_DIRECTION = 3,
} ThuribleCondensePart;

// A solve in memory of the caller: a handle, whose inside is the library's.
typedef struct Thurible Thurible;

// An elastic body whose energy is minimised step by step, in memory of the caller: a handle, whose inside is the library's.
typedef struct ThuribleCondenser ThuribleCondenser;

// A search by Stable Fluids, in memory of the caller: a handle, whose inside is the library's.
typedef struct ThuribleFluids ThuribleFluids;

// A simulation that can be differentiated, in memory of the caller: a handle, whose inside is the library's.
typedef struct ThuribleOperator ThuribleOperator;

// A box that is reconstructed frame by frame, in memory of the caller: a handle, whose inside is the library's.
typedef struct ThuribleTomography ThuribleTomography;

// Frames that are being tracked, in memory of the caller: a handle, whose inside is the library's.
typedef struct ThuribleTracker ThuribleTracker;

// Smoke that is made on the way from one step to another.
typedef struct {
    // The last step without it.
    size_t from;
    // The last step that it adds to, above `from` and at most N.
    size_t to;
    // Density that it adds at every step where its shape is 1, above 0; 0 where it has a target.
    double rate;
    // Density that it fills up to at every step where its shape is 1, above 0; 0 where it has a rate.
    double target;
    // The velocity that its smoke comes with along x, y and z, in lengths per time, where `pushes` is 1; z is ignored in 2D.
    double velocity[3];
    // Whether the flow in its shape is taken to `velocity` while it emits: 0 or 1.
    uint32_t pushes;
    // For later versions; must be 0.
    uint32_t reserved;
} ThuribleEmitter;

// What the price of the force is multiplied by at a step.
typedef struct {
    // The step.
    size_t step;
    // The factor, above 0.
    double factor;
} ThuribleFactor;

// Part of the force: an amplitude times a field of fixed form, which fades with the distance from its middle.
typedef struct {
    // A `ThuribleTemplateKind`.
    uint32_t kind;
    // Whether middle and radius are searched for too: 0 or 1.
    uint32_t moves;
    // The first force that it is part of: that which turns the velocity of step `from`.
    size_t from;
    // The first that it is no part of any more: after `from` and at most N.
    size_t to;
    // How many steps share an amplitude; 0 for one in all of them.
    size_t interval;
    // Its middle along x, y and z, inside the box; z is ignored in 2D.
    double center[3];
    // Its radius, above 0.
    double radius;
    // The amplitude that a search begins with and a simulation has, in lengths per squared time: as many numbers as the kind has.
    double amplitude[3];
    // Length of the waves of noise; 0 for the radius.
    double size;
    // Which noise.
    uint32_t seed;
    // For later versions; must be 0.
    uint32_t reserved;
} ThuribleTemplate;

// A scene without its densities, and the choices of the solve: begin with `thurible_defaults`, then set what is to differ. Fields
// that hold one of several codes are `uint32_t`, so that any number may arrive and be refused.
//
// Later versions add fields at the end; `size` tells which version a program was compiled for.
typedef struct {
    // `sizeof(ThuribleConfig)`, as `thurible_defaults` writes it.
    size_t size;
    // A `ThuriblePrecision`; `THURIBLE_PRECISION_F32` by default.
    uint32_t precision;
    // 2 or 3; 2 by default.
    uint32_t dimensions;
    // Cells along x, y and z, each from 4 to 4096; z is ignored in 2D. To be set.
    size_t cells[3];
    // A `ThuribleBoundary` for each axis; walls by default.
    uint32_t boundary[3];
    // A `ThuribleMethod`; direct by default.
    uint32_t method;
    // Longest side of the box.
    double length;
    // Time between two steps.
    double dt;
    // Steps N, at least 2. To be set.
    size_t steps;
    // Steps of the keyframes, ascending, from 2 to N; read only while a call that takes the configuration lasts.
    const size_t *keyframes;
    // How many steps `keyframes` points to.
    size_t keyframe_count;
    // What the data term of each keyframe is multiplied by, above 0: `keyframe_count` numbers, or null where all are 1. Read as `keyframes`.
    const double *keyframe_weights;
    // Smoke that is made on the way, where `thurible_set_emitter` says. Read as `keyframes`.
    const ThuribleEmitter *emitters;
    // How many emitters `emitters` points to, at most `THURIBLE_MOST_EMITTERS`.
    size_t emitter_count;
    // What the price of the force is multiplied by at some steps, ascending: linear in its logarithm between them, as the nearest before the
    // first and after the last. Read as `keyframes`.
    const ThuribleFactor *schedule;
    // How many factors `schedule` points to, at most `THURIBLE_MOST_FACTORS`.
    size_t schedule_count;
    // Simple fields that the force is made of, for the method of templates; a simulation adds them as they are. Read as `keyframes`.
    const ThuribleTemplate *templates;
    // How many templates `templates` points to, at most `THURIBLE_MOST_TEMPLATES`.
    size_t template_count;
    // Step from which no force acts, from 2 to N - 1 and not before the last keyframe; 0, the default, for none.
    size_t release;
    // Acceleration of the flow where the density is 1, along x, y and z, in lengths per squared time; z is ignored in 2D. None by default.
    double buoyancy[3];
    // Weight r of the force, an acceleration, so that the same weight in other units is r' dt^4 / length^2: 1000 by default, whatever `dt` and `length` are, where scenes and
    // Python take 1000 dt^4 / length^2.
    double force_weight;
    // Kinematic viscosity, in squared lengths per time; 0 for none.
    double viscosity;
    // Smoothness of the force, in cells from 0 to 64: forces finer than that are dear. 0 is the paper's price; -1, the default, stands for 2.5 with limited
    // transport and 0 with the others. ADMM prices no curls, and takes 0 or -1 alone.
    double smoothness;
    // Filters of the metric, at most 12, or `THURIBLE_AUTOMATIC`.
    uint32_t filters;
    // Whether keyframes are scaled to the mass of the smoke at their steps: 0 or 1.
    uint32_t match_mass;
    // A `ThuribleScheme`; limited by default.
    uint32_t scheme;
    // Whether each keyframe has a region that `thurible_set_region` sets: 0, the default, or 1.
    uint32_t keyframe_regions;
    // Whether there are solid cells, which `thurible_set_solids` sets: 0, the default, or 1. They need limited transport.
    uint32_t solids;
    // Whether force may act only where `thurible_set_mask` says: 0, the default, or 1. ADMM knows no mask.
    uint32_t mask;
    // The series of a transport step is cut at the first term below this times the largest density.
    double advection_tolerance;
    // Relative tolerance of projections.
    double projection_tolerance;
    // Iterations of the method, at most; of the direct method those on the finest grid.
    size_t iterations;
    // Threads that memory is planned for, from 1 to 1024; an executor must not have more.
    size_t threads;
    // Bytes that the plan should stay within if it can; 0 for none.
    size_t memory_ceiling;
    // Direct: pairs of L-BFGS from 1 to 8, or `THURIBLE_AUTOMATIC`.
    uint32_t direct_history;
    // Direct: whether to begin on coarser grids: 0 or 1.
    uint32_t direct_nested;
    // Direct: stop when the objective falls by less than this times itself, twice in a row.
    double direct_tolerance;
    // ADMM: penalty K, above 0, in the units of the scene: 1000 by default, where scenes and Python take 1000 dt^2 / length^2.
    double admm_penalty;
    // ADMM: relaxation beta of the multipliers.
    double admm_relaxation;
    // ADMM: momentum of the advection problem, at least 0 and below 1.
    double admm_ao_momentum;
    // ADMM: stop when densities change less than this times the largest.
    double admm_density_tolerance;
    // ADMM: iterations of the advection problem in each iteration.
    uint32_t admm_ao_iterations;
    // ADMM: whether to begin on coarser grids: 0 or 1.
    uint32_t admm_nested;
    // ADMM: a `ThuribleNsoSolver`; multigrid by default.
    uint32_t nso_solver;
    // ADMM: V-cycles or Newton steps of a Navier-Stokes problem at most, from 1 to 63.
    uint32_t nso_cycles;
    // ADMM: stop a Navier-Stokes problem at a residual below this.
    double nso_tolerance;
    // ADMM: a `ThuribleNorm`; scaled by default.
    uint32_t nso_norm;
    // ADMM: the smoother's colours: a `ThuribleColours`.
    uint32_t nso_colours;
    // L-BFGS over forces: stop as `direct_tolerance`.
    double lbfgs_tolerance;
    // L-BFGS over forces: pairs from 1 to 8, or `THURIBLE_AUTOMATIC`.
    uint32_t lbfgs_history;
    // L-BFGS over forces: whether to begin on a coarser grid: 0 or 1.
    uint32_t lbfgs_nested;
    // Target-driven smoke: weight of the driving force.
    double pd_drive;
    // Target-driven smoke: rate at which momentum is lost.
    double pd_attenuation;
    // Target-driven smoke: weight of the gathering term.
    double pd_gathering;
    // Simulations, L-BFGS over forces and target-driven smoke: relative residual of an implicit step.
    double simulation_tolerance;
    // Templates: pairs of L-BFGS from 1 to 8.
    uint32_t templates_history;
    // Direct: iterations at most on each coarser grid, from 1 to 100000, or `THURIBLE_AUTOMATIC`.
    uint32_t direct_coarse_iterations;
    // Templates: stop as `direct_tolerance`.
    double templates_tolerance;
    // Guidance: what is larger than so many cells follows the given flow.
    double guide_radius;
    // Guidance: how smooth the correction of a step is.
    double guide_smoothness;
    // Guidance: how dear the kinetic energy of the correction is.
    double guide_kinetic;
    // Guidance by ADMM: its penalty.
    double guide_penalty;
    // Guidance by ADMM: its iterations for each step, from 1 to 1000.
    uint32_t guide_iterations;
    // Guidance: a `ThuribleGuideSolver`; automatic by default.
    uint32_t guide_solver;
    // Direct: a `ThuribleHistoryPrecision`; full by default.
    uint32_t direct_history_precision;
    // L-BFGS over forces: a `ThuribleHistoryPrecision`; full by default.
    uint32_t lbfgs_history_precision;
    // Guidance: noise without divergence that stirs each step, its root mean square in cells a step; 0 by default, for none.
    double guide_curl_noise;
    // Guidance: how wide the noise is blurred, in cells.
    double guide_noise_sigma;
    // Guidance: which noise, from 1.
    uint32_t guide_noise_seed;
    // Whether the flow sticks to walls and solid cells, by its viscosity, which is above 0 then, and does not slip along them: 0, the default,
    // or 1. ADMM's multigrid and Stable Fluids refuse it.
    uint32_t no_slip;
    // Direct: what the force's weight is multiplied by from each grid to the next coarser one, above 0 and below 100; 1 by default.
    double direct_coarse_force_weight;
} ThuribleConfig;

// A task: call it with the `argument` that came with it and an index below the number of tasks.
typedef void (*ThuribleTask)(void *argument, size_t index);

// Runs `task(argument, i)` once for every `i < tasks`, on any threads and in any order, and returns when all are done. Neither
// `task` nor `argument` may be used afterwards. An index that is called twice is ignored the second time; one that is not called
// at all is run on the calling thread when this returns. It must return: no exception of C++ and no `longjmp` may leave it.
typedef void (*ThuribleRun)(void *context, size_t tasks, ThuribleTask task, void *argument);

// The host's threads. Results do not depend on them.
typedef struct {
    // How many tasks there may be at the same time, at most `threads` of the configuration.
    size_t threads;
    // Runs tasks on them; null is refused.
    ThuribleRun run;
    // Passed to `run` as it is; the library never reads it.
    void *context;
} ThuribleExecutor;

// A point of the solve.
typedef struct {
    // What it is about.
    ThuribleEventKind kind;
    // A count from 1, or 0.
    size_t iteration;
    // What the kind says, or 0.
    double value;
    // A step, or 0.
    double step;
} ThuribleEvent;

// Hears of an event; anything but 0 stops the solve within one sweep. It must return: no exception of C++ and no `longjmp` may leave it.
typedef int32_t (*ThuribleOn)(void *context, const ThuribleEvent *event);

// What the host watches and stops.
typedef struct {
    // Called at every event, on the thread that called the library; null hears nothing.
    ThuribleOn on;
    // Passed to `on` as it is; the library never reads it.
    void *context;
} ThuribleObserver;

// How far a solve is.
typedef struct {
    // How the solve ended, or that it goes on.
    ThuribleStatus status;
    // Iterations of the method so far.
    size_t iteration;
    // Data term of the objective.
    double data;
    // Force term of the objective.
    double force;
    // Cells of the grid that the direct method or L-BFGS worked on.
    size_t cells[3];
    // That grid, 0 for the finest.
    size_t level;
    // Iteration on that grid.
    size_t level_iteration;
    // Step along the direction, of the direct method or L-BFGS; blending step of ADMM.
    double step;
    // Objectives computed in the iteration, of the direct method or L-BFGS.
    size_t evaluations;
    // ADMM: change of the densities over the largest.
    double density_change;
    // ADMM: max |v - v*| over max |v|.
    double gap;
    // ADMM: the largest violation of the conditions of an optimum.
    double kkt;
} ThuribleProgress;

// Something that the method of an instance gives: a field for each of many steps.
typedef struct {
    // Its name, lower case with underscores, as files have it; components have their axis added there: `velocity_x`.
    char name[THURIBLE_NAME_BYTES];
    // What it is, in a few words.
    char words[THURIBLE_WORDS_BYTES];
    // Where its elements are.
    ThuriblePlace place;
    // In what it is measured.
    ThuribleUnit unit;
    // How many steps it has.
    size_t steps;
    // How many of the first of them are not found but given: these can be read at any time.
    size_t given;
    // How many components it has.
    size_t components;
    // Bytes that `thurible_read_output` writes of component 0, 1 and 2, or 0 where there is none.
    size_t bytes[3];
} ThuribleOutput;

// A field as it lies in the instance. Element (x, y, z) is at `data` plus x `strides[0]` + y `strides[1]` + z `strides[2]` elements of the
// instance's precision; times `unit` it is in the scene's units.
typedef struct {
    // Element (0, 0, 0).
    const void *data;
    // Elements along x, y and z. A component of a velocity or force has the low face of every cell along its axis; on a wall axis the
    // first is on the wall, where nothing flows, and the last wall is left out.
    size_t extent[3];
    // Elements from one to the next along x, y and z.
    size_t strides[3];
    // The scene's unit of these elements.
    double unit;
    // Bytes of an element: 4 for `float`, 8 for `double`.
    size_t bytes_per_number;
} ThuribleView;

// Something that the method of an instance reported of its last iteration.
typedef struct {
    // Its name, lower case with underscores, as reports have it.
    char name[THURIBLE_NAME_BYTES];
    // What it is, in a few words.
    char words[THURIBLE_WORDS_BYTES];
    // What its values are.
    ThuribleFactKind kind;
    // How many values it has: 1, but for a series.
    size_t values;
} ThuribleFact;

// Frames of smoke in a box, and how the flow behind them is found: begin with `thurible_track_defaults`. Weights are in cells and frames, for
// densities that are scaled to 10. Later versions add fields at the end.
typedef struct {
    // `sizeof(ThuribleTrackConfig)`, as `thurible_track_defaults` writes it.
    size_t size;
    // A `ThuriblePrecision`; `THURIBLE_PRECISION_F32` by default.
    uint32_t precision;
    // 2 or 3; 2 by default.
    uint32_t dimensions;
    // Cells along x, y and z, each from 4 to 4096; z is ignored in 2D. To be set.
    size_t cells[3];
    // A `ThuribleBoundary` for each axis, wall or periodic; walls by default.
    uint32_t boundary[3];
    // A `ThuribleMinimiser`; direct by default.
    uint32_t method;
    // Longest side of the box; 1 by default.
    double length;
    // Time between two frames; 1 by default.
    double dt;
    // What densities are multiplied by, for the weights to mean something: 10 / the largest of all frames. 10 by default, for densities up to 1.
    double density_scale;
    // Acceleration where the density is 1 along x, y and z, in lengths per squared time, in the prediction; z is ignored in 2D.
    double buoyancy[3];
    // Threads that memory is planned for, from 1; an executor must not have more.
    size_t threads;
    // Weight of smoothness.
    double alpha;
    // Weight of the flow's kinetic energy.
    double beta;
    // Price of divergence, of Horn-Schunck alone.
    double gamma;
    // Step of ADMM.
    double lambda;
    // ADMM ends early when it changes less than this part; 0 for never.
    double tolerance;
    // Iterations of ADMM.
    uint32_t iterations;
    // Grids of the pyramid, from 1 to 8.
    uint32_t levels;
    // Cells of the next coarser grid along an axis, in parts.
    double eta;
    // Blur before a coarser grid, in cells.
    double sigma;
    // How often each grid warps and solves.
    uint32_t warps;
    // A `ThuribleWarping`.
    uint32_t warp;
    // What conjugate gradients leave, in parts of their right-hand side.
    double cg_tolerance;
    // Steps of conjugate gradients at most.
    uint32_t cg_iterations;
    // A `ThuriblePrediction`.
    uint32_t predict;
    // Whether every pair is on its own: 0 or 1.
    uint32_t independent;
    // Whether the first frame is carried by the flow and compared: 0 or 1.
    uint32_t readvect;
    // Whether smoke is made between frames, and given beside them: 0 or 1.
    uint32_t emission;
    // Whether the force from the flow of each pair to the next is computed: 0 or 1.
    uint32_t forces;
} ThuribleTrackConfig;

// Where a flow is written, component by component, in the layout of files and in the capture's units: x fastest, one more along a component's own
// axis than there are cells where that ends in walls.
typedef struct {
    // The components along x, y and z; null for one that is not wanted, as z in 2D.
    void *values[3];
    // Bytes of each, as `thurible_track_faces` says.
    size_t bytes[3];
} ThuribleFaces;

// What is said of a pair of frames.
typedef struct {
    // `THURIBLE_STATUS_CONVERGED`, or how it was stopped: `THURIBLE_STATUS_CANCELLED`, or `THURIBLE_STATUS_NOT_FINITE` where a flow was too fast or not
    // finite. Then the pair has no flow, nor has any later one.
    ThuribleStatus status;
    // k of the pair of frames k and k + 1.
    size_t frame;
    // 1/2 |phi_t + F w|^2 on the finest grid.
    double data;
    // alpha/2 <v, L v> of the correction.
    double smoothness;
    // beta/2 |v|^2 of the correction.
    double kinetic;
    // The gradient that is left, in parts of the first.
    double optimality;
    // Squared distance of frame k + 1, pulled back by the prediction, from frame k.
    double misfit_predicted;
    // The same, pulled back by the flow.
    double misfit;
    // The largest velocity, in cells a frame.
    double fastest;
    // How far the first frame, carried by the flow, is from frame k + 1, in parts of that; 0 without `readvect`.
    double readvection;
    // How many grids there are.
    size_t levels;
    // Products by the operator on each of them, finest first.
    size_t products[THURIBLE_MOST_LEVELS];
} ThuriblePair;

// A camera. Places x are in cells, from the lower corner of the box; pixel i of a row has its middle at u = i + 1/2, row 0 is the first of the
// picture. `report.json` of `thurible tomography` has cameras in these numbers. In 2D z, v and `down` are ignored, and pictures are rows.
typedef struct {
    // A `ThuribleLens`.
    uint32_t lens;
    // For later versions; must be 0.
    uint32_t reserved;
    // Pixels across and down; 1 down in 2D.
    size_t pixels[2];
    // What u rises along: parallel, a unit vector over the cells that a pixel is wide; through an eye, one times the focal length in pixels.
    double across[3];
    // The same for v.
    double down[3];
    // The way of the rays, or straight ahead: of length 1.
    double forward[3];
    // u and v of the origin, or of what lies straight ahead.
    double at[2];
    // The eye, of a pinhole.
    double eye[3];
    // Cells that a pixel is wide, of parallel rays.
    double pitch;
} ThuribleCamera;

// A box, the cameras about it, and how its density is found: begin with `thurible_tomography_defaults`. Later versions add fields at the end.
typedef struct {
    // `sizeof(ThuribleTomographyConfig)`, as `thurible_tomography_defaults` writes it.
    size_t size;
    // A `ThuriblePrecision`; `THURIBLE_PRECISION_F32` by default.
    uint32_t precision;
    // 2 or 3; 2 by default.
    uint32_t dimensions;
    // Cells along x, y and z, at least 2; z is ignored in 2D. To be set.
    size_t cells[3];
    // The cameras that measure; read only while a call that takes the configuration lasts.
    const ThuribleCamera *cameras;
    // How many there are, from 1 to `THURIBLE_MOST_CAMERAS`.
    size_t camera_count;
    // Cameras that measure nothing: what they would see is kept. Read as `cameras`.
    const ThuribleCamera *novel;
    // How many there are, at most `THURIBLE_MOST_CAMERAS`.
    size_t novel_count;
    // A `ThuribleReconstructor`; the walk by default.
    uint32_t method;
    // A `ThuriblePrior`; SAD by default.
    uint32_t prior;
    // How much of it, in the units of the density (of a pixel, for those of novel views); 0.15 by default, where the program chooses by prior and picture.
    double gamma;
    // Whether no cell may fall below 0; where none are kept, no pixel of a novel view: 0 or 1.
    uint32_t nonnegative;
    // Whether the density is kept where only the caller needs it: 0 or 1; 1 by default, where the program keeps none by the priors of pictures.
    uint32_t volume;
    // Standard deviation of a mutation, in diagonals of the box.
    double sigma;
    // Mutations of a chain.
    uint64_t length;
    // Mutations of a frame; 6 million by default, where the program takes 20 for each cell and camera.
    uint64_t budget;
    // Mass of a sample; 0 for total / (accept budget).
    double eps;
    // The part of the mutations that is expected to be recorded.
    double accept;
    // A frame ends when a tenth of the budget lowers the objective by less than this part; 0 for never.
    double tolerance;
    // A `ThuribleWalk`; patient by default.
    uint32_t walk;
    // Passes of SART over all cameras.
    uint32_t sweeps;
    // Pixels of at most this are dark: places that they see are empty.
    double hull_threshold;
    // Which random numbers.
    uint64_t seed;
    // The part of the budget of a frame that begins with the one before.
    double warm_budget;
    // How far SART goes at a time.
    double relax;
} ThuribleTomographyConfig;

// How far a frame is.
typedef struct {
    // `THURIBLE_STATUS_GOES`; `THURIBLE_STATUS_CONVERGED` where it got hardly better, `THURIBLE_STATUS_MAX_ITERATIONS` where its budget is spent.
    ThuribleStatus status;
    // The frame.
    uint64_t frame;
    // Mutations so far; of SART its sweeps.
    uint64_t mutations;
    // How many of them were recorded.
    uint64_t recorded;
    // Mutations of the frame at most.
    uint64_t budget;
    // Mass of a sample.
    double eps;
    // 1/2 |q - F p|^2.
    double data;
    // gamma times the prior.
    double prior;
    // |q - F p| / |q|.
    double residual;
} ThuribleWalked;

// What is chosen for Stable Fluids beside the scene, a `ThuribleConfig` whose precision, box, times, keyframes, `templates` (winds and vortices),
// `buoyancy`, `viscosity`, `force_weight`, `filters`, `match_mass`, `threads` and `memory_ceiling` it takes: begin with `thurible_fluids_defaults`. Later
// versions add fields at the end.
typedef struct {
    // `sizeof(ThuribleFluidsConfig)`, as `thurible_fluids_defaults` writes it.
    size_t size;
    // A sum of `ThuribleControl`; the velocity at the start by default.
    uint32_t controls;
    // States that are kept for the way back, from 1 to the steps; 0 for all that the adjoint reads; `THURIBLE_AUTOMATIC`, the default, for the most that
    // `memory_ceiling` of the scene holds, and `THURIBLE_NO_WAY_BACK`. No number changes a bit.
    uint32_t slots;
    // A `ThuriblePressure`; by sweeps by default.
    uint32_t pressure;
    // A `ThuribleAdjoint`; exact by default.
    uint32_t adjoint;
    // Gauss-Seidel sweeps, of pressure and diffusion.
    uint32_t sweeps;
    // Iterations of conjugate gradients at most.
    uint32_t cg_iterations;
    // What they leave, in parts of their right-hand side.
    double cg_tolerance;
    // Diffusion of the density, in squared lengths per time.
    double diffusion;
    // Price of the initial velocity.
    double initial_weight;
    // Stop when the objective falls by less than this times itself, twice in a row.
    double tolerance;
    // Pairs of L-BFGS.
    uint32_t history;
    // Iterations at most.
    uint32_t iterations;
    // Whether `thurible_fluids_set_initial_velocity` gives a velocity at the start: 0, the default, or 1.
    uint32_t initial_velocity;
    // For later versions; must be 0.
    uint32_t reserved;
} ThuribleFluidsConfig;

// Told of a step: before what is given for it is read, or after what is handed out was written. 0 goes on; `THURIBLE_NOTHING`, where something is
// to be given, says that there is nothing at this step; anything else stops, and so does that one where a step was handed out. It must
// return: no exception of C++ and no `longjmp` may leave it.
typedef int32_t (*ThuribleOnStep)(void *context, size_t step);

// Arrays of the host for every step: x fastest, in the scene's units. Each is either that of one step, which every step uses in its turn, or that
// of all steps, one after the other; its bytes say which. Null stands for what is not given, which is 0, or not wanted.
typedef struct {
    // Called for every step; null for nobody.
    ThuribleOnStep on;
    // Passed to `on` as it is; the library never reads it.
    void *context;
    // One number for each cell. Forces have none.
    void *density;
    // Its bytes.
    size_t density_bytes;
    // Components along x, y and z.
    void *vector[3];
    // Their bytes.
    size_t vector_bytes[3];
} ThuribleSteps;

// How far a search is.
typedef struct {
    // How it ended, or that it goes on.
    ThuribleStatus status;
    // Iterations so far.
    size_t iteration;
    // Data term of the objective.
    double data;
    // Price of the forces.
    double force;
    // Price of the velocity at the start.
    double initial;
    // Step along the direction.
    double step;
    // Objectives computed in the iteration.
    size_t evaluations;
    // Steps that its gradient repeated, beside those that were run once more to be taken back.
    size_t repeated;
} ThuribleSearched;

// How a simulation becomes an operator, beside its scene, a `ThuribleConfig` whose method, keyframes and prices count for nothing: begin with
// `thurible_operator_defaults`. Later versions add fields at the end.
typedef struct {
    // `sizeof(ThuribleOperatorConfig)`, as `thurible_operator_defaults` writes it.
    size_t size;
    // A `ThuribleSimulator`; implicit by default.
    uint32_t simulator;
    // States that are kept for the way back, from 1 to the steps; `THURIBLE_AUTOMATIC`, the default, for as many as `memory_ceiling` of the scene holds. Of
    // Stable Fluids also 0, for all that the adjoint reads, and `THURIBLE_NO_WAY_BACK`. No number changes a bit.
    uint32_t slots;
    // Implicit: what a step and its adjoint leave of their residuals; 1e-10 by default.
    double tolerance;
    // Stable Fluids: pressure, adjoint, sweeps and diffusion; null for the defaults. Read as `keyframes` of a scene.
    const ThuribleFluidsConfig *fluids;
} ThuribleOperatorConfig;

// What a scalar function gets by the numbers of an emitter.
typedef struct {
    // By its rate or target.
    double supply;
    // By the velocity of its smoke along x, y and z; 0 where it has none.
    double velocity[3];
} ThuribleEmitterGradient;

// How a simulation or its way back ended.
typedef struct {
    // `THURIBLE_STATUS_CONVERGED` where it came to its end; `THURIBLE_STATUS_CANCELLED` where the observer or a `ThuribleOnStep` stopped it;
    // `THURIBLE_STATUS_NOT_FINITE` where a flow was too fast or not finite.
    ThuribleStatus status;
    // Steps that were run again, beside the one for each step that was taken back.
    size_t repeated;
} ThuribleRan;

// A spring between two vertices.
typedef struct {
    // Its ends.
    uint32_t ends[2];
    // k of k/2 (l - L)^2.
    double stiffness;
    // L.
    double rest_length;
    // Whether a basis knows it, 0 or 1.
    uint32_t in_basis;
    // For later versions; must be 0.
    uint32_t reserved;
} ThuribleSpring;

// An elastic body, and how its energy is minimised: begin with `thurible_condense_defaults`. Lists are copied when a body is made. Later versions add fields
// at the end.
typedef struct {
    // `sizeof(ThuribleCondenseConfig)`, as `thurible_condense_defaults` writes it.
    size_t size;
    // A `ThuriblePrecision`; that of the state, `double` by default. What is given and read is `double` in either.
    uint32_t precision;
    // Components of a vector: 1 of a rod, 2 or 3.
    uint32_t dimensions;
    // Vertices.
    size_t vertex_count;
    // Where they are at rest: `dimensions` numbers for each.
    const double *rest;
    // Whether each is held, 0 or 1: its place is given, not found.
    const uint8_t *held;
    // Simplices,
    size_t element_count;
    // and their corners: `dimensions` + 1 vertices for each, in an order that makes volumes positive.
    const uint32_t *elements;
    // Springs; none by default.
    size_t spring_count;
    // See there.
    const ThuribleSpring *springs;
    // Vertices along each axis of a regular mesh, numbered along x first; zeros, the default, of any other. Colours are parities there.
    size_t regular[3];
    // Young's modulus.
    double young;
    // Poisson's ratio; a rod has none.
    double poisson;
    // Mass in a unit of area or volume.
    double density;
    // Cross section of a rod.
    double area;
    // A `ThuribleCondenseMethod`.
    uint32_t method;
    // A `ThuribleCondenseBasis`.
    uint32_t basis;
    // A `ThuribleCondenseBlock`.
    uint32_t block;
    // A `ThuribleCondenseOrder`.
    uint32_t order;
    // Steps from one build to the next, of rebuilt bases.
    uint32_t rebuild;
    // Edges within which a basis is kept; `THURIBLE_AUTOMATIC`, the default, keeps all.
    uint32_t radius;
    // The residual below which a step is solved.
    double tolerance;
    // Iterations of a step at most.
    uint32_t cap;
    // Whether steps along the direction are searched for, 0 or 1.
    uint32_t search;
    // Length of an implicit step; 0, the default, is quasi-static.
    double dt;
    // Threads that memory is planned for.
    size_t threads;
} ThuribleCondenseConfig;

// A state before an iteration, or at the end of a step.
typedef struct {
    // How many iterations of this step came before.
    size_t iteration;
    // Builds so far.
    size_t builds;
    // The energy.
    double energy;
    // What is compared with the tolerance.
    double residual;
    // Part of the last direction that was gone, 0 at the beginning.
    double length;
} ThuribleIteration;

// How a step of a body went.
typedef struct {
    // How it ended.
    ThuribleStatus status;
    // Its iterations.
    size_t iterations;
    // Builds of the basis, or of the factor that stands for it, in it.
    size_t builds;
    // States that were told of: before each iteration, and at the end.
    size_t told;
} ThuribleCondensed;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// A few words for a `ThuribleResult`, in static memory.
const char *thurible_result_text(uint32_t result);

// A few words for a `ThuribleStatus`, in static memory.
const char *thurible_status_text(uint32_t status);

// The version of the library that is linked: compare it with `THURIBLE_VERSION` of the header.
uint32_t thurible_version(void);

// Fills a configuration of `size` bytes, `sizeof(ThuribleConfig)` of the program that calls, with the defaults.
// Safety: `config` is null or points to `size` bytes to write.
ThuribleResult thurible_defaults(ThuribleConfig *config, size_t size);

// Writes why a configuration is refused, or nothing where it is not, into `buffer` of `size` bytes, cut where it does not fit and
// always ended by a zero byte; bytes of the whole text. A null `buffer` only counts.
// Safety: `config` is null or points to a configuration whose lists are there; `buffer` is null or points to `size` bytes.
size_t thurible_explain(const ThuribleConfig *config, char *buffer, size_t size);

// How many bytes an instance takes, on which multiple of bytes they must begin, and how many bytes a saved one has. Nothing is
// allocated or kept. Each pointer but `config` may be null.
// Safety: `config` is null or points to a configuration whose lists are there; the others are null or may be written.
ThuribleResult thurible_plan(const ThuribleConfig *config, size_t *bytes, size_t *alignment, size_t *saved_bytes);

// Makes an instance in `memory` of `bytes` bytes, as many as `thurible_plan` says or more, and writes its handle to `out`. The
// memory is the instance's until it is closed; it must not be moved. Nothing else is needed: no global state, no allocation.
// Safety: `memory` is null or points to `bytes` bytes that nobody else uses; `config` as in `thurible_plan`; `out` is null or may be written.
ThuribleResult thurible_init(void *memory,
                             size_t bytes,
                             const ThuribleConfig *config,
                             Thurible **out);

// Ends an instance: its memory is the caller's again and the handle is refused from now on.
// Safety: `instance` is null or points to memory of an instance's size.
ThuribleResult thurible_close(Thurible *instance);

// Writes why the last call with this instance was refused, or nothing where it was not, as `thurible_explain` does.
// Safety: `instance` as in `thurible_close`; `buffer` is null or points to `size` bytes.
size_t thurible_message(const Thurible *instance, char *buffer, size_t size);

// Sets the density of step 0: one element of the instance's precision for each cell, x fastest; `bytes` of all. It may be left out where
// there are emitters.
// Safety: `instance` as in `thurible_close`; `density` is null or points to `bytes` bytes.
ThuribleResult thurible_set_source(Thurible *instance,
                                   const void *density,
                                   size_t bytes);

// Sets which cells are solid, before anything else is set: one byte for each cell, x fastest, 1 where it is solid and 0 where it is not. Refused
// where `solids` of the configuration is 0, and as too late after a source or a keyframe. Densities are 0 in solid cells, whatever is given.
// Safety: `instance` as in `thurible_close`; `solid` is null or points to `bytes` bytes.
ThuribleResult thurible_set_solids(Thurible *instance,
                                   const uint8_t *solid,
                                   size_t bytes);

// Sets the shape of emitter `index`, as `thurible_set_source`: where it adds smoke, and how much of its rate or target there.
// Safety: As `thurible_set_source`.
ThuribleResult thurible_set_emitter(Thurible *instance, size_t index, const void *shape, size_t bytes);

// Sets the region of keyframe `index`, as `thurible_set_source`: what its error is multiplied by in each cell, from 0 to 1. Refused where
// `keyframe_regions` of the configuration is 0; 1 everywhere where it is not set.
// Safety: As `thurible_set_source`.
ThuribleResult thurible_set_region(Thurible *instance,
                                   size_t index,
                                   const void *region,
                                   size_t bytes);

// Sets where force may act, as `thurible_set_source`: in each cell 1 everywhere and 0 as good as nowhere, in between at 1 / mask^2 times the
// price. Refused where `mask` of the configuration is 0; 1 everywhere where it is not set.
// Safety: As `thurible_set_source`.
ThuribleResult thurible_set_mask(Thurible *instance,
                                 const void *mask,
                                 size_t bytes);

// Sets the target of keyframe `index`, as `thurible_set_source`; the source, where there is one, and the shapes of all emitters come
// first. Where keyframes are scaled to the mass of the smoke at their steps, `factor` is by how much; it may be null.
// Safety: As `thurible_set_source`; `factor` is null or may be written.
ThuribleResult thurible_set_keyframe(Thurible *instance,
                                     size_t index,
                                     const void *density,
                                     size_t bytes,
                                     double *factor);

// Sets component `axis` of the velocity at step 0, in the layout of `thurible_copy` and the scene's units; 0 where it is not set.
// Safety: As `thurible_set_source`.
ThuribleResult thurible_set_initial_velocity(Thurible *instance, size_t axis, const void *faces, size_t bytes);

// Sets component `axis` of the flow of step `step` that the method of guidance follows, from 1 to steps - 1, as `thurible_set_initial_velocity`; a
// step that is not set is at rest. A solve, whole or stopped, goes over this flow and puts what it finds in its place: before another one it is given
// anew, or the solve answers `THURIBLE_RESULT_NO_REFERENCE`.
// Safety: As `thurible_set_source`.
ThuribleResult thurible_set_reference(Thurible *instance,
                                      size_t axis,
                                      size_t step,
                                      const void *faces,
                                      size_t bytes);

// One iteration. `executor`, `observer` and `progress` may be null: one thread, nobody who watches, and see `thurible_progress`. How
// a solve ends is in the progress; this returns only refusals.
// Safety: `instance` as in `thurible_close`; `executor` and `observer` are null or keep to their contracts; `progress` is null or may be
// written.
ThuribleResult thurible_step(Thurible *instance,
                             const ThuribleExecutor *executor,
                             const ThuribleObserver *observer,
                             ThuribleProgress *progress);

// Makes the result feasible: the flow free of divergence, the forces those that make it, the densities those that it carries. Results
// can be read afterwards, until the next step. The progress holds the objective of the result. It is the end of a solve: a search that is on a coarser
// grid goes to the finest at once, and steps after it are a new descent from there, which counts its iterations anew. To look at a result on the way,
// `thurible_save` before and `thurible_restore` after.
// Safety: As `thurible_step`.
ThuribleResult thurible_finish(Thurible *instance,
                               const ThuribleExecutor *executor,
                               ThuribleProgress *progress);

// Steps to the end and finishes. `progress` says how it ended.
// Safety: As `thurible_step`.
ThuribleResult thurible_solve(Thurible *instance,
                              const ThuribleExecutor *executor,
                              const ThuribleObserver *observer,
                              ThuribleProgress *progress);

// How far the instance is: what the last step or finish said.
// Safety: `instance` as in `thurible_close`; `progress` is null or may be written.
ThuribleResult thurible_progress(const Thurible *instance, ThuribleProgress *progress);

// Saves the whole state, densities included, into `bytes` of `size` bytes, `saved_bytes` of `thurible_plan` or more: plain bytes, the
// same on every machine.
// Safety: `instance` as in `thurible_close`; `bytes` is null or points to `size` bytes to write.
ThuribleResult thurible_save(Thurible *instance,
                             void *bytes,
                             size_t size);

// Goes on from what `thurible_save` wrote, of exactly `saved_bytes`, here or in another instance, process or machine, whose
// configuration may differ in threads, ceiling and iterations alone, unless automatic pairs of L-BFGS become fewer under the ceiling: every later step gives the same bits. Damaged bytes and those of
// another configuration are refused and change nothing. Solid cells are not among them: `thurible_set_solids` comes first, with the same cells.
// Safety: `instance` as in `thurible_close`; `bytes` is null or points to `size` bytes.
ThuribleResult thurible_restore(Thurible *instance,
                                const void *bytes,
                                size_t size);

// How many outputs the method of an instance has. Densities, velocities and forces are among them where a `ThuribleField` of them can
// be had.
// Safety: `instance` as in `thurible_close`; `count` is null or may be written.
ThuribleResult thurible_output_count(const Thurible *instance,
                                     size_t *count);

// Says what output `index` is, from 0 on.
// Safety: `instance` as in `thurible_close`; `output` is null or may be written.
ThuribleResult thurible_output(const Thurible *instance, size_t index, ThuribleOutput *output);

// As `thurible_view`, of output `index`.
// Safety: As `thurible_view`.
ThuribleResult thurible_view_output(const Thurible *instance, size_t index, size_t step, size_t axis, ThuribleView *view);

// As `thurible_copy`, of output `index`: component `axis` at a step, into `out` of exactly `bytes` bytes.
// Safety: As `thurible_copy`.
ThuribleResult thurible_read_output(const Thurible *instance, size_t index, size_t step, size_t axis, void *out, size_t bytes);

// Where a `ThuribleField` of the result lies, without copying: after `thurible_finish` or `thurible_solve`, and until the next call
// that changes the instance; what was given, step 0 of densities and velocities, the keyframes and their regions, at any time. `axis` is 0 for
// all but velocities, forces and those of emitters. A field that the method does not give is refused; `thurible_output` says which it gives.
// Safety: `instance` as in `thurible_close`; `view` is null or may be written.
ThuribleResult thurible_view(const Thurible *instance,
                             uint32_t field,
                             size_t step,
                             size_t axis,
                             ThuribleView *view);

// Bytes that `thurible_copy` writes for a `ThuribleField`.
// Safety: `instance` as in `thurible_close`; `bytes` is null or may be written.
ThuribleResult thurible_copy_bytes(const Thurible *instance, uint32_t field, size_t axis, size_t *bytes);

// Copies a `ThuribleField` of the result into `out` of exactly `bytes` bytes, as files have it: z, y, x with x fastest; a component of a
// velocity or force one more along its own axis than there are cells where that ends in walls; in the scene's units and the
// instance's precision. When it can be had, see `thurible_view`.
// Safety: `instance` as in `thurible_close`; `out` is null or points to `bytes` bytes to write.
ThuribleResult thurible_copy(const Thurible *instance,
                             uint32_t field,
                             size_t step,
                             size_t axis,
                             void *out,
                             size_t bytes);

// How many facts the method reported of the last iteration, those that `thurible_progress` has fields for among them; 0 before the
// first and after `thurible_restore`.
// Safety: `instance` as in `thurible_close`; `count` is null or may be written.
ThuribleResult thurible_fact_count(const Thurible *instance,
                                   size_t *count);

// Says what fact `index` is, from 0 on.
// Safety: `instance` as in `thurible_close`; `fact` is null or may be written.
ThuribleResult thurible_fact(const Thurible *instance, size_t index, ThuribleFact *fact);

// Copies all values of fact `index` into `values` of exactly `bytes` bytes, which is 8 for each of them.
// Safety: `instance` as in `thurible_close`; `values` is null or points to `bytes` bytes to write.
ThuribleResult thurible_fact_values(const Thurible *instance, size_t index, double *values, size_t bytes);

// Template `index` of the result, from 0 on, as it was found: its middle and radius, and its first amplitude. It ends with the force.
// Safety: `instance` as in `thurible_close`; `found` is null or may be written.
ThuribleResult thurible_template(const Thurible *instance,
                                 size_t index,
                                 ThuribleTemplate *found);

// The amplitude that template `index` of the result has at step `step`, from its `from` to before its `to`: three numbers, of which the
// template's kind says how many count.
// Safety: `instance` as in `thurible_close`; `amplitude` is null or points to three numbers to write.
ThuribleResult thurible_template_amplitude(const Thurible *instance,
                                           size_t index,
                                           size_t step,
                                           double *amplitude);

// As `thurible_explain`, of a tracker's configuration.
// Safety: `config` is null or points to a configuration; `buffer` is null or points to `size` bytes.
size_t thurible_track_explain(const ThuribleTrackConfig *config, char *buffer, size_t size);

// How many bytes a tracker takes, however many frames there are, and on which multiple of bytes they must begin. Each pointer but `config` may
// be null.
// Safety: `config` is null or points to a configuration; the others are null or may be written.
ThuribleResult thurible_track_plan(const ThuribleTrackConfig *config,
                                   size_t *bytes,
                                   size_t *alignment);

// Makes a tracker in `memory`, as `thurible_init` makes an instance.
// Safety: `memory` is null or points to `bytes` bytes that nobody else uses; `config` as in `thurible_track_plan`; `out` is null or may be written.
ThuribleResult thurible_track_init(void *memory,
                                   size_t bytes,
                                   const ThuribleTrackConfig *config,
                                   ThuribleTracker **out);

// Ends a tracker: its memory is the caller's again.
// Safety: `tracker` is null or points to memory of a tracker's size.
ThuribleResult thurible_track_close(ThuribleTracker *tracker);

// As `thurible_message`, of the last call with this tracker.
// Safety: `tracker` as in `thurible_track_close`; `buffer` is null or points to `size` bytes.
size_t thurible_track_message(const ThuribleTracker *tracker, char *buffer, size_t size);

// Sets component `axis` of the flow of the first pair, before any frame, in the layout and units of `ThuribleFaces`; at rest where it is not set.
// Safety: `tracker` as in `thurible_track_close`; `faces` is null or points to `bytes` bytes.
ThuribleResult thurible_track_set_initial_velocity(ThuribleTracker *tracker,
                                                   size_t axis,
                                                   const void *faces,
                                                   size_t bytes);

// Gives the next frame: one density for each cell, x fastest, `bytes` of all. `emission`, of as many, is what was made of it since the frame
// before, where `emission` of the configuration is 1; else it is null, as with the first frame. `executor` may be null.
// Safety: `tracker` as in `thurible_track_close`; `executor` is null or keeps to its contract; `frame` and `emission` are null or point to `bytes` bytes.
ThuribleResult thurible_track_give(ThuribleTracker *tracker,
                                   const ThuribleExecutor *executor,
                                   const void *frame,
                                   const void *emission,
                                   size_t bytes);

// Bytes of component `axis` of a flow.
// Safety: `tracker` as in `thurible_track_close`; `bytes` is null or may be written.
ThuribleResult thurible_track_faces(const ThuribleTracker *tracker, size_t axis, size_t *bytes);

// Fills a configuration of `size` bytes, `sizeof(ThuribleTrackConfig)` of the program that calls, with the defaults of a `ThuribleMinimiser`.
// Safety: `config` is null or points to `size` bytes to write.
ThuribleResult thurible_track_defaults(ThuribleTrackConfig *config,
                                       size_t size,
                                       uint32_t method);

// Finds the flow that carries the frame before the last to the last. `velocity`, `predicted` (the flow before the frames were looked at) and
// `correction` (what was added to that) say where they are to be written, `force` (what leads from the flow before to this one, in velocities a
// time, where `forces` of the configuration is 1: of every pair but the first, and one before which frames were passed over; elsewhere nothing is
// written), `pair` what is said of it; each of them may be null, as `executor` and `observer`. How it ends is in `pair`; this returns only
// refusals, before anything is written.
// Safety: `tracker` as in `thurible_track_close`; `executor` and `observer` are null or keep to their contracts; the others are null or may be read and
// written, and their pointers are null or point to as many bytes to write as they say, nowhere into another of them.
ThuribleResult thurible_track_step(ThuribleTracker *tracker,
                                   const ThuribleExecutor *executor,
                                   const ThuribleObserver *observer,
                                   const ThuribleFaces *velocity,
                                   const ThuribleFaces *predicted,
                                   const ThuribleFaces *correction,
                                   const ThuribleFaces *force,
                                   ThuriblePair *pair);

// Copies the first frame, carried by the flow to the last pair's second frame, into `out` of exactly `bytes` bytes, as frames are given. Refused
// where `readvect` of the configuration is 0, and before the first frame.
// Safety: `tracker` as in `thurible_track_close`; `out` is null or points to `bytes` bytes to write.
ThuribleResult thurible_track_density(const ThuribleTracker *tracker,
                                      void *out,
                                      size_t bytes);

// As `thurible_explain`, of a reconstruction's configuration.
// Safety: `config` is null or points to a configuration whose lists are there; `buffer` is null or points to `size` bytes.
size_t thurible_tomography_explain(const ThuribleTomographyConfig *config, char *buffer, size_t size);

// How many bytes a reconstruction takes, and on which multiple of bytes they must begin. Each pointer but `config` may be null.
// Safety: `config` is null or points to a configuration whose lists are there; the others are null or may be written.
ThuribleResult thurible_tomography_plan(const ThuribleTomographyConfig *config, size_t *bytes, size_t *alignment);

// Makes a reconstruction in `memory`, as `thurible_init` makes an instance.
// Safety: `memory` is null or points to `bytes` bytes that nobody else uses; `config` as in `thurible_tomography_plan`; `out` is null or may be written.
ThuribleResult thurible_tomography_init(void *memory,
                                        size_t bytes,
                                        const ThuribleTomographyConfig *config,
                                        ThuribleTomography **out);

// Ends a reconstruction: its memory is the caller's again.
// Safety: `tomography` is null or points to memory of a reconstruction's size.
ThuribleResult thurible_tomography_close(ThuribleTomography *tomography);

// As `thurible_message`, of the last call with this reconstruction.
// Safety: `tomography` as in `thurible_tomography_close`; `buffer` is null or points to `size` bytes.
size_t thurible_tomography_message(const ThuribleTomography *tomography, char *buffer, size_t size);

// Gives what camera `camera` measured in the next frame: a number of the precision for each pixel, row by row, in density times cells; `bytes` of
// all. Every camera is given anew for each frame.
// Safety: `tomography` as in `thurible_tomography_close`; `pixels` is null or points to `bytes` bytes.
ThuribleResult thurible_tomography_measure(ThuribleTomography *tomography,
                                           size_t camera,
                                           const void *pixels,
                                           size_t bytes);

// Begins frame `frame` with the pictures that were given: from nothing, or, `warm` being 1, from the density of the frame before, with
// `warm_budget` of the budget. The first frame, and one behind a dark frame, begin from nothing alone.
// Safety: `tomography` as in `thurible_tomography_close`.
ThuribleResult thurible_tomography_begin(ThuribleTomography *tomography,
                                         size_t frame,
                                         uint32_t warm);

// Fills a configuration of `size` bytes, `sizeof(ThuribleTomographyConfig)` of the program that calls, with the defaults.
// Safety: `config` is null or points to `size` bytes to write.
ThuribleResult thurible_tomography_defaults(ThuribleTomographyConfig *config, size_t size);

// Goes on by at most `most` mutations, or one sweep of SART; refused where pictures of the next frame were given. `walked` says how far that is; it
// may be null, which saves a pass over all pixels and cells.
// Safety: `tomography` as in `thurible_tomography_close`; `walked` is null or may be written.
ThuribleResult thurible_tomography_advance(ThuribleTomography *tomography,
                                           size_t most,
                                           ThuribleWalked *walked);

// Copies the density into `out` of exactly `bytes` bytes: a number of the precision for each cell, x fastest. Refused before a frame was begun, and
// where it is not kept.
// Safety: `tomography` as in `thurible_tomography_close`; `out` is null or points to `bytes` bytes to write.
ThuribleResult thurible_tomography_density(const ThuribleTomography *tomography,
                                           void *out,
                                           size_t bytes);

// Copies what camera `camera` would see of the density into `out` of exactly `bytes` bytes, as pictures are given.
// Safety: As `thurible_tomography_density`.
ThuribleResult thurible_tomography_picture(const ThuribleTomography *tomography, size_t camera, void *out, size_t bytes);

// Copies what novel view `view` shows, as `thurible_tomography_picture`.
// Safety: As `thurible_tomography_density`.
ThuribleResult thurible_tomography_novel(const ThuribleTomography *tomography, size_t view, void *out, size_t bytes);

// As `thurible_explain`, of the scene and the configuration of a search.
// Safety: `scene` and `config` are null or point to configurations whose lists are there; `buffer` is null or points to `size` bytes.
size_t thurible_fluids_explain(const ThuribleConfig *scene, const ThuribleFluidsConfig *config, char *buffer, size_t size);

// As `thurible_operator_plan`, of a search by Stable Fluids.
// Safety: `scene` and `config` are null or point to configurations whose lists are there; the others are null or may be written.
ThuribleResult thurible_fluids_plan(const ThuribleConfig *scene,
                                    const ThuribleFluidsConfig *config,
                                    size_t *bytes,
                                    size_t *alignment,
                                    size_t *slots,
                                    size_t *repeated);

// Makes a search in `memory`, as `thurible_init` makes an instance.
// Safety: `memory` is null or points to `bytes` bytes that nobody else uses; `scene` and `config` as in `thurible_fluids_plan`; `out` is null or may be written.
ThuribleResult thurible_fluids_init(void *memory,
                                    size_t bytes,
                                    const ThuribleConfig *scene,
                                    const ThuribleFluidsConfig *config,
                                    ThuribleFluids **out);

// Ends a search: its memory is the caller's again.
// Safety: `fluids` is null or points to memory of a search's size.
ThuribleResult thurible_fluids_close(ThuribleFluids *fluids);

// As `thurible_message`, of the last call with this search.
// Safety: `fluids` as in `thurible_fluids_close`; `buffer` is null or points to `size` bytes.
size_t thurible_fluids_message(const ThuribleFluids *fluids, char *buffer, size_t size);

// Sets the density at the start, as `thurible_set_source`.
// Safety: `fluids` as in `thurible_fluids_close`; `density` is null or points to `bytes` bytes.
ThuribleResult thurible_fluids_set_source(ThuribleFluids *fluids, const void *density, size_t bytes);

// Sets the target of keyframe `index`, after the source, as `thurible_set_keyframe`.
// Safety: As `thurible_fluids_set_source`; `factor` is null or may be written.
ThuribleResult thurible_fluids_set_keyframe(ThuribleFluids *fluids,
                                            size_t index,
                                            const void *density,
                                            size_t bytes,
                                            double *factor);

// Sets component `axis` of the velocity at the start, at the centres of cells and in the scene's units, where `initial_velocity` of the configuration is 1.
// Safety: As `thurible_fluids_set_source`.
ThuribleResult thurible_fluids_set_initial_velocity(ThuribleFluids *fluids,
                                                    size_t axis,
                                                    const void *velocity,
                                                    size_t bytes);

// Fills a configuration of `size` bytes, `sizeof(ThuribleFluidsConfig)` of the program that calls, with the defaults.
// Safety: `config` is null or points to `size` bytes to write.
ThuribleResult thurible_fluids_defaults(ThuribleFluidsConfig *config, size_t size);

// Simulates by what was found, a step at a time: `states` are the N + 1 densities and velocities at the centres of cells, that at the start first, `forces` those
// of the steps 0 .. N - 1, each told of when the step was taken. Either may be null, as `executor` and `observer`. The search may go on afterwards. How it ends is in
// `status`, which must not be null; this returns only refusals.
// Safety: `fluids` as in `thurible_fluids_close`; `executor` and `observer` are null or keep to their contracts; the others are null or may be read and written,
// and their arrays are null or have as many bytes as they say and overlap no other.
ThuribleResult thurible_fluids_replay(ThuribleFluids *fluids,
                                      const ThuribleExecutor *executor,
                                      const ThuribleObserver *observer,
                                      const ThuribleSteps *states,
                                      const ThuribleSteps *forces,
                                      ThuribleStatus *status);

// Writes how many unknowns there are to `count` and copies them into `out` of exactly `bytes` bytes; either may be null. First is the velocity at the start, component after
// component, then forces step after step, then the numbers of each template.
// Safety: `fluids` as in `thurible_fluids_close`; `count` is null or may be written; `out` is null or points to `bytes` bytes to write.
ThuribleResult thurible_fluids_unknowns(ThuribleFluids *fluids,
                                        size_t *count,
                                        void *out,
                                        size_t bytes);

// Template `index` as it is now, from 0 on: its middle and radius, and its first amplitude.
// Safety: `fluids` as in `thurible_fluids_close`; `found` is null or may be written.
ThuribleResult thurible_fluids_template(ThuribleFluids *fluids, size_t index, ThuribleTemplate *found);

// The amplitude that template `index` has at step `step` now, from its `from` to before its `to`: three numbers, of which the template's kind says how many
// count.
// Safety: `fluids` as in `thurible_fluids_close`; `amplitude` is null or points to three numbers to write.
ThuribleResult thurible_fluids_template_amplitude(ThuribleFluids *fluids,
                                                  size_t index,
                                                  size_t step,
                                                  double *amplitude);

// How many bytes `thurible_fluids_save` writes.
// Safety: `scene` and `config` as in `thurible_fluids_plan`; `bytes` is null or may be written.
ThuribleResult thurible_fluids_saved_bytes(const ThuribleConfig *scene, const ThuribleFluidsConfig *config, size_t *bytes);

// Saves the whole state of a search, densities included, as `thurible_save` does: into `bytes` of `size` bytes, `thurible_fluids_saved_bytes` or more.
// Safety: `fluids` as in `thurible_fluids_close`; `bytes` is null or points to `size` bytes to write.
ThuribleResult thurible_fluids_save(ThuribleFluids *fluids,
                                    void *bytes,
                                    size_t size);

// Goes on from what `thurible_fluids_save` wrote, of exactly `thurible_fluids_saved_bytes`, as `thurible_restore` does: threads, ceiling, slots and iterations
// may be others. Every later step gives the same bits; what is damaged or of another scene or choice is refused and changes nothing.
// Safety: `fluids` as in `thurible_fluids_close`; `bytes` is null or points to `size` bytes.
ThuribleResult thurible_fluids_restore(ThuribleFluids *fluids,
                                       const void *bytes,
                                       size_t size);

// One iteration. `executor`, `observer` and `searched` may be null. How a search ends is in `searched`, `THURIBLE_STATUS_NOT_READY` where source or keyframes
// are missing or nothing is searched for; this returns only refusals.
// Safety: `fluids` as in `thurible_fluids_close`; `executor` and `observer` are null or keep to their contracts; `searched` is null or may be written.
ThuribleResult thurible_fluids_step(ThuribleFluids *fluids,
                                    const ThuribleExecutor *executor,
                                    const ThuribleObserver *observer,
                                    ThuribleSearched *searched);

// Iterates to the end; what is found is read by `thurible_fluids_replay`.
// Safety: As `thurible_fluids_step`.
ThuribleResult thurible_fluids_solve(ThuribleFluids *fluids,
                                     const ThuribleExecutor *executor,
                                     const ThuribleObserver *observer,
                                     ThuribleSearched *searched);

// As `thurible_explain`, of an operator's scene and configuration.
// Safety: `scene` and `config` are null or point to configurations whose lists are there; `buffer` is null or points to `size` bytes.
size_t thurible_operator_explain(const ThuribleConfig *scene, const ThuribleOperatorConfig *config, char *buffer, size_t size);

// How many bytes an operator takes, on which multiple of bytes they must begin, how many states it keeps (0 where all that an adjoint reads is kept, or
// nothing), and how many steps a gradient repeats. A null `config` stands for the defaults; each pointer but `scene` may be null.
// Safety: `scene` and `config` are null or point to configurations whose lists are there; the others are null or may be written.
ThuribleResult thurible_operator_plan(const ThuribleConfig *scene,
                                      const ThuribleOperatorConfig *config,
                                      size_t *bytes,
                                      size_t *alignment,
                                      size_t *slots,
                                      size_t *repeated);

// Makes an operator in `memory`, as `thurible_init` makes an instance.
// Safety: `memory` is null or points to `bytes` bytes that nobody else uses; `scene` and `config` as in `thurible_operator_plan`; `out` is null or may be written.
ThuribleResult thurible_operator_init(void *memory,
                                      size_t bytes,
                                      const ThuribleConfig *scene,
                                      const ThuribleOperatorConfig *config,
                                      ThuribleOperator **out);

// Ends an operator: its memory is the caller's again.
// Safety: `operator_` is null or points to memory of an operator's size.
ThuribleResult thurible_operator_close(ThuribleOperator *operator_);

// As `thurible_message`, of the last call with this operator.
// Safety: `operator_` as in `thurible_operator_close`; `buffer` is null or points to `size` bytes.
size_t thurible_operator_message(const ThuribleOperator *operator_, char *buffer, size_t size);

// Sets which cells are solid, before anything is simulated, as `thurible_set_solids`. Refused where `solids` of the scene is 0.
// Safety: `operator_` as in `thurible_operator_close`; `solid` is null or points to `bytes` bytes.
ThuribleResult thurible_operator_set_solids(ThuribleOperator *operator_, const uint8_t *solid, size_t bytes);

// Sets the shape of emitter `index`, as `thurible_set_emitter`.
// Safety: `operator_` as in `thurible_operator_close`; `shape` is null or points to `bytes` bytes.
ThuribleResult thurible_operator_set_emitter(ThuribleOperator *operator_, size_t index, const void *shape, size_t bytes);

// Fills a configuration of `size` bytes, `sizeof(ThuribleOperatorConfig)` of the program that calls, with the defaults.
// Safety: `config` is null or points to `size` bytes to write.
ThuribleResult thurible_operator_defaults(ThuribleOperatorConfig *config, size_t size);

// Bytes of the density of a step, part 0, or of component `part` - 1 of a velocity or force: faces as `thurible_copy` has them, of Stable Fluids centres
// of cells.
// Safety: `operator_` as in `thurible_operator_close`; `bytes` is null or may be written.
ThuribleResult thurible_operator_bytes(const ThuribleOperator *operator_,
                                       size_t part,
                                       size_t *bytes);

// Copies the gradient by the density at the start, part 0, or by component `part` - 1 of the velocity there, as it was given, into `out` of exactly
// `bytes` bytes.
// Safety: `operator_` as in `thurible_operator_close`; `out` is null or points to `bytes` bytes to write.
ThuribleResult thurible_operator_gradient(const ThuribleOperator *operator_,
                                          size_t part,
                                          void *out,
                                          size_t bytes);

// Writes the gradient by the acceleration of buoyancy along x, y and z.
// Safety: `operator_` as in `thurible_operator_close`; `buoyancy` is null or points to three numbers to write.
ThuribleResult thurible_operator_buoyancy(const ThuribleOperator *operator_, double *buoyancy);

// Writes the gradient by the numbers of emitter `index` to `numbers`, and copies that by its shape into `shape` of exactly `bytes` bytes; either may be null.
// Safety: `operator_` as in `thurible_operator_close`; `numbers` is null or may be written; `shape` is null or points to `bytes` bytes to write.
ThuribleResult thurible_operator_emitter(const ThuribleOperator *operator_,
                                         size_t index,
                                         ThuribleEmitterGradient *numbers,
                                         void *shape,
                                         size_t bytes);

// Simulates all steps: from the density of `start`, which may be any finite numbers, and its velocity, at rest where components are null; pushed by
// `forces`, of the steps 0 .. N - 1, beside what the scene has. `states` are the N + 1 densities and velocities, that at the start first. `forces`,
// `states`, `executor` and `observer` may be null. How it ends is in `ran`, which must not be null; this returns only refusals.
// Safety: `operator_` as in `thurible_operator_close`; `executor` and `observer` are null or keep to their contracts; the others are null or may be read and
// written, and their arrays are null or have as many bytes as they say and overlap no other.
ThuribleResult thurible_operator_simulate(ThuribleOperator *operator_,
                                          const ThuribleExecutor *executor,
                                          const ThuribleObserver *observer,
                                          const ThuribleSteps *start,
                                          const ThuribleSteps *forces,
                                          const ThuribleSteps *states,
                                          ThuribleRan *ran);

// The vector-Jacobian product of the last simulation: `cotangents` are what a scalar function gets by the N + 1 densities and velocities, asked for
// from the last to the first; `gradients` what it gets by the forces of the steps N - 1 .. 0, in this order; `thurible_operator_gradient` and the others have the rest. `forces`
// are those of the simulation. Each pointer but `operator_` and `ran` may be null. It may be called again.
// Safety: As `thurible_operator_simulate`.
ThuribleResult thurible_operator_vjp(ThuribleOperator *operator_,
                                     const ThuribleExecutor *executor,
                                     const ThuribleObserver *observer,
                                     const ThuribleSteps *forces,
                                     const ThuribleSteps *cotangents,
                                     const ThuribleSteps *gradients,
                                     ThuribleRan *ran);

// How many bytes of memory, from a multiple of 8 on, `thurible_condense_plan` and `thurible_condense_explain` work in: who is joined to whom decides how many a
// condenser takes.
// Safety: `config` is null or points to a configuration; `bytes` is null or may be written.
ThuribleResult thurible_condense_scratch(const ThuribleCondenseConfig *config,
                                         size_t *bytes);

// As `thurible_explain`, of a body and how it is condensed.
// Safety: `config` and `scratch` as in `thurible_condense_plan`; `buffer` is null or points to `size` bytes.
size_t thurible_condense_explain(const ThuribleCondenseConfig *config,
                                 void *scratch,
                                 size_t scratch_bytes,
                                 char *buffer,
                                 size_t size);

// How many bytes a condenser takes, with copies of its body's lists, and on which multiple of bytes they must begin. `scratch`, of `scratch_bytes` bytes,
// `thurible_condense_scratch` or more, is written over and free again afterwards; `bytes` and `alignment` may be null.
// Safety: `config` is null or points to a configuration whose lists are there; `scratch` is null or points to as many bytes, which overlap nothing else;
// the others are null or may be written.
ThuribleResult thurible_condense_plan(const ThuribleCondenseConfig *config,
                                      void *scratch,
                                      size_t scratch_bytes,
                                      size_t *bytes,
                                      size_t *alignment);

// Makes a condenser in `memory`, as `thurible_init` makes an instance: a body at rest.
// Safety: `memory` is null or points to `bytes` bytes that nobody else uses; `config` as in `thurible_condense_plan`; `out` is null or may be written.
ThuribleResult thurible_condense_init(void *memory,
                                      size_t bytes,
                                      const ThuribleCondenseConfig *config,
                                      ThuribleCondenser **out);

// Ends a condenser: its memory is the caller's again.
// Safety: `condenser` is null or points to memory of a condenser's size.
ThuribleResult thurible_condense_close(ThuribleCondenser *condenser);

// As `thurible_message`, of the last call with this condenser.
// Safety: `condenser` as in `thurible_condense_close`; `buffer` is null or points to `size` bytes.
size_t thurible_condense_message(const ThuribleCondenser *condenser, char *buffer, size_t size);

// Fills a configuration of `size` bytes, `sizeof(ThuribleCondenseConfig)` of the program that calls, with the defaults.
// Safety: `config` is null or points to `size` bytes to write.
ThuribleResult thurible_condense_defaults(ThuribleCondenseConfig *config, size_t size);

// Copies what `part`, a `ThuribleCondensePart`, says of all vertices into `out` of exactly `bytes` bytes: `dimensions` numbers for each vertex.
// Safety: `condenser` as in `thurible_condense_close`; `out` is null or points to `bytes` bytes to write.
ThuribleResult thurible_condense_read(ThuribleCondenser *condenser,
                                      uint32_t part,
                                      double *out,
                                      size_t bytes);

// The next step: every vertex, held or not, is moved by `shift`, `dimensions` numbers for each and `shift_bytes` in all (null and 0 for none), `gravity`, three
// numbers or null, accelerates all, and the energy is minimised. The states before each iteration and at the end are written to the first `room` entries of
// `states`. `executor`, `observer`, `states` and `stepped` may be null. How it ends is in `stepped`; this returns only refusals, before anything has changed.
// Safety: `condenser` as in `thurible_condense_close`; `executor` and `observer` are null or keep to their contracts; `shift` is null or points to `shift_bytes`
// bytes, `gravity` to three numbers, `states` to `room` entries to write; `stepped` is null or may be written.
ThuribleResult thurible_condense_step(ThuribleCondenser *condenser,
                                      const ThuribleExecutor *executor,
                                      const ThuribleObserver *observer,
                                      const double *shift,
                                      size_t shift_bytes,
                                      const double *gravity,
                                      ThuribleIteration *states,
                                      size_t room,
                                      ThuribleCondensed *stepped);

// Adds `shift`, `dimensions` numbers for each vertex and `bytes` in all, to their displacements.
// Safety: `condenser` as in `thurible_condense_close`; `shift` is null or points to `bytes` bytes.
ThuribleResult thurible_condense_shift(ThuribleCondenser *condenser, const double *shift, size_t bytes);

// Gives free vertices a velocity, `dimensions` numbers for each vertex and `bytes` in all, before an implicit step; refused where `dt` is 0.
// Safety: `condenser` as in `thurible_condense_close`; `velocity` is null or points to `bytes` bytes.
ThuribleResult thurible_condense_set_velocity(ThuribleCondenser *condenser,
                                              const double *velocity,
                                              size_t bytes);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* THURIBLE_H */

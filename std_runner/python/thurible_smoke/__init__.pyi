"""Steers smoke: finds the smallest force field that makes an incompressible flow of smoke pass through keyframes.

Arrays have the shape (ny, nx) or (nz, ny, nx); their dtype, float32 or float64, is the precision of the solve.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, TypedDict, final

import numpy as np
from numpy.typing import DTypeLike, NDArray

__version__: str

Numbers: TypeAlias = NDArray[np.float32] | NDArray[np.float64]
Boundary: TypeAlias = Literal["wall", "periodic", "open", "open_low", "open_high"]
Method: TypeAlias = Literal["direct", "admm", "lbfgs", "pd", "simulate", "templates", "guide"]
Advection: TypeAlias = Literal["quick", "central", "semi_lagrangian", "limited"]

class Options(TypedDict, total=False):
    """Options of the method that was chosen; others are refused."""

    history: int | Literal["auto"] | None
    """direct, lbfgs, templates: pairs that the search remembers."""
    history_precision: Literal["full", "half"]
    """direct, lbfgs: in how many bytes their numbers are kept; half is bfloat16 for float32, and float32 for float64."""
    tolerance: float
    """direct, lbfgs, templates: relative decrease of the objective at which it stops; simulate: where a step stops."""
    nested: bool
    """direct, admm, lbfgs: whether coarser grids are solved first."""
    coarse_iterations: int | Literal["auto"] | None
    """direct: iterations at most on each coarser grid; more find cheaper ways where a shape changes much."""
    coarse_force_weight: float
    """direct: what the force's weight is multiplied by from each grid to the next coarser one, above 0 and below 100."""
    penalty: float
    relaxation: float
    ao_iterations: int
    ao_momentum: float
    density_tolerance: float
    nso: Literal["stfas", "newton_cg"]
    nso_tolerance: float
    nso_cycles: int
    nso_norm: Literal["scaled", "plain"]
    smoother_colours: Literal["red_black", "2^d"]
    drive: float
    attenuation: float
    gathering: float
    radius: float
    """guide: what is larger than so many cells follows `reference`."""
    smoothness: float
    kinetic: float
    iterations: int
    solver: Literal["auto", "closed_form", "admm"]
    curl_noise: float
    """guide: noise without divergence that stirs each step, in cells a step."""
    noise_sigma: float
    noise_seed: int

Emitter = TypedDict(
    "Emitter",
    {"shape": Numbers, "from": int, "to": int, "rate": float, "target": float, "velocity": Sequence[float]},
    total=False,
)
"""Smoke that is made on the way from step `from` (0 unless given) to step `to` (the last): where `shape` is 1, `rate` is added to the
density at every step, or what is missing of `target`. One of the two is given. The flow within it is taken to `velocity`, if
that is given, while it emits."""

Template = TypedDict(
    "Template",
    {
        "kind": Literal["wind", "vortex", "noise", "attract"],
        "center": Sequence[float],
        "radius": float,
        "from": int,
        "to": int,
        "interval": int,
        "move": bool,
        "amplitude": float | Sequence[float],
        "size": float,
        "seed": int,
    },
    total=False,
)
"""Part of a force that fades with the distance from `center` within about `radius`, in the steps `from` (0 unless given) to before `to` (the
end), with one amplitude for every `interval` steps (one for all). `move` makes center and radius unknowns too; `amplitude` is where the search
begins. `size` and `seed` belong to noise."""

def solve(
    source: Numbers | None,
    keyframes: Mapping[int, Numbers] | Iterable[tuple[int, Numbers]],
    *,
    steps: int | None = None,
    dt: float = 1.0,
    length: float = 1.0,
    boundary: Boundary | Sequence[Boundary] = "wall",
    viscosity: float = 0.0,
    slip: bool = True,
    buoyancy: float | Sequence[float] = 0.0,
    emitters: Sequence[Emitter] | None = None,
    templates: Sequence[Template] | None = None,
    solids: NDArray[np.bool_] | None = None,
    force_weight: float | None = None,
    smoothness: float | Literal["auto"] | None = None,
    schedule: Mapping[int, float] | Iterable[tuple[int, float]] | None = None,
    mask: Numbers | None = None,
    weights: Mapping[int, float] | Iterable[tuple[int, float]] | None = None,
    regions: Mapping[int, Numbers] | Iterable[tuple[int, Numbers]] | None = None,
    release: int | None = None,
    filters: int | Literal["auto"] | None = None,
    match_mass: bool = True,
    advection: Advection = "limited",
    advection_tolerance: float = 1e-5,
    projection_tolerance: float = 1e-5,
    initial_velocity: Sequence[Numbers] | None = None,
    reference: Sequence[Numbers] | None = None,
    method: Method | None = None,
    options: Options | None = None,
    iterations: int = 60,
    threads: int | None = None,
    memory_limit: int | None = None,
    progress: Callable[[Progress], bool | None] | None = None,
    checkpoint: str | PathLike[str] | None = None,
    checkpoint_every: float = 60.0,
    resume: str | PathLike[str] | None = None,
) -> Solution:
    """Finds the smallest force that carries the smoke of `source` to `keyframes`: arrays by the step at which they stand.

    `steps` is the last keyframe's unless given. `length` is the longest side of the box. `force_weight` is 1e3 dt^4 / length^2 unless given. `boundary` is a word, or one for each of x, y
    (and z). `smoothness` counts cells of which forces finer are dear: 2.5 with limited transport and 0 with the others unless given; "admm"
    takes 0 alone. `initial_velocity` are components along x, y (and z), with shapes as those of `Solution.velocity`; so are those of `reference`, the
    flow that "guide" follows, with an entry for each of `steps`. `threads` are as many as
    the machine offers. `memory_limit` is in bytes, of the one block in which it is solved.

    `source` may be None where `emitters` make all smoke. `buoyancy` is the acceleration of the flow where the density is 1: a number, up
    along the last of x, y (and z), or one for each of them. Without `slip` the flow sticks to walls and solids, by its `viscosity`. `solids` is True in cells that no smoke gets into, with
    limited transport. `schedule` says by step what the price of the force is
    multiplied by (not for "admm"): linear in its logarithm between the steps. `mask` says where force
    may act, in each cell from 0 (as good as nowhere) to 1, in between at 1 / mask^2 times the price (not for "admm"). `weights` and `regions` belong to keyframes, by their steps:
    what the error of one is multiplied by, as a whole, and in each cell by an array of numbers from 0 to 1; 1 where nothing is said. From
    step `release` on, at or after the last keyframe, no force acts.

    With `templates` the force is made of them alone, and the method is "templates" unless another is given: it searches for their amplitudes;
    "simulate" takes them as they are given, and the others know none. `method` is "direct" where there are none.

    `checkpoint` is a file that the state is kept in after an iteration, every `checkpoint_every` seconds. With `resume`, such a file, and the same
    arrays and choices, the solve goes on from there and gives the same bits; `threads` and `memory_limit` may be others, unless fewer pairs of
    L-BFGS fit. A state of other arrays or choices, or one that is damaged, is a ValueError.

    `progress` is called after every iteration; it stops the solve by returning False, or by raising. Other Python threads run
    meanwhile.

    Raises ValueError or TypeError for what cannot be used, MemoryError for what does not fit, FloatingPointError when the flow leaves
    the finite numbers.
    """

def plan(
    shape: Sequence[int],
    keyframes: Iterable[int],
    *,
    dtype: DTypeLike = "float32",
    steps: int | None = None,
    dt: float = 1.0,
    length: float = 1.0,
    boundary: Boundary | Sequence[Boundary] = "wall",
    viscosity: float = 0.0,
    slip: bool = True,
    buoyancy: float | Sequence[float] = 0.0,
    emitters: Sequence[Emitter] | None = None,
    templates: Sequence[Template] | None = None,
    solids: NDArray[np.bool_] | bool | None = None,
    force_weight: float | None = None,
    smoothness: float | Literal["auto"] | None = None,
    schedule: Mapping[int, float] | Iterable[tuple[int, float]] | None = None,
    mask: Numbers | bool | None = None,
    weights: Mapping[int, float] | Iterable[tuple[int, float]] | None = None,
    regions: Mapping[int, Numbers] | Iterable[tuple[int, Numbers]] | bool | None = None,
    release: int | None = None,
    filters: int | Literal["auto"] | None = None,
    match_mass: bool = True,
    advection: Advection = "limited",
    advection_tolerance: float = 1e-5,
    projection_tolerance: float = 1e-5,
    method: Method | None = None,
    options: Options | None = None,
    iterations: int = 60,
    threads: int | None = None,
    memory_limit: int | None = None,
) -> Plan:
    """The memory of a solve, to the byte; nothing is allocated. `keyframes` are steps, or the dict that `solve` takes.

    Emitters need no shape here, and `solids`, `mask` and `regions` may be True."""

def track(
    frames: Numbers,
    *,
    boundary: Literal["wall", "periodic"] | Sequence[Literal["wall", "periodic"]] = "wall",
    length: float = 1.0,
    dt: float = 1.0,
    density_scale: float | None = None,
    buoyancy: float = 0.0,
    initial_velocity: Sequence[Numbers] | None = None,
    emission: Numbers | None = None,
    method: Literal["direct", "admm", "horn_schunck"] = "direct",
    options: Mapping[str, Any] | None = None,
    threads: int | None = None,
    memory_limit: int | None = None,
) -> Track:
    """Finds the flow behind frames of smoke, an array of shape (frames, ny, nx) or (frames, nz, ny, nx).

    `emission`, of shape (frames - 1, ..), is what was made between a frame and the next. `options` are those of `[track]` in a capture file:
    alpha, beta, levels, predict and so on."""

def tomography(
    pictures: Sequence[Numbers],
    cameras: Sequence[Mapping[str, Any]],
    cells: Sequence[int],
    *,
    novel: Sequence[Mapping[str, Any]] | None = None,
    method: Literal["walk", "sart"] = "walk",
    prior: Literal["none", "l2", "tv", "sad", "image_tv", "image_sad"] = "sad",
    gamma: float | Literal["auto"] = "auto",
    options: Mapping[str, Any] | None = None,
    memory_limit: int | None = None,
) -> Tomography:
    """Finds the density of smoke in (nx, ny) or (nx, ny, nz) cells from what cameras see of it.

    A picture has the shape (rows, columns), in a plane (columns,), with frames before them where there are several. `cameras` and `novel` are
    dicts as in report.json of `thurible tomography`, in cells: kind, across, down, forward, at, pitch or eye; novel views, which measured
    nothing, have pixels = [across, down]. `options` are those of `[tomography]` in a file of views."""

@final
class Tomography:
    """The density behind pictures."""

    @property
    def density(self) -> Numbers | None:
        """Of shape (ny, nx) or (nz, ny, nx), after frames where there are some; None where options say volume False, as priors of pictures can."""
    @property
    def reprojected(self) -> tuple[Numbers, ...]:
        """What each camera would see of it."""
    @property
    def novel(self) -> tuple[Numbers, ...]:
        """What each novel view shows."""
    @property
    def history(self) -> list[dict[str, Any]]:
        """What is said of each frame that is not dark."""
    @property
    def gamma(self) -> float:
        """How much of the prior was charged."""
    @property
    def planned_bytes(self) -> int:
        """Bytes of the block."""

@final
class Track:
    """The flow behind frames of smoke: N pairs."""

    @property
    def velocity(self) -> tuple[Numbers, ...]:
        """The flow of each pair along x, y (and z), of shape (N, faces)."""
    @property
    def predicted(self) -> tuple[Numbers, ...]:
        """What it was before the frames of a pair were looked at."""
    @property
    def correction(self) -> tuple[Numbers, ...]:
        """What was added to that."""
    @property
    def force(self) -> tuple[Numbers, ...] | None:
        """The force from the flow of each pair to the next, of shape (N - 1, faces); None but where options say forces True."""
    @property
    def density(self) -> Numbers | None:
        """The first frame carried by the flow, of the shape of the frames; None where options say readvect False."""
    @property
    def history(self) -> list[dict[str, Any]]:
        """What is said of each pair, as in report.json."""
    @property
    def density_scale(self) -> float:
        """What densities were multiplied by."""
    @property
    def remarks(self) -> list[str]:
        """Sentences about frames that no flow makes of the ones before; mostly none."""
    @property
    def planned_bytes(self) -> int:
        """Bytes of the block."""
    @property
    def threads(self) -> int:
        """Threads that it ran on."""

@final
class Plan:
    """The memory of a solve."""

    @property
    def bytes(self) -> int:
        """Bytes of the whole block."""
    @property
    def method_bytes(self) -> int:
        """Bytes of the method: all but the keyframes."""
    @property
    def paper_bound(self) -> int:
        """What the paper's method may take, in bytes."""
    @property
    def threads(self) -> int:
        """Threads planned for."""
    @property
    def ledger(self) -> list[tuple[str, int, int]]:
        """Every buffer: its name, its bytes, its depth in the tree; groups come before what they hold."""

@final
class Progress:
    """What one iteration did."""

    @property
    def iteration(self) -> int:
        """From 1, iterations on coarser grids included."""
    @property
    def seconds(self) -> float:
        """Since the solve began."""
    @property
    def objective(self) -> float:
        """`data + force`; values of one grid cannot be compared with those of another."""
    @property
    def data(self) -> float:
        """Distance from the keyframes."""
    @property
    def force(self) -> float:
        """Price of the force."""
    @property
    def cells(self) -> list[int] | None:
        """Cells along x, y (and z) of the grid that it worked on, where the method tells."""
    @property
    def step(self) -> float | None:
        """Step along the direction, of direct and lbfgs; blending step of admm."""
    @property
    def density_change(self) -> float | None:
        """admm: largest change of the densities, in parts of the source's largest."""
    @property
    def gap(self) -> float | None:
        """admm: max |v - v*| over max |v|."""
    @property
    def kkt(self) -> float | None:
        """admm: the largest violation of the conditions of an optimum."""
    @property
    def facts(self) -> dict[str, float | int | bool | list[float]]:
        """All that the method reported, by name: a number, a count, a truth value, or a list of numbers."""
    @property
    def fact_words(self) -> dict[str, str]:
        """What each of the facts is, in a few words, by name."""

@final
class Output:
    """Something that the method gives: a field for each of many steps."""

    @property
    def name(self) -> str:
        """Its name."""
    @property
    def words(self) -> str:
        """What it is, in a few words."""
    @property
    def place(self) -> Literal["cells", "faces"]:
        """At the centres of cells, or on faces: a component along each axis, on the faces across it."""
    @property
    def unit(self) -> Literal["density", "velocity", "force"]:
        """In what it is measured."""
    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """An array for each component, of shape (its steps, (nz,) ny, nx) as `result.npz` has it, in the scene's units.

        The solver's own memory where it lies so, and else made when first asked for."""

@final
class Solution:
    """A result. Its arrays cannot be written to and keep it alive; copy what you want to change."""

    @property
    def outputs(self) -> dict[str, Output]:
        """All that the method gives, by name; `density`, `velocity` and `force` are among it."""
    @property
    def density(self) -> NDArray[Any]:
        """Densities, of shape (steps + 1, (nz,) ny, nx): the solver's own memory."""
    @property
    def velocity(self) -> tuple[NDArray[Any], ...]:
        """Velocities along x, y (and z), of shape (steps, (nz,) ny, nx), and on a wall axis one more along it.

        The arrays are made when they are first asked for, and stay."""
    @property
    def force(self) -> tuple[NDArray[Any], ...]:
        """Forces, as `velocity`, of steps - 1 entries: entry k turns velocity k into velocity k + 1."""
    @property
    def emission(self) -> NDArray[Any] | None:
        """What emitters added to the density after each step, of shape (steps, (nz,) ny, nx); None where there are none."""
    @property
    def emitter_force(self) -> tuple[NDArray[Any], ...] | None:
        """What emitters with a velocity added beside the forces, along x, y (and z) and of the same shape; None where there are none."""
    @property
    def velocity_in_place(self) -> tuple[NDArray[Any], ...]:
        """Velocities 1 .. steps - 1 as they lie in the solver's memory: nothing is copied.

        Each cell has its low face, so that the last walls are left out; times `velocity_unit` they are in the scene's units."""
    @property
    def force_in_place(self) -> tuple[NDArray[Any], ...]:
        """Forces, as `velocity_in_place`; times `force_unit` they are in the scene's units."""
    @property
    def velocity_unit(self) -> float:
        """length / dt."""
    @property
    def force_unit(self) -> float:
        """length / dt^2."""
    @property
    def objective(self) -> float:
        """`data_term + force_term`."""
    @property
    def data_term(self) -> float:
        """Distance from the keyframes."""
    @property
    def force_term(self) -> float:
        """Price of the force."""
    @property
    def status(self) -> Literal["converged", "max_iterations", "stalled", "cancelled"]:
        """Why the solve stopped."""
    @property
    def history(self) -> list[Progress]:
        """All iterations, of a solve that went on from a state those since then."""
    @property
    def keyframe_steps(self) -> list[int]:
        """Steps of the keyframes, ascending."""
    @property
    def keyframe_errors(self) -> list[float]:
        """How far the densities are from each keyframe: |R (rho - rho*)| / |R rho*| with its region R, 1 where there is none."""
    @property
    def keyframe_errors_before(self) -> list[float]:
        """How far the source, held still, is from each keyframe."""
    @property
    def templates(self) -> list[dict[str, Any]]:
        """The templates of the force as they were found, with the keys that they are given by: an amplitude for each interval."""
    @property
    def remarks(self) -> list[str]:
        """Sentences about what the status alone does not say, as that the smoke came no nearer; mostly none."""
    @property
    def mass_factors(self) -> list[float]:
        """By how much each keyframe was scaled to the mass of the smoke at its step."""
    @property
    def planned_bytes(self) -> int:
        """Bytes of the one block in which it was solved, which the solution holds on to."""
    @property
    def threads(self) -> int:
        """Threads on which it was solved."""

@final
class StableFluids:
    """What a search by Stable Fluids found: everything at the centres of cells."""

    @property
    def density(self) -> Numbers:
        """Densities, (steps + 1, (nz,) ny, nx)."""
    @property
    def velocity(self) -> tuple[Numbers, ...]:
        """Velocities along x, y (and z), each of the shape of `density`."""
    @property
    def force(self) -> tuple[Numbers, ...]:
        """Forces, those of templates among them, (steps, (nz,) ny, nx) each."""
    @property
    def templates(self) -> list[dict[str, Any]]:
        """Templates as they were found, with the keys that they are given by: an amplitude for each interval."""
    @property
    def objective(self) -> float:
        """`data_term + force_term + initial_term`."""
    @property
    def data_term(self) -> float:
        """Distance from the keyframes."""
    @property
    def force_term(self) -> float:
        """Price of the force."""
    @property
    def initial_term(self) -> float:
        """Price of the velocity at the start."""
    @property
    def status(self) -> Literal["converged", "max_iterations", "stalled", "cancelled"]:
        """Why the search stopped."""
    @property
    def history(self) -> list[Progress]:
        """All iterations, of a solve that went on from a state those since then."""
    @property
    def mass_factors(self) -> list[float]:
        """By how much each keyframe was scaled to the mass of the source."""
    @property
    def planned_bytes(self) -> int:
        """Bytes of the block in which it was searched."""
    @property
    def slots(self) -> int:
        """States that were kept; 0 where all that the adjoint reads was."""
    @property
    def repeated_steps(self) -> int:
        """Steps that a gradient repeats."""
    @property
    def threads(self) -> int:
        """Threads on which it ran."""

def stable_fluids(
    source: Numbers,
    keyframes: Mapping[int, Numbers] | Iterable[tuple[int, Numbers]],
    *,
    control: Literal["initial_velocity", "forces", "templates"] | Sequence[str] = "initial_velocity",
    steps: int | None = None,
    dt: float = 1.0,
    length: float = 1.0,
    boundary: Boundary | Sequence[Boundary] = "wall",
    viscosity: float = 0.0,
    buoyancy: float | Sequence[float] = 0.0,
    templates: Sequence[Template] | None = None,
    force_weight: float | None = None,
    weights: Mapping[int, float] | Iterable[tuple[int, float]] | None = None,
    filters: int | Literal["auto"] | None = None,
    match_mass: bool = True,
    initial_velocity: Sequence[Numbers] | None = None,
    options: Mapping[str, Any] | None = None,
    slots: int | Literal["auto"] = "auto",
    iterations: int = 60,
    threads: int | None = None,
    memory_limit: int | None = None,
    progress: Callable[[Progress], bool | None] | None = None,
    checkpoint: str | PathLike[str] | None = None,
    checkpoint_every: float = 60.0,
    resume: str | PathLike[str] | None = None,
) -> StableFluids:
    """Searches for what carries the smoke of `source` through `keyframes` by Stable Fluids, for the controls that are named.

    All others are as `solve` takes them; templates are winds and vortices, `options` those of `[method.stable_fluids]` in a scene. Keyframes may be at step 1.
    slots=0 keeps all that the adjoint reads."""

@final
class Condenser:
    """An elastic body whose energy is minimised step by step, in planned memory (docs/condense.md).

    Called with rest (vertices, axes), 1 to 3 axes, elements (elements, axes + 1), held (vertices,), and by name springs (tuples of two vertices, stiffness
    and rest length), young, poisson, density, area (of rods), method ("cc", "newton", "plain", "jgs2", "jgs2_local", "projected", "chord", "warped"), basis
    ("fixed", "rebuilt", "corotated", "corotated_rebuilt", "adaptive", "corotated_adaptive"), rebuild, radius, order, block, tolerance, cap, search,
    dt (implicit steps; None is quasi-static), dtype, threads, memory_limit.
    """

    def __new__(cls, rest: Numbers, elements: NDArray[Any], held: NDArray[np.bool_], **choices: Any) -> Condenser: ...
    def step(self, shift: Numbers | None = None, gravity: Sequence[float] | None = None) -> dict[str, Any]:
        """The next step: "status", "iterations", "builds", and arrays "energy", "residual", "length" before each iteration and at the end.

        Every vertex, held or not, is moved by shift first, (vertices, axes). One that Ctrl-C ends counts as done, as far as it came: `steps` says so, and
        `step()` without a shift goes on from there."""
    def set_velocity(self, velocity: Numbers) -> None:
        """Gives free vertices a velocity before an implicit step."""
    @property
    def position(self) -> NDArray[np.float64]:
        """Where the vertices are, (vertices, axes)."""
    @property
    def gradient(self) -> NDArray[np.float64]:
        """The gradient of the energy when it was made last, (vertices, axes); 0 of held vertices."""
    @property
    def steps(self) -> int:
        """Steps that are done."""
    @property
    def builds(self) -> int:
        """Builds of the basis, or of its factor, so far."""
    @property
    def planned_bytes(self) -> int:
        """Bytes of its block."""

@final
class Gradient:
    """What a scalar function of a simulation gets by what the simulation follows from."""

    @property
    def density(self) -> Numbers:
        """By the density at the start."""
    @property
    def velocity(self) -> tuple[Numbers, ...]:
        """By the components of the velocity at the start, as it was given."""
    @property
    def forces(self) -> tuple[Numbers, ...] | None:
        """By the components of the forces, (steps, faces); None where the simulation was given none."""
    @property
    def buoyancy(self) -> list[float]:
        """By the acceleration of buoyancy along x, y (and z)."""
    @property
    def emitters(self) -> list[dict[str, Any]]:
        """Of each emitter "supply" (by its rate or target), "velocity" (None where it has none) and "shape"."""

@final
class Operator:
    """A simulation as an operator, and its exact adjoint, in planned memory.

    Called with shape (ny, nx) or (nz, ny, nx) and steps, and by name dtype="float64", dt, length, boundary, viscosity, slip, buoyancy, emitters, templates,
    solids, advection, advection_tolerance, projection_tolerance as `solve`, tolerance=1e-10 (what steps leave, and about the relative error of
    gradients), slots="auto" (states that are kept), threads, memory_limit.

    solver="stable_fluids" simulates by Stable Fluids: everything is at the centres of cells, so that components have the shape of a density; it knows no
    emitters, solids or open ends, slots=0 keeps all that its adjoint reads, and `options` are pressure, sweeps, cg_iterations, cg_tolerance, adjoint
    and diffusion.
    """

    def __new__(cls, shape: Sequence[int], steps: int, **choices: Any) -> Operator: ...
    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a density."""
    @property
    def faces(self) -> tuple[tuple[int, ...], ...]:
        """Shapes of the components of a velocity or force along x, y (and z): of faces, or of cells with Stable Fluids."""
    @property
    def steps(self) -> int:
        """Steps."""
    @property
    def dtype(self) -> Literal["float32", "float64"]:
        """Of all arrays."""
    @property
    def slots(self) -> int:
        """States that are kept."""
    @property
    def repeated_steps(self) -> int:
        """Steps that a gradient repeats beside the one for each step that it takes back, the simulation counted."""
    @property
    def runs(self) -> int:
        """Simulations that were begun."""
    @property
    def planned_bytes(self) -> int:
        """Bytes of its block."""
    @property
    def next_slot_bytes(self) -> int | None:
        """Bytes with one state more; None where every step has one."""
    def simulate(
        self,
        density: Numbers,
        velocity: Sequence[Numbers] | None = None,
        forces: Sequence[Numbers] | None = None,
        *,
        at: Sequence[int] | None = None,
    ) -> tuple[Numbers, tuple[Numbers, ...]]:
        """Densities (steps + 1, ..) and components of velocities (steps + 1, faces), or those of the steps in `at` alone.

        Forces (steps, faces) are borrowed until `vjp`."""
    def vjp(
        self,
        density: Numbers | Mapping[int, Numbers] | None = None,
        velocity: Sequence[Numbers] | Mapping[int, Sequence[Numbers]] | None = None,
    ) -> Gradient:
        """The gradient of a scalar function of the last simulation by its covectors, of all steps or of single ones."""

//! A device: a machine with a memory of its own, as a graphics card, on which the direct method searches a flow.
//!
//! The descent, nested starts, stopping rules and reports are those of the core. A device brings what they ask of whole fields, each verb a
//! row of the table in `docs/operators.md`. It computes in `f32`; fields are its own from [`Device::begin`] on, and come back where somebody
//! asks for them. One search at a time is on a device: what is set, saved or solved by others meanwhile, it does not hear of.

use core::fmt::Debug;
use core::ops::Range;

/// What the memory of a search on one grid follows from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// Axes, 2 or 3.
    pub dims: usize,
    /// Cells along x, y and z, 1 along z in 2D.
    pub cells: [usize; 3],
    /// Slots T of v_1 .. v_T; there are T + 2 densities.
    pub slots: usize,
    /// Fields of L-BFGS.
    pub fields: usize,
    /// Keyframes.
    pub keyframes: usize,
    /// Whether they have regions.
    pub regions: bool,
    /// Emitters.
    pub emitters: usize,
    /// Whether there are solid cells, or cells outside of open sides.
    pub solids: bool,
    /// Whether there are obstacles among them.
    pub obstacles: bool,
    /// Whether the price of the force differs from place to place.
    pub masked: bool,
    /// Whether the force has another price than its square.
    pub weighs: bool,
    /// Filters of the metric.
    pub filters: usize,
}

/// A search on one grid, by limited transport.
pub struct Search<'a> {
    /// How large it is.
    pub room: Room,
    /// 1 / h along each axis, in box lengths.
    pub inverse: [f64; 3],
    /// Which axes are rings; the others end at walls or open sides.
    pub rings: [bool; 3],
    /// The cells inside along each axis; those before and after are outside of open sides.
    pub inside: [Range<usize>; 3],
    /// nu.
    pub viscosity: f64,
    /// r.
    pub force_weight: f64,
    /// s^2 of the price 1 + s^2 C^T C, 0 where there is none.
    pub smoothing: f64,
    /// Factor of the price in a slot, where it changes from slot to slot.
    pub factor: Option<&'a dyn Fn(usize) -> f64>,
    /// Lengths of the steps by which that price is divided out: see [`force::price`](crate::force::price).
    pub lengths: &'a dyn Fn(usize) -> Option<f64>,
    /// Least value of the mask of a face where it divides the metric; its price has [`LEAST`](crate::force::mask::LEAST).
    pub least_of_mask: f64,
    /// b: the acceleration by a density of 1; see [`force::lift`](crate::force::lift).
    pub buoyancy: [f64; 3],
    /// What emitter `i` does when the density has come to a step: `(step, i)`; see [`Script::supply`](crate::objective::script::Script::supply).
    pub supply: &'a dyn Fn(usize, usize) -> Option<[f64; 2]>,
    /// The velocity to which it pushes v_k: `(k, i)`; see [`Script::jet`](crate::objective::script::Script::jet).
    pub jet: &'a dyn Fn(usize, usize) -> Option<[f64; 3]>,
    /// Reciprocal pivots of the time line, and minus the entries beside the diagonal: see [`force::time_line`](crate::force::time_line).
    pub pivots: &'a [f64],
    /// See there.
    pub coupling: f64,
    /// Courant number of a sub-step at most, and of a step.
    pub courant: [f64; 2],
    /// Values of a stage of transport below this are 0.
    pub negligible: f64,
    /// Part of the divergence that a projection may leave among solid cells: of a force or a gradient.
    pub projection_tolerance: f64,
    /// Step and weight of a keyframe.
    pub keyframe: &'a dyn Fn(usize) -> Option<(usize, f64)>,
    /// Weight of e itself in the metric.
    pub identity: f64,
    /// Value `i` of eigenvector `k` along an axis: `[axis, k, i]`; see [`grid::spectrum`](crate::grid::spectrum).
    pub vector: &'a dyn Fn([usize; 3]) -> f64,
    /// Its eigenvalue of -div grad: `[axis, k]`.
    pub eigenvalue: &'a dyn Fn([usize; 2]) -> f64,
    /// That of filter `j`, from 1, applied twice: `[axis, j, k]`.
    pub blur: &'a dyn Fn([usize; 3]) -> f64,
}

/// A field of cells, or of the faces along an axis, by its place on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A component of v_k: step k, from 0, and the axis.
    Flow(usize, usize),
    /// rho_k.
    Density(usize),
    /// What a keyframe wants, by its number.
    Target(usize),
    /// Where it does.
    Region(usize),
    /// The shape of an emitter, by its number.
    Emitter(usize),
    /// Where force may act.
    Mask,
    /// The table of solid cells, each with its bits as a number: see [`grid::solids`](crate::grid::solids).
    Solids,
    /// A component of a field of L-BFGS: its number, the slot, the axis.
    Field(usize, usize, usize),
}

/// Inner products of the gradient at a new point: with s and z of a pair each, and others.
#[derive(Clone, Copy, Debug, Default)]
pub struct WithGradient {
    /// <g, P g>.
    pub norm: f64,
    /// With the step that led there, and with P times the gradient before.
    pub step: [f64; 2],
}

/// A step on a device: how many times the field of the direction it is, and the fields of the direction and of P g before.
#[derive(Clone, Copy, Debug)]
pub struct Stride {
    /// How many times the direction.
    pub length: f64,
    /// The field of the direction, which becomes the step.
    pub direction: usize,
    /// The field of P g before, which becomes the change of P g.
    pub preconditioned: usize,
}

/// The flow is too fast to be transported, or not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFinite;

/// What a search asks of a device. Fields of L-BFGS go by their numbers. A device that fails answers with numbers that are not finite, and tells
/// whoever brought it why.
pub trait Device: Sync + Debug {
    /// Makes room for a search, in the place of the one before.
    fn begin(&self, search: &Search<'_>);
    /// Takes a field, row by row.
    fn write(&self, place: Place, row: &mut dyn FnMut(usize, &mut [f32]));
    /// Gives a field, row by row.
    fn read(&self, place: Place, row: &mut dyn FnMut(usize, &[f32]));
    /// Field `into` = the sum of `factor` times a field each.
    fn form(&self, into: usize, terms: &mut dyn Iterator<Item = (f64, usize)>);
    /// max |div d| h_x / max |d| of a field, and max |d|.
    fn divergence(&self, field: usize) -> [f64; 2];
    /// Projects a field, once; among solid cells until at most this part of its divergence is left.
    fn project(&self, field: usize, tolerance: f64);
    /// v += s times a field.
    fn advance(&self, field: usize, s: f64);
    /// v = v_0 + keep (v - v_0) in all slots.
    fn retreat(&self, keep: f64);
    /// Carries the density along v, and writes the force of v: the data term, the force's price and its plain square, each with its weight.
    ///
    /// # Errors
    /// [`NotFinite`].
    fn value(&self, force: usize) -> Result<[f64; 3], NotFinite>;
    /// The gradient at v of the last [`Self::value`], from that force.
    ///
    /// # Errors
    /// [`NotFinite`].
    fn gradient(&self, force: usize, into: usize) -> Result<(), NotFinite>;
    /// Field `image` = P times the gradient, and the gradient's inner products; those with the fields of `pairs` go to `products`.
    fn arrive(
        &self,
        gradient: usize,
        image: usize,
        step: Option<Stride>,
        pairs: &mut dyn Iterator<Item = [usize; 2]>,
        products: &mut dyn FnMut([f64; 2]),
    ) -> WithGradient;
}

//! What the scratch of a group of cells holds: offsets, in vectors.

use super::form::Form;
use super::reflection::Place;
use crate::grid::Space;
use crate::real::Real;
use crate::simd::Vector;
use core::marker::PhantomData;

/// Changes of a cell in one slot: dv and dw at its faces, dp and dpbar.
#[must_use]
pub const fn changes<S: Space>() -> usize {
    2 * S::FACES + 2
}

/// Where the changes of a row of cells go.
pub struct Changes<'a, T> {
    /// [`changes`] times `slots` times `half` values: one quantity in all slots after the other.
    pub out: &'a mut [T],
    /// The most cells of one colour in a row.
    pub half: usize,
}

/// The most groups of a row that go through the slots together, taking turns in each step: 32 cells, those of
/// one colour in a row of 64, are read once, whether they fill two vectors or four.
pub(super) const GROUPS: usize = 4;

/// Offsets of what is gathered for a group in one slot.
pub(super) struct Gathered<S>(PhantomData<S>);
impl<S: Space> Gathered<S> {
    /// Of v and of w: the cell's own faces, then for each edge the outside faces along its axes a and b.
    pub(super) const V: usize = 0;
    pub(super) const W: usize = S::FACES + 2 * S::EDGES;
    /// Of both pressures: at the cell, then beside each face.
    pub(super) const P: usize = 2 * Self::W;
    pub(super) const PBAR: usize = Self::P + 1 + S::FACES;
    /// At the cell's own faces: v in the slot before, w in the slot after, and the right-hand sides of
    /// equations a and c.
    pub(super) const BEFORE: usize = Self::PBAR + 1 + S::FACES;
    pub(super) const AFTER: usize = Self::BEFORE + S::FACES;
    pub(super) const TARGET: usize = Self::AFTER + S::FACES;
    pub(super) const SOURCE: usize = Self::TARGET + S::FACES;
    /// The right-hand sides of equations b and d.
    pub(super) const B: usize = Self::SOURCE + S::FACES;
    pub(super) const D: usize = Self::B + 1;
    pub(super) const SIZE: usize = Self::D + 1;
}

/// Offsets of what a group stores once for all slots: its rows of the table, and 1 / 4h along both axes of
/// every edge.
pub(super) struct Header<S>(PhantomData<S>);
impl<S: Space> Header<S> {
    pub(super) const EDGES: usize = Place::<S>::SIZE;
    pub(super) const SIZE: usize = Self::EDGES + 2 * S::EDGES;
}

/// Offsets of what a group stores for each slot, between the elimination and the substitution back.
pub(super) struct Stored<S>(PhantomData<S>);
impl<S: Space> Stored<S> {
    /// The diagonal block, then its factors: a lower triangle.
    pub(super) const FACTOR: usize = 0;
    /// The damping of a damped slot, until it has factors.
    pub(super) const DAMPING: usize = Self::FACTOR;
    /// a_k + M_k^T c_k, then z_k.
    pub(super) const RIGHT: usize = Self::FACTOR + S::FREE * (S::FREE + 1) / 2;
    /// M_k.
    pub(super) const MATRIX: usize = Self::RIGHT + S::FREE;
    /// c_k.
    pub(super) const FORCE: usize = Self::MATRIX + S::FREE * S::FREE;
    /// g + J^T g.
    pub(super) const ROW: usize = Self::FORCE + S::FREE;
    /// g + J g.
    pub(super) const COLUMN: usize = Self::ROW + S::FACES;
    /// The residuals b and d over |g|^2, then the components of a and c along g.
    pub(super) const NORMAL: usize = Self::COLUMN + S::FACES;
    /// The [`Form`] of the block.
    pub(super) const FORM: usize = Self::NORMAL + 4;
    pub(super) const SIZE: usize = Self::FORM + 1;
}

/// Vectors of the block left of the diagonal, which goes from the elimination of one slot to that of the
/// next.
pub(super) const fn lower_len<S: Space>() -> usize {
    S::FREE * S::FREE
}

/// Vectors of scratch of a group, besides what is gathered.
pub(super) const fn group_len<S: Space>(slots: usize) -> usize {
    Header::<S>::SIZE + lower_len::<S>() + slots * Stored::<S>::SIZE
}

/// What is stored for slot `k`.
#[inline(always)]
pub(super) fn slot<S: Space, V: Vector>(stored: &[V::Elem], k: usize) -> &[V::Elem] {
    &stored[k * Stored::<S>::SIZE * V::LANES..][..Stored::<S>::SIZE * V::LANES]
}

/// As [`slot`], to write.
#[inline(always)]
pub(super) fn slot_mut<S: Space, V: Vector>(stored: &mut [V::Elem], k: usize) -> &mut [V::Elem] {
    &mut stored[k * Stored::<S>::SIZE * V::LANES..][..Stored::<S>::SIZE * V::LANES]
}

/// The form of the block of a slot.
#[inline(always)]
pub(super) fn form<S: Space, V: Vector>(now: &[V::Elem]) -> Form<V>
where
    V::Elem: Real,
{
    Form::load(&now[Stored::<S>::FORM * V::LANES..])
}

/// Stores the form of the block of a slot.
#[inline(always)]
pub(super) fn store_form<S: Space, V: Vector>(form: Form<V>, now: &mut [V::Elem])
where
    V::Elem: Real,
{
    form.store(&mut now[Stored::<S>::FORM * V::LANES..]);
}

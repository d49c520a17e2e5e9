//! What a scene says of the steps of its flow: what the smoke should look like, what is added to it, and what force costs.

mod emission;
pub mod emitted;
pub mod jets;
mod schedule;
mod templates;

use crate::real::Real;
use core::num::NonZeroU32;

/// The lists of a scene, whose steps are those of its finest grid in time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lists<'a> {
    /// Steps of the keyframes, ascending.
    pub steps: &'a [u32],
    /// What each keyframe's data term is multiplied by.
    pub weights: &'a [f64],
    /// Whether each keyframe has a region to be matched in.
    pub regions: bool,
    /// First and last step of each emitter: smoke is added on the way from one to the other.
    pub spans: &'a [u32],
    /// Rate and target of each emitter, of which one is 0.
    pub supplies: &'a [f64],
    /// Whether each emitter pushes its smoke, 1 or 0, and the velocity to which: four numbers each; empty where none does.
    pub jets: &'a [f64],
    /// Steps where the factor of the force's price is given, ascending.
    pub knots: &'a [u32],
    /// Those factors.
    pub factors: &'a [f64],
    /// Whether force may act only here and there.
    pub mask: bool,
    /// The templates of the force, each as so many numbers: see [`Template::pack`](crate::problem::Template::pack).
    pub templates: &'a [f64],
}

/// What is given for each step: [`Lists`], and fields of cells on one grid.
#[derive(Clone, Copy, Debug)]
pub struct Script<'a, T> {
    lists: Lists<'a>,
    /// How many steps of the lists are one step here.
    stride: NonZeroU32,
    /// Step of the lists that is step 0 here.
    first: u32,
    /// The keyframes' targets, their regions, the emitters' shapes, the mask: see [`Lists::fields`].
    fields: &'a [T],
}

/// A keyframe's density and how much it matters.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a, T> {
    /// rho*.
    pub target: &'a [T],
    /// What the error is multiplied by, cell by cell; all 1 where it is empty.
    pub region: &'a [T],
    /// What the data term is multiplied by.
    pub weight: f64,
}

impl Lists<'_> {
    /// Fields of cells that go with them.
    #[must_use]
    pub fn fields(&self) -> usize {
        self.mask_begins() + usize::from(self.mask)
    }

    /// Number of the mask's field, which comes last.
    #[must_use]
    pub fn mask_begins(&self) -> usize {
        self.emitters_begin() + self.spans.len() / 2
    }

    /// Number of the first emitter's field.
    #[must_use]
    pub fn emitters_begin(&self) -> usize {
        self.steps.len() * (1 + usize::from(self.regions))
    }
}

impl<'a, T: Real> Script<'a, T> {
    /// That of the finest grid.
    #[must_use]
    pub fn new(lists: Lists<'a>, fields: &'a [T]) -> Self {
        Self {
            lists,
            stride: NonZeroU32::MIN,
            first: 0,
            fields,
        }
    }

    /// The same lists with fields of another grid, where `stride` steps of the scene, which divides those of all keyframes, are one;
    /// 0 counts as 1.
    #[must_use]
    pub fn coarse<'c>(&self, stride: u32, fields: &'c [T]) -> Script<'c, T>
    where
        'a: 'c,
    {
        Script {
            lists: self.lists,
            stride: NonZeroU32::new(stride).unwrap_or(NonZeroU32::MIN),
            first: self.first,
            fields,
        }
    }

    /// What is left of it from `step` on, after the last keyframe: the emitters.
    #[must_use]
    pub fn after(&self, step: usize, cells: usize) -> Self {
        let Lists {
            spans,
            supplies,
            jets,
            ..
        } = self.lists;
        let emitters = self.lists.emitters_begin() * cells;
        Self {
            lists: Lists {
                spans,
                supplies,
                jets,
                ..Lists::default()
            },
            first: self.first + step as u32,
            fields: self.fields.get(emitters..).unwrap_or(&[]),
            ..*self
        }
    }

    /// How many fields of cells there are.
    #[must_use]
    pub fn fields(&self) -> usize {
        self.lists.fields()
    }

    /// Field `index` of cells.
    #[must_use]
    pub fn field(&self, index: usize, cells: usize) -> &'a [T] {
        &self.fields[index * cells..(index + 1) * cells]
    }

    /// How many keyframes there are.
    #[must_use]
    pub fn keyframes(&self) -> usize {
        self.lists.steps.len()
    }

    /// Their steps, ascending.
    pub fn steps(&self) -> impl ExactSizeIterator<Item = usize> + use<'_, T> {
        self.lists.steps.iter().map(|step| self.here(*step))
    }

    /// The keyframe at `step`, if there is one.
    #[must_use]
    pub fn at(&self, step: usize) -> Option<usize> {
        self.lists
            .steps
            .binary_search_by_key(&step, |at| self.here(*at))
            .ok()
    }

    /// The density of keyframe `index`.
    #[must_use]
    pub fn target(&self, index: usize, cells: usize) -> &'a [T] {
        self.field(index, cells)
    }

    /// What keyframe `index` asks for.
    #[must_use]
    pub fn wanted(&self, index: usize, cells: usize) -> Wanted<'a, T> {
        Wanted {
            target: self.target(index, cells),
            region: if self.lists.regions {
                self.field(self.keyframes() + index, cells)
            } else {
                &[]
            },
            weight: self.lists.weights.get(index).copied().unwrap_or(1.0),
        }
    }

    /// How many emitters there are.
    #[must_use]
    pub fn emitters(&self) -> usize {
        self.lists.spans.len() / 2
    }

    /// The shape of emitter `index`.
    #[must_use]
    pub fn shape(&self, index: usize, cells: usize) -> &'a [T] {
        self.field(self.lists.emitters_begin() + index, cells)
    }

    /// Where force may act, cell by cell from 0 to 1; empty where it may everywhere.
    #[must_use]
    pub fn mask(&self, cells: usize) -> &'a [T] {
        if self.lists.mask {
            self.field(self.lists.mask_begins(), cells)
        } else {
            &[]
        }
    }

    /// The first keyframe not before `step`, or the last one, and how many steps the way to it takes from the keyframe before.
    ///
    /// Keyframes at consecutive steps are one stay, as where a shape is held: of each of them the way is that to the first.
    #[must_use]
    pub fn next(&self, step: usize) -> (usize, usize) {
        let before = |at: &u32| self.here(*at) < step;
        let last = self.keyframes().saturating_sub(1);
        let index = self.lists.steps.partition_point(before).min(last);
        let first = self.stay_begins(index);
        let left = first.checked_sub(1).map_or(0, |before| self.step(before));
        (index, self.step(first) - left)
    }

    /// The first keyframe of the stay that `index` is in.
    fn stay_begins(&self, index: usize) -> usize {
        let (mut first, mut end) = (0, index);
        while first < end {
            let middle = usize::midpoint(first, end);
            if self.step(middle) + (index - middle) < self.step(index) {
                first = middle + 1;
            } else {
                end = middle;
            }
        }
        first
    }

    /// The step of keyframe `index`.
    fn step(&self, index: usize) -> usize {
        self.lists.steps.get(index).map_or(0, |at| self.here(*at))
    }

    /// Where a step of the lists is here.
    fn here(&self, step: u32) -> usize {
        (step / self.stride) as usize
    }
}

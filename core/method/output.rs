//! What a method gives: named fields with place, steps and unit.

use crate::field::Vector;
use crate::words::named;

/// Where the elements of a field are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// At the centres of cells: one component.
    Cells,
    /// On the faces of cells: a component for each axis, on the faces across it.
    Faces,
}

named!(Place { Cells = "cells", Faces = "faces" });

/// In what a field is measured, in the scene's units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// As the source: density.
    Density,
    /// length / time.
    Velocity,
    /// length / time^2.
    Force,
}

named!(Unit { Density = "density", Velocity = "velocity", Force = "force" });

/// A field for each of many steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// Its name: lower case, with underscores. In files, components have their axis added: `velocity_x`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub words: &'static str,
    /// Where its elements are.
    pub place: Place,
    /// Its unit.
    pub unit: Unit,
    /// How many steps fewer it has than there are densities, which are N + 1.
    pub fewer: usize,
    /// How many of its first steps are not found but given: they can be read before there is a result.
    pub given: usize,
}

impl Output {
    /// How many steps it has in an animation of `steps` time steps.
    #[must_use]
    pub fn count(&self, steps: usize) -> usize {
        (steps + 1).saturating_sub(self.fewer)
    }

    /// How many components it has in `dims` dimensions.
    #[must_use]
    pub fn components(&self, dims: usize) -> usize {
        match self.place {
            Place::Cells => 1,
            Place::Faces => dims,
        }
    }
}

/// rho_0 .. rho_N.
pub const DENSITY: Output = Output {
    name: "density",
    words: "density of the smoke",
    place: Place::Cells,
    unit: Unit::Density,
    fewer: 0,
    given: 1,
};

/// v_0 .. v_{N-1}: v_k carries rho_k to rho_{k+1}.
pub const VELOCITY: Output = Output {
    name: "velocity",
    words: "velocity of the flow",
    place: Place::Faces,
    unit: Unit::Velocity,
    fewer: 1,
    given: 1,
};

/// u_0 .. u_{N-2}: u_k turns v_k into v_{k+1}.
pub const FORCE: Output = Output {
    name: "force",
    words: "force field",
    place: Place::Faces,
    unit: Unit::Force,
    fewer: 2,
    given: 0,
};

/// What a method gives that steers a flow.
pub const CONTROLLED_FLOW: &[Output] = &[DENSITY, VELOCITY, FORCE];

/// A field of one step as it lies in memory: time level `slot` of a trajectory of `slots` time levels, in scaled numbers. Of a
/// field of cells only the first component is there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stored<'a, T> {
    /// The components.
    pub components: Vector<'a, T>,
    /// Time levels of the trajectory.
    pub slots: usize,
    /// Which of them it is.
    pub slot: usize,
}

impl<'a, T> Stored<'a, T> {
    /// Step `step` of a field of `cells` cells whose steps lie one after the other.
    #[must_use]
    pub fn of_cells(steps: &'a [T], step: usize, cells: usize) -> Self {
        Self {
            components: [&steps[step * cells..(step + 1) * cells], &[], &[]],
            slots: 1,
            slot: 0,
        }
    }
}

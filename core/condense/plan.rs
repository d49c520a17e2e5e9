//! How many bytes a run needs.

use super::error::CondenseError;
use super::layout::Buffers;
use super::mesh::Mesh;
use super::settings::CondenseParams;
use super::topology::Topology;
use crate::memory::{ALIGN, Arena, Entry, Layout, Ledger, Sharing};
use crate::real::Real;

/// Every buffer of a run, to the byte; it does not depend on the number of steps.
#[derive(Clone, Debug)]
pub struct CondensePlan {
    ledger: Ledger,
    bytes: usize,
}

impl CondensePlan {
    /// Alignment that the memory must have.
    pub const ALIGN: usize = ALIGN;

    /// Plans a run in precision `T`.
    ///
    /// # Errors
    /// [`CondenseError`].
    pub fn new<T: Real>(
        mesh: &Mesh<'_>,
        topology: &Topology<'_>,
        params: &CondenseParams,
    ) -> Result<Self, CondenseError> {
        params.check(mesh.dims)?;
        if params.dt.is_none() {
            if topology.free() == mesh.vertices() {
                return Err(CondenseError::NoneHeld);
            }
            if let Some(vertex) = topology.unheld() {
                return Err(CondenseError::Unheld { vertex });
            }
        }
        // Patches are numbered by words.
        let patches = topology.patches.map_or(0, |(_, counted)| counted.total);
        if params.radius != topology.patches.map(|(radius, _)| radius) || u32::try_from(patches).is_err() {
            return Err(CondenseError::TooLarge);
        }
        let mut ledger = Ledger::new();
        ledger.group("condensation", Sharing::Together, |ledger| {
            let mut arena = Arena::measuring(ledger);
            let mut buffers = Buffers::<T>::default();
            // An arena that measures is never too small.
            let _ = buffers.layout(&mut Layout::carve(&mut arena), mesh, topology, params);
        });
        let bytes = ledger.bytes().ok_or(CondenseError::TooLarge)?;
        Ok(Self { ledger, bytes })
    }

    /// Bytes of the whole block.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The ledger, groups before their children.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        self.ledger.entries()
    }
}

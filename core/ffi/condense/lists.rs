//! The lists of a body, copied into memory that is planned.

use super::config::{
    THURIBLE_MOST_ELEMENTS, THURIBLE_MOST_SPRINGS, THURIBLE_MOST_VERTICES, ThuribleCondenseConfig,
    ThuribleSpring,
};
use crate::config::{ConfigError, ListNames, entries, is_on, names};
use crate::instance::{ALIGN, keep, kept_bytes};
use crate::result::ThuribleResult;
use core::mem::MaybeUninit;
use thurible_core::condense::{Material, Mesh, Spring, Topology};

const HELD: ListNames = names("held", "vertex_count", THURIBLE_MOST_VERTICES);
const REST: ListNames = names("rest", "vertex_count", 3 * THURIBLE_MOST_VERTICES);
const ELEMENTS: ListNames = names("elements", "element_count", THURIBLE_MOST_ELEMENTS);
const CORNERS: ListNames = names("elements", "element_count", 4 * THURIBLE_MOST_ELEMENTS);
const SPRINGS: ListNames = names("springs", "spring_count", THURIBLE_MOST_SPRINGS);

impl ThuribleCondenseConfig {
    /// Bytes of the lists of the body and of its topology, which begin on a multiple of [`ALIGN`].
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn lists_bytes(&self) -> Result<usize, ConfigError> {
        let (_, dims) = self.kind()?;
        let (vertices, elements, springs) = (self.vertex_count, self.element_count, self.spring_count);
        for (names, given) in [(&HELD, vertices), (&ELEMENTS, elements), (&SPRINGS, springs)] {
            if given > names.most {
                return Err(ConfigError::Count { names, given });
            }
        }
        let words = Topology::words_of(dims, [vertices, elements, springs]);
        let each = [
            kept_bytes::<f64>(vertices * dims),
            kept_bytes::<bool>(vertices),
            kept_bytes::<u32>(elements * (dims + 1)),
            kept_bytes::<Spring>(springs),
            words.and_then(kept_bytes::<u32>),
        ];
        let all = each
            .into_iter()
            .try_fold(0usize, |sum, bytes| sum.checked_add(bytes?));
        let all = all.and_then(|bytes| bytes.checked_next_multiple_of(ALIGN));
        Ok(all.ok_or(ThuribleResult::TooLarge)?)
    }

    /// The body and its topology, from copies of its lists in the first bytes of `memory`, [`Self::lists_bytes`] of them.
    ///
    /// # Errors
    /// [`ConfigError`].
    ///
    /// # Safety
    /// The lists have as many entries as the configuration says.
    pub unsafe fn body(
        &self,
        mut memory: &'static mut [MaybeUninit<u8>],
    ) -> Result<(Mesh<'static>, Topology<'static>), ConfigError> {
        let (_, dims) = self.kind()?;
        let short = ThuribleResult::TooSmall;
        self.lists_bytes()?;
        // SAFETY: the caller's promise.
        let (rest, held, elements, springs) = unsafe {
            (
                entries(self.rest, self.vertex_count * dims, &REST)?,
                entries(self.held, self.vertex_count, &HELD)?,
                entries(self.elements, self.element_count * (dims + 1), &CORNERS)?,
                entries(self.springs, self.spring_count, &SPRINGS)?,
            )
        };
        for (field, given) in held.iter().map(|&held| ("held", held.into())).chain(
            springs
                .iter()
                .map(|spring| ("springs[].in_basis", spring.in_basis)),
        ) {
            is_on(field, given)?;
        }
        if let Some(spring) = springs.iter().find(|spring| spring.reserved != 0) {
            let (field, given) = ("springs[].reserved", spring.reserved);
            return Err(ConfigError::Code { field, given });
        }
        let counts = [self.vertex_count, self.element_count, self.spring_count];
        let memory = &mut memory;
        let mesh = Mesh {
            dims,
            rest: keep(memory, rest.len(), rest.iter().copied()).ok_or(short)?,
            elements: keep(memory, elements.len(), elements.iter().copied()).ok_or(short)?,
            springs: keep(memory, springs.len(), springs.iter().map(ThuribleSpring::known)).ok_or(short)?,
            held: keep(memory, held.len(), held.iter().map(|&held| held == 1)).ok_or(short)?,
            regular: self.regular,
            material: Material {
                young: self.young,
                poisson: self.poisson,
                density: self.density,
                area: self.area,
            },
        };
        let count = Topology::words_of(dims, counts).ok_or(ThuribleResult::TooLarge)?;
        let words = keep(memory, count, core::iter::repeat(0)).ok_or(short)?;
        let radius = self.params()?.radius;
        Ok((mesh, Topology::new(&mesh, radius, words)?))
    }
}

impl ThuribleSpring {
    /// As the core has it.
    fn known(&self) -> Spring {
        Spring {
            ends: self.ends,
            stiffness: self.stiffness,
            rest_length: self.rest_length,
            in_basis: self.in_basis == 1,
        }
    }
}

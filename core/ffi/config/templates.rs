//! Templates as C gives them, and as the core takes them.

use super::choices::{code, codes, flag};
use super::error::ConfigError;
use thurible_core::Template;

/// Templates at most.
pub const THURIBLE_MOST_TEMPLATES: usize = 16;

/// What a template does around its middle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleTemplateKind {
    /// Blows one way: an amplitude for each axis.
    Wind = 0,
    /// Turns: anticlockwise in 2D by one amplitude, in 3D around an axis by three.
    Vortex = 1,
    /// Stirs by swirls that look random: one amplitude.
    Noise = 2,
    /// Pulls smoke to its middle: one amplitude.
    Attract = 3,
}

codes!(ThuribleTemplateKind of TemplateKind: Wind, Vortex, Noise, Attract);

/// Part of the force: an amplitude times a field of fixed form, which fades with the distance from its middle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleTemplate {
    /// A `ThuribleTemplateKind`.
    pub kind: u32,
    /// Whether middle and radius are searched for too: 0 or 1.
    pub moves: u32,
    /// The first force that it is part of: that which turns the velocity of step `from`.
    pub from: usize,
    /// The first that it is no part of any more: after `from` and at most N.
    pub to: usize,
    /// How many steps share an amplitude; 0 for one in all of them.
    pub interval: usize,
    /// Its middle along x, y and z, inside the box; z is ignored in 2D.
    pub center: [f64; 3],
    /// Its radius, above 0.
    pub radius: f64,
    /// The amplitude that a search begins with and a simulation has, in lengths per squared time: as many numbers as the kind has.
    pub amplitude: [f64; 3],
    /// Length of the waves of noise; 0 for the radius.
    pub size: f64,
    /// Which noise.
    pub seed: u32,
    /// For later versions; must be 0.
    pub reserved: u32,
}

impl ThuribleTemplate {
    /// What the core calls it.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub(super) fn read(self) -> Result<Template, ConfigError> {
        let (field, given) = ("template.moves", self.moves);
        let moves = flag(given).ok_or(ConfigError::Code { field, given })?;
        let kind = code("template.kind", self.kind)?;
        if self.reserved != 0 {
            let (field, given) = ("template.reserved", self.reserved);
            return Err(ConfigError::Code { field, given });
        }
        let Self {
            from,
            to,
            interval,
            center,
            radius,
            amplitude,
            size,
            seed,
            ..
        } = self;
        Ok(Template {
            from,
            interval: if interval == 0 { to.max(1) } else { interval },
            moves,
            amplitude,
            size: if size == 0.0 { radius } else { size },
            seed,
            ..Template::new(kind, center, radius, to)
        })
    }
}

impl From<Template> for ThuribleTemplate {
    fn from(template: Template) -> Self {
        let Template {
            kind,
            moves,
            from,
            to,
            interval,
            center,
            radius,
            amplitude,
            size,
            seed,
        } = template;
        Self {
            kind: kind as u32,
            moves: moves.into(),
            from,
            to,
            interval,
            center,
            radius,
            amplitude,
            size,
            seed,
            reserved: 0,
        }
    }
}

//! Lists of the configuration besides the keyframes' steps, as C gives them and as the core takes them.

use super::ThuribleConfig;
use super::choices::flag;
use super::error::{ConfigError, ListNames};
use super::templates::THURIBLE_MOST_TEMPLATES;
use thurible_core::problem::MAX_STEPS;
use thurible_core::{Emitter, Supply, Template, TemplateKind};

/// Emitters at most.
pub const THURIBLE_MOST_EMITTERS: usize = 32;
/// Factors of a schedule at most.
pub const THURIBLE_MOST_FACTORS: usize = 64;

/// Smoke that is made on the way from one step to another.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleEmitter {
    /// The last step without it.
    pub from: usize,
    /// The last step that it adds to, above `from` and at most N.
    pub to: usize,
    /// Density that it adds at every step where its shape is 1, above 0; 0 where it has a target.
    pub rate: f64,
    /// Density that it fills up to at every step where its shape is 1, above 0; 0 where it has a rate.
    pub target: f64,
    /// The velocity that its smoke comes with along x, y and z, in lengths per time, where `pushes` is 1; z is ignored in 2D.
    pub velocity: [f64; 3],
    /// Whether the flow in its shape is taken to `velocity` while it emits: 0 or 1.
    pub pushes: u32,
    /// For later versions; must be 0.
    pub reserved: u32,
}

/// What the price of the force is multiplied by at a step.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleFactor {
    /// The step.
    pub step: usize,
    /// The factor, above 0.
    pub factor: f64,
}

impl ThuribleEmitter {
    /// What the core calls number `index`.
    ///
    /// # Errors
    /// [`ConfigError`]: where it has not the one or the other of rate and target, or a code that stands for nothing.
    fn read(self, index: usize) -> Result<Emitter, ConfigError> {
        let supply = match (self.rate == 0.0, self.target == 0.0) {
            (false, true) => Supply::Rate(self.rate),
            (true, false) => Supply::Target(self.target),
            _ => return Err(ConfigError::Supply { index }),
        };
        let (field, given) = ("emitter.pushes", self.pushes);
        let pushes = flag(given).ok_or(ConfigError::Code { field, given })?;
        if self.reserved != 0 {
            let (field, given) = ("emitter.reserved", self.reserved);
            return Err(ConfigError::Code { field, given });
        }
        let Self {
            from, to, velocity, ..
        } = self;
        Ok(Emitter {
            from,
            to,
            supply,
            velocity: pushes.then_some(velocity),
        })
    }
}

/// Values of the core's in a place of their own, since the caller's are laid out otherwise.
struct List<V, const MOST: usize> {
    values: [V; MOST],
    count: usize,
}

impl<V: Copy, const MOST: usize> List<V, MOST> {
    const fn new(empty: V) -> Self {
        let (values, count) = ([empty; MOST], 0);
        Self { values, count }
    }

    /// Adds a value, if there is room.
    fn push(&mut self, value: V) {
        if let Some(place) = self.values.get_mut(self.count) {
            *place = value;
            self.count += 1;
        }
    }

    fn as_slice(&self) -> &[V] {
        self.values.get(..self.count).unwrap_or(&self.values)
    }
}

/// Lists of a configuration that the core takes in another layout. They take much of a stack, so that there is one and it is not moved.
pub(super) struct Lists {
    emitters: List<Emitter, THURIBLE_MOST_EMITTERS>,
    schedule: List<(usize, f64), THURIBLE_MOST_FACTORS>,
    templates: List<Template, THURIBLE_MOST_TEMPLATES>,
}

impl Lists {
    /// Without entries. Made when compiling, so that no second copy is on the stack.
    pub const fn new() -> Self {
        let nothing = Supply::Rate(0.0);
        Self {
            emitters: List::new(Emitter {
                from: 0,
                to: 0,
                supply: nothing,
                velocity: None,
            }),
            schedule: List::new((0, 0.0)),
            templates: List::new(Template::new(TemplateKind::Wind, [0.0; 3], 0.0, 0)),
        }
    }

    /// Takes the lists of `config`.
    ///
    /// # Errors
    /// [`ConfigError`].
    ///
    /// # Safety
    /// The lists of `config` have as many entries as it says.
    pub unsafe fn read(&mut self, config: &ThuribleConfig) -> Result<(), ConfigError> {
        // SAFETY: the caller's promise.
        let emitters = unsafe { entries(config.emitters, config.emitter_count, &EMITTERS) }?;
        for (index, emitter) in emitters.iter().enumerate() {
            self.emitters.push(emitter.read(index)?);
        }
        // SAFETY: the caller's promise.
        let schedule = unsafe { entries(config.schedule, config.schedule_count, &SCHEDULE) }?;
        for &ThuribleFactor { step, factor } in schedule {
            self.schedule.push((step, factor));
        }
        // SAFETY: the caller's promise.
        let templates = unsafe { entries(config.templates, config.template_count, &TEMPLATES) }?;
        for template in templates {
            self.templates.push(template.read()?);
        }
        Ok(())
    }

    /// The emitters.
    pub fn emitters(&self) -> &[Emitter] {
        self.emitters.as_slice()
    }

    /// The templates.
    pub fn templates(&self) -> &[Template] {
        self.templates.as_slice()
    }

    /// The factors of the force's price.
    pub fn schedule(&self) -> &[(usize, f64)] {
        self.schedule.as_slice()
    }
}

impl ThuribleConfig {
    /// The steps of the keyframes, and their weights.
    ///
    /// # Errors
    /// [`ConfigError`].
    ///
    /// # Safety
    /// As [`Lists::read`].
    pub(super) unsafe fn keyframe_lists(&self) -> Result<(&[usize], &[f64]), ConfigError> {
        let weights = if self.keyframe_weights.is_null() {
            0
        } else {
            self.keyframe_count
        };
        // SAFETY: the caller's promise.
        unsafe {
            let steps = entries(self.keyframes, self.keyframe_count, &KEYFRAMES)?;
            Ok((steps, entries(self.keyframe_weights, weights, &WEIGHTS)?))
        }
    }
}

/// The names of a list.
#[must_use]
pub const fn names(list: &'static str, count: &'static str, most: usize) -> ListNames {
    ListNames { list, count, most }
}

const KEYFRAMES: ListNames = names("keyframes", "keyframe_count", MAX_STEPS);
const WEIGHTS: ListNames = names("keyframe_weights", "keyframe_count", MAX_STEPS);
const EMITTERS: ListNames = names("emitters", "emitter_count", THURIBLE_MOST_EMITTERS);
const TEMPLATES: ListNames = names("templates", "template_count", THURIBLE_MOST_TEMPLATES);
const SCHEDULE: ListNames = names("schedule", "schedule_count", THURIBLE_MOST_FACTORS);

/// A list of the caller.
///
/// # Errors
/// [`ConfigError`].
///
/// # Safety
/// `list` points to `count` entries, where it is neither null nor misaligned; every pattern of bits is a `V`.
pub unsafe fn entries<'a, V>(
    list: *const V,
    count: usize,
    names: &'static ListNames,
) -> Result<&'a [V], ConfigError> {
    match count {
        0 => Ok(&[]),
        given if given > names.most => Err(ConfigError::Count { names, given }),
        _ if list.is_null() || !list.is_aligned() => Err(ConfigError::Pointer { names }),
        // SAFETY: not null, aligned, and the caller promises the entries.
        count => Ok(unsafe { core::slice::from_raw_parts(list, count) }),
    }
}

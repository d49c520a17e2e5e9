//! A body and how its energy is minimised, as C gives it.

use crate::config::{
    ConfigError, THURIBLE_AUTOMATIC, ThuriblePrecision, code, codes, is_on, precision, sized, wide,
};
use crate::result::ThuribleResult;
use thurible_core::condense::{CondenseParams, Material};

/// How far a block moves in a pass of a condensation.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleCondenseMethod {
    /// Coordinate condensation.
    Cc = 0,
    /// Newton's method.
    Newton = 1,
    /// Each vertex by its own Hessian: vertex block descent.
    Plain = 2,
    /// JGS2.
    Jgs2 = 3,
    /// The same by the gradient of the block alone.
    Jgs2Local = 4,
    /// The energy along the basis of each block.
    Projected = 5,
    /// The Hessian of the build in the place of today's.
    Chord = 6,
    /// The same, turned with the body.
    Warped = 7,
}

/// When the basis of a condensation is built, and whether it turns with the body.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleCondenseBasis {
    /// Once, at rest.
    Fixed = 0,
    /// Every few steps, from the state before.
    Rebuilt = 1,
    /// Once, and turned.
    Corotated = 2,
    /// Every few steps, and turned.
    CorotatedRebuilt = 3,
    /// When four iterations have not halved the residual.
    Adaptive = 4,
    /// The same, and turned.
    CorotatedAdaptive = 5,
}

/// What a block of a condensation is.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleCondenseBlock {
    /// All components of a vertex.
    Vertex = 0,
    /// One component.
    Scalar = 1,
}

/// Who moves when in a condensation.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleCondenseOrder {
    /// All at once.
    Jacobi = 0,
    /// Colour by colour.
    Colours = 1,
}

codes!(ThuribleCondenseMethod of condense::Update: Cc, Newton, Plain, Jgs2, Jgs2Local, Projected, Chord, Warped);
codes!(ThuribleCondenseBasis of condense::Basis: Fixed, Rebuilt, Corotated, CorotatedRebuilt, Adaptive, CorotatedAdaptive);
codes!(ThuribleCondenseBlock of condense::Block: Vertex, Scalar);
codes!(ThuribleCondenseOrder of condense::Order: Jacobi, Colours);

/// A spring between two vertices.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleSpring {
    /// Its ends.
    pub ends: [u32; 2],
    /// k of k/2 (l - L)^2.
    pub stiffness: f64,
    /// L.
    pub rest_length: f64,
    /// Whether a basis knows it, 0 or 1.
    pub in_basis: u32,
    /// For later versions; must be 0.
    pub reserved: u32,
}

/// Vertices of a body at most,
pub const THURIBLE_MOST_VERTICES: usize = 1 << 24;
/// its simplices,
pub const THURIBLE_MOST_ELEMENTS: usize = 1 << 25;
/// and its springs.
pub const THURIBLE_MOST_SPRINGS: usize = 1 << 24;

/// An elastic body, and how its energy is minimised: begin with `thurible_condense_defaults`. Lists are copied when a body is made. Later versions add fields
/// at the end.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleCondenseConfig {
    /// `sizeof(ThuribleCondenseConfig)`, as `thurible_condense_defaults` writes it.
    pub size: usize,
    /// A `ThuriblePrecision`; that of the state, `double` by default. What is given and read is `double` in either.
    pub precision: u32,
    /// Components of a vector: 1 of a rod, 2 or 3.
    pub dimensions: u32,
    /// Vertices.
    pub vertex_count: usize,
    /// Where they are at rest: `dimensions` numbers for each.
    pub rest: *const f64,
    /// Whether each is held, 0 or 1: its place is given, not found.
    pub held: *const u8,
    /// Simplices,
    pub element_count: usize,
    /// and their corners: `dimensions` + 1 vertices for each, in an order that makes volumes positive.
    pub elements: *const u32,
    /// Springs; none by default.
    pub spring_count: usize,
    /// See there.
    pub springs: *const ThuribleSpring,
    /// Vertices along each axis of a regular mesh, numbered along x first; zeros, the default, of any other. Colours are parities there.
    pub regular: [usize; 3],
    /// Young's modulus.
    pub young: f64,
    /// Poisson's ratio; a rod has none.
    pub poisson: f64,
    /// Mass in a unit of area or volume.
    pub density: f64,
    /// Cross section of a rod.
    pub area: f64,
    /// A `ThuribleCondenseMethod`.
    pub method: u32,
    /// A `ThuribleCondenseBasis`.
    pub basis: u32,
    /// A `ThuribleCondenseBlock`.
    pub block: u32,
    /// A `ThuribleCondenseOrder`.
    pub order: u32,
    /// Steps from one build to the next, of rebuilt bases.
    pub rebuild: u32,
    /// Edges within which a basis is kept; `THURIBLE_AUTOMATIC`, the default, keeps all.
    pub radius: u32,
    /// The residual below which a step is solved.
    pub tolerance: f64,
    /// Iterations of a step at most.
    pub cap: u32,
    /// Whether steps along the direction are searched for, 0 or 1.
    pub search: u32,
    /// Length of an implicit step; 0, the default, is quasi-static.
    pub dt: f64,
    /// Threads that memory is planned for.
    pub threads: usize,
}

// SAFETY: plain numbers and pointers, the size first.
unsafe impl sized::Versioned for ThuribleCondenseConfig {}

impl Default for ThuribleCondenseConfig {
    fn default() -> Self {
        let (params, material) = (CondenseParams::default(), Material::default());
        let narrow = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        Self {
            size: size_of::<Self>(),
            precision: ThuriblePrecision::F64 as u32,
            dimensions: 2,
            vertex_count: 0,
            rest: core::ptr::null(),
            held: core::ptr::null(),
            element_count: 0,
            elements: core::ptr::null(),
            spring_count: 0,
            springs: core::ptr::null(),
            regular: [0; 3],
            young: material.young,
            poisson: material.poisson,
            density: material.density,
            area: material.area,
            method: params.method as u32,
            basis: params.basis as u32,
            block: params.block as u32,
            order: params.order as u32,
            rebuild: narrow(params.rebuild),
            radius: THURIBLE_AUTOMATIC,
            tolerance: params.tolerance,
            cap: narrow(params.cap),
            search: params.search.into(),
            dt: 0.0,
            threads: params.threads,
        }
    }
}

impl ThuribleCondenseConfig {
    /// Precision and dimensions.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn kind(&self) -> Result<(ThuriblePrecision, usize), ConfigError> {
        match self.dimensions {
            given @ 1..=3 => Ok((precision(self.precision)?, wide(given))),
            given => Err(ConfigError::Code {
                field: "dimensions",
                given,
            }),
        }
    }

    /// The choices.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn params(&self) -> Result<CondenseParams, ConfigError> {
        Ok(CondenseParams {
            method: code("method", self.method)?,
            basis: code("basis", self.basis)?,
            rebuild: wide(self.rebuild),
            block: code("block", self.block)?,
            order: code("order", self.order)?,
            radius: (self.radius != THURIBLE_AUTOMATIC).then(|| wide(self.radius)),
            tolerance: self.tolerance,
            cap: wide(self.cap),
            search: is_on("search", self.search)?,
            dt: (self.dt != 0.0).then_some(self.dt),
            threads: self.threads,
            ..CondenseParams::default()
        })
    }
}

/// Fills a configuration of `size` bytes, `sizeof(ThuribleCondenseConfig)` of the program that calls, with the defaults.
///
/// # Safety
/// `config` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_defaults(
    config: *mut ThuribleCondenseConfig,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { sized::fill(config, size, ThuribleCondenseConfig::default()) }
}

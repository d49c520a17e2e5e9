//! What is reconstructed, and how, as C gives it.

use super::camera::{Cameras, THURIBLE_MOST_CAMERAS, ThuribleCamera};
use crate::config::{
    ConfigError, ListNames, ThuriblePrecision, code, codes, dimensions, is_on, names, precision, sized, wide,
};
use crate::result::ThuribleResult;
use thurible_core::tomography::{Settings, Tomography};
use thurible_core::walk::Cells;

/// How a frame is reconstructed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleReconstructor {
    /// The random walk.
    Walk = 0,
    /// Simultaneous algebraic reconstruction, camera after camera.
    Sart = 1,
}

/// What is charged beside the distance from the pictures.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuriblePrior {
    /// Nothing.
    None = 0,
    /// Half the squares of the Laplacian.
    L2 = 1,
    /// The lengths of the forward differences.
    Tv = 2,
    /// The absolute differences of all cells that touch.
    Sad = 3,
    /// `THURIBLE_PRIOR_TV` of the novel views.
    ImageTv = 4,
    /// `THURIBLE_PRIOR_SAD` of the novel views.
    ImageSad = 5,
}

/// When a chain records.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleWalk {
    /// Where it walks to.
    Patient = 0,
    /// Whatever has a gain.
    Eager = 1,
}

codes!(ThuribleReconstructor of tomography::Method: Walk, Sart);
codes!(ThuriblePrior of walk::Prior: None, L2, Tv, Sad, ImageTv, ImageSad);
codes!(ThuribleWalk of walk::Rule: Patient, Eager);

/// A box, the cameras about it, and how its density is found: begin with `thurible_tomography_defaults`. Later versions add fields at the end.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleTomographyConfig {
    /// `sizeof(ThuribleTomographyConfig)`, as `thurible_tomography_defaults` writes it.
    pub size: usize,
    /// A `ThuriblePrecision`; `THURIBLE_PRECISION_F32` by default.
    pub precision: u32,
    /// 2 or 3; 2 by default.
    pub dimensions: u32,
    /// Cells along x, y and z, at least 2; z is ignored in 2D. To be set.
    pub cells: [usize; 3],
    /// The cameras that measure; read only while a call that takes the configuration lasts.
    pub cameras: *const ThuribleCamera,
    /// How many there are, from 1 to `THURIBLE_MOST_CAMERAS`.
    pub camera_count: usize,
    /// Cameras that measure nothing: what they would see is kept. Read as `cameras`.
    pub novel: *const ThuribleCamera,
    /// How many there are, at most `THURIBLE_MOST_CAMERAS`.
    pub novel_count: usize,
    /// A `ThuribleReconstructor`; the walk by default.
    pub method: u32,
    /// A `ThuriblePrior`; SAD by default.
    pub prior: u32,
    /// How much of it, in the units of the density (of a pixel, for those of novel views); 0.15 by default, where the program chooses by prior and picture.
    pub gamma: f64,
    /// Whether no cell may fall below 0; where none are kept, no pixel of a novel view: 0 or 1.
    pub nonnegative: u32,
    /// Whether the density is kept where only the caller needs it: 0 or 1; 1 by default, where the program keeps none by the priors of pictures.
    pub volume: u32,
    /// Standard deviation of a mutation, in diagonals of the box.
    pub sigma: f64,
    /// Mutations of a chain.
    pub length: u64,
    /// Mutations of a frame; 6 million by default, where the program takes 20 for each cell and camera.
    pub budget: u64,
    /// Mass of a sample; 0 for total / (accept budget).
    pub eps: f64,
    /// The part of the mutations that is expected to be recorded.
    pub accept: f64,
    /// A frame ends when a tenth of the budget lowers the objective by less than this part; 0 for never.
    pub tolerance: f64,
    /// A `ThuribleWalk`; patient by default.
    pub walk: u32,
    /// Passes of SART over all cameras.
    pub sweeps: u32,
    /// Pixels of at most this are dark: places that they see are empty.
    pub hull_threshold: f64,
    /// Which random numbers.
    pub seed: u64,
    /// The part of the budget of a frame that begins with the one before.
    pub warm_budget: f64,
    /// How far SART goes at a time.
    pub relax: f64,
}

// SAFETY: plain numbers and pointers, the size first.
unsafe impl sized::Versioned for ThuribleTomographyConfig {}

const CAMERAS: ListNames = names("cameras", "camera_count", THURIBLE_MOST_CAMERAS);
const NOVEL: ListNames = names("novel", "novel_count", THURIBLE_MOST_CAMERAS);

impl Default for ThuribleTomographyConfig {
    fn default() -> Self {
        let settings = Settings::default();
        Self {
            size: size_of::<Self>(),
            precision: ThuriblePrecision::F32 as u32,
            dimensions: 2,
            cells: [0; 3],
            cameras: core::ptr::null(),
            camera_count: 0,
            novel: core::ptr::null(),
            novel_count: 0,
            method: settings.method as u32,
            prior: settings.prior as u32,
            gamma: settings.gamma,
            nonnegative: settings.nonnegative.into(),
            volume: settings.volume.into(),
            sigma: settings.sigma,
            length: settings.length,
            budget: settings.budget,
            eps: settings.eps.unwrap_or_default(),
            accept: settings.accept,
            tolerance: settings.tolerance,
            walk: settings.rule as u32,
            sweeps: u32::try_from(settings.sweeps).unwrap_or(u32::MAX),
            hull_threshold: settings.hull_threshold,
            seed: settings.seed,
            warm_budget: settings.warm_budget,
            relax: settings.relax,
        }
    }
}

impl ThuribleTomographyConfig {
    /// Precision and axes.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn kind(&self) -> Result<(ThuriblePrecision, usize), ConfigError> {
        Ok((precision(self.precision)?, dimensions(self.dimensions)?))
    }

    fn settings(&self) -> Result<Settings, ConfigError> {
        Ok(Settings {
            method: code("method", self.method)?,
            prior: code("prior", self.prior)?,
            gamma: self.gamma,
            nonnegative: is_on("nonnegative", self.nonnegative)?,
            volume: is_on("volume", self.volume)?,
            sigma: self.sigma,
            length: self.length,
            budget: self.budget,
            eps: (self.eps != 0.0).then_some(self.eps),
            accept: self.accept,
            tolerance: self.tolerance,
            rule: code("walk", self.walk)?,
            hull_threshold: self.hull_threshold,
            seed: self.seed,
            // A frame says whether it begins with the one before.
            warm: false,
            warm_budget: self.warm_budget,
            sweeps: wide(self.sweeps),
            relax: self.relax,
        })
    }

    /// Calls `work` with the problem that this describes.
    ///
    /// # Errors
    /// [`ConfigError`].
    ///
    /// # Safety
    /// The lists have as many entries as it says.
    #[inline(never)]
    pub unsafe fn with<const D: usize, R>(
        &self,
        work: impl FnOnce(&Tomography<'_, D>) -> R,
    ) -> Result<R, ConfigError> {
        let mut cameras = const { Cameras::<D>::new() };
        let mut novel = const { Cameras::<D>::new() };
        // SAFETY: the caller's promise.
        unsafe {
            cameras.read(self.cameras, self.camera_count, &CAMERAS)?;
            novel.read(self.novel, self.novel_count, &NOVEL)?;
        }
        let mut counts = self.cells.into_iter();
        let problem = Tomography {
            cells: Cells {
                counts: [0; D].map(|none| counts.next().unwrap_or(none)),
            },
            cameras: cameras.as_slice(),
            novel: novel.as_slice(),
            settings: self.settings()?,
        };
        problem.check().map_err(ConfigError::Tomography)?;
        Ok(work(&problem))
    }
}

/// Fills a configuration of `size` bytes, `sizeof(ThuribleTomographyConfig)` of the program that calls, with the defaults.
///
/// # Safety
/// `config` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_defaults(
    config: *mut ThuribleTomographyConfig,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { sized::fill(config, size, ThuribleTomographyConfig::default()) }
}

//! Pictures that are being made a density, in a block of their own.

use crate::arrays::{Common, array, density, numbers, untyped};
use crate::block::Block;
use crate::cameras::camera;
use crate::place::Number;
use crate::plan::Precision;
use crate::reconstructed::{Tomography, said};
use crate::words::refused;
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use std::borrow::Cow;
use thurible::brightness::{Brightness, Dim};
use thurible::bytes::{self, grouped};
use thurible::undershoot::place;
use thurible_core::tomography::{self, Camera, Reconstruction, Settings, TomographyError};
use thurible_core::walk::Cells;

/// Mutations between two looks at whether the user wants to stop.
const BREATH: u64 = 100_000;

/// What is asked for.
pub struct Job<'py> {
    /// An array for each camera.
    pub pictures: Vec<Bound<'py, PyAny>>,
    /// The cameras.
    pub cameras: Vec<Bound<'py, PyAny>>,
    /// Novel views.
    pub novel: Vec<Bound<'py, PyAny>>,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// How many frames there are; none where pictures have no such axis.
    pub frames: Option<usize>,
    /// How they are reconstructed.
    pub settings: Settings,
    /// Whether gamma follows the pictures.
    pub automatic: bool,
    /// Most bytes of the block, or none: what the machine has.
    pub memory_limit: Option<usize>,
}

/// What came of all frames.
struct Found<T> {
    density: Vec<T>,
    reprojected: Vec<Vec<T>>,
    novel: Vec<Vec<T>>,
}

impl<'py> Job<'py> {
    /// Reconstructs all frames.
    pub fn run<T: Number, const D: usize>(mut self, precision: Precision) -> PyResult<Tomography> {
        let (cameras, novel) = (self.see::<D>()?, self.look::<D>()?);
        let pictures = self.measured::<T, D>(&cameras, precision)?;
        let brightest = self.brightest(&cameras, &pictures)?;
        if self.automatic {
            let longest = self.cells.iter().copied().max().unwrap_or(1);
            self.settings.gamma = Settings::automatic_gamma(self.settings.prior, D, longest, brightest);
        }
        let problem = tomography::Tomography {
            cells: Cells {
                counts: core::array::from_fn(|axis| self.cells[axis]),
            },
            cameras: &cameras,
            novel: &novel,
            settings: self.settings,
        };
        problem.check().map_err(wrong)?;
        let needed = Reconstruction::<T, D>::bytes(&problem).unwrap_or(usize::MAX);
        let limit = self.memory_limit.or_else(bytes::of_machine).unwrap_or(usize::MAX);
        if needed > limit {
            return Err(PyMemoryError::new_err(format!(
                "the reconstruction needs {} bytes, and memory_limit or the machine allows {}; give fewer cells",
                grouped(needed),
                grouped(limit)
            )));
        }
        let mut block = Block::planned(needed, "the reconstruction", "give fewer cells")?;
        let mut one = Reconstruction::<T, D>::new(problem, block.bytes_mut()).map_err(wrong)?;
        let py = self.pictures[0].py();
        let history = PyList::empty(py);
        let mut found = Found {
            density: Vec::new(),
            reprojected: vec![Vec::new(); cameras.len()],
            novel: vec![Vec::new(); novel.len()],
        };
        for frame in 0..self.frames.unwrap_or(1) {
            for (number, (camera, picture)) in cameras.iter().zip(&pictures).enumerate() {
                let own = picture.chunks_exact(camera.len()).nth(frame).unwrap_or_default();
                one.measure(number, own).map_err(wrong)?;
            }
            let lit = match one.begin(frame as u64, self.settings.warm && frame > 0) {
                Err(TomographyError::Dark) => false,
                begun => begun.map(|()| true).map_err(wrong)?,
            };
            let mut over = !lit;
            while !over {
                py.check_signals()?;
                over = py.detach(|| one.advance(BREATH));
            }
            if lit {
                history.append(said(py, &one)?)?;
            }
            found.keep(&one, lit);
        }
        self.result(py, found, [&cameras, &novel], needed, history)
    }

    /// The cameras, as large as their pictures.
    fn see<const D: usize>(&self) -> PyResult<Vec<Camera<D>>> {
        let pairs = self.cameras.iter().zip(&self.pictures).enumerate();
        pairs
            .map(|(number, (given, picture))| {
                let shape = untyped(&format!("pictures[{number}]"), picture)?.shape().to_vec();
                let rest = shape
                    .get(usize::from(self.frames.is_some())..)
                    .unwrap_or_default();
                let pixels = match *rest {
                    [columns] if D == 2 => [columns, 1],
                    [rows, columns] if D > 2 => [columns, rows],
                    _ => {
                        let why = format!("has the shape {shape:?}; give pictures as pictures[0]");
                        return Err(refused(&format!("pictures[{number}]"), why));
                    }
                };
                camera(&format!("cameras[{number}]"), given, Some(pixels))
            })
            .collect()
    }

    fn look<const D: usize>(&self) -> PyResult<Vec<Camera<D>>> {
        let novel = self.novel.iter().enumerate();
        novel
            .map(|(number, given)| camera(&format!("novel[{number}]"), given, None))
            .collect()
    }

    /// All pictures, camera by camera.
    fn measured<T: Number, const D: usize>(
        &self,
        cameras: &[Camera<D>],
        precision: Precision,
    ) -> PyResult<Vec<Vec<T>>> {
        let pairs = self.pictures.iter().zip(cameras).enumerate();
        pairs
            .map(|(number, (picture, camera))| {
                let field = format!("pictures[{number}]");
                let common = Common {
                    shape: self.shape(&shape_of(camera)),
                    precision,
                    of: "pictures[0]".into(),
                };
                let picture = array::<T>(&field, picture, &common)?;
                let odd = numbers(&picture)?.iter().position(|pixel| !pixel.is_finite());
                if let Some(at) = odd {
                    let at = place(at, picture.shape());
                    return Err(refused(
                        &field,
                        format!("has a pixel, {at}, that is not finite; every one must be"),
                    ));
                }
                density(&field, &picture).map(Cow::into_owned)
            })
            .collect()
    }

    /// The brightest pixel of all pictures, where smoke can be reconstructed from them.
    fn brightest<T: Number, const D: usize>(
        &self,
        cameras: &[Camera<D>],
        pictures: &[Vec<T>],
    ) -> PyResult<f64> {
        let mut brightness = Brightness::new(self.settings.hull_threshold);
        for frame in 0..self.frames.unwrap_or(1) {
            let most = cameras.iter().zip(pictures).map(|(camera, picture)| {
                let own = picture.chunks_exact(camera.len()).nth(frame).unwrap_or_default();
                own.iter().map(|pixel| pixel.to_f64()).fold(0.0, f64::max)
            });
            if let Some(camera) = brightness.add(most) {
                let why = format!(
                    "is dark in frame {frame}, where other cameras see smoke: nothing can be where a camera sees none; take the camera out, or check its pictures"
                );
                return Err(refused(&format!("pictures[{camera}]"), why));
            }
        }
        brightness.brightest().map_err(|dim| match dim {
            Dim::Zeros => refused(
                "pictures",
                "have nothing but zeros in all frames; there is no smoke to reconstruct: check them",
            ),
            Dim::Beyond(brightest) => refused(
                "pictures",
                format!("have {brightest:e} as their brightest pixel; 1e-30 to 1e30 can be reconstructed: scale them"),
            ),
            Dim::Below(brightest) => refused(
                "hull_threshold",
                format!(
                    "is {}, and the brightest pixel of all pictures {brightest:.4}: no camera sees smoke; it must be below that, and is 0 by default",
                    self.settings.hull_threshold
                ),
            ),
        })
    }

    /// A shape with frames before it, where there are any.
    fn shape(&self, rest: &[usize]) -> Vec<usize> {
        self.frames.into_iter().chain(rest.iter().copied()).collect()
    }

    fn result<T: Number, const D: usize>(
        &self,
        py: Python<'_>,
        found: Found<T>,
        [cameras, novel]: [&[Camera<D>]; 2],
        planned_bytes: usize,
        history: Bound<'_, PyList>,
    ) -> PyResult<Tomography> {
        let array = |values: Vec<T>, rest: &[usize]| PyArray1::from_vec(py, values).reshape(self.shape(rest));
        let views = |values: Vec<Vec<T>>, cameras: &[Camera<D>]| -> PyResult<Py<PyTuple>> {
            let arrays = values.into_iter().zip(cameras);
            let arrays = arrays.map(|(values, camera)| array(values, &shape_of(camera)));
            Ok(PyTuple::new(py, arrays.collect::<PyResult<Vec<_>>>()?)?.unbind())
        };
        let cells: Vec<usize> = self.cells.iter().rev().copied().collect();
        Ok(Tomography {
            density: if self.settings.keeps_cells() {
                array(found.density, &cells)?.into_any().unbind()
            } else {
                py.None()
            },
            reprojected: views(found.reprojected, cameras)?,
            novel: views(found.novel, novel)?,
            history: history.unbind(),
            gamma: self.settings.gamma,
            planned_bytes,
        })
    }
}

impl<T: Number> Found<T> {
    /// Keeps what was found of a frame: nothing of one that is dark.
    fn keep<const D: usize>(&mut self, one: &Reconstruction<'_, T, D>, lit: bool) {
        let seen = |value: T| if lit { value } else { T::ZERO };
        self.density
            .extend(one.density().iter().map(|&value| seen(value)));
        for (number, picture) in self.reprojected.iter_mut().enumerate() {
            let pixels = one.measured(number).iter().zip(one.residual(number));
            picture.extend(pixels.map(|(&q, &r)| seen(q - r)));
        }
        for (number, picture) in self.novel.iter_mut().enumerate() {
            picture.extend(one.novel(number).iter().map(|&pixel| seen(pixel)));
        }
    }
}

/// Rows and columns of a picture, in a plane columns alone.
fn shape_of<const D: usize>(camera: &Camera<D>) -> Vec<usize> {
    let [columns, rows] = camera.pixels;
    if D > 2 { vec![rows, columns] } else { vec![columns] }
}

fn wrong(error: TomographyError) -> PyErr {
    match error {
        TomographyError::Setting { name, allowed } => {
            refused(name, format!("must be {allowed}; change it to that"))
        }
        TomographyError::NoNovel => {
            refused("prior", "is one of pictures, and `novel` has no camera; give one")
        }
        TomographyError::Cells { axis } => refused(
            "cells",
            format!("has fewer than 2 along axis {axis}, or more than can be counted; give 2 or more"),
        ),
        TomographyError::Novel { .. } => refused("novel", format!("cannot be used: {error}; change that")),
        other => refused("cameras", format!("cannot be used: {other}; change that")),
    }
}

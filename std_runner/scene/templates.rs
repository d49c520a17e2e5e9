//! `[[template]]`: simple fields of which the force is made.

use super::check::shown;
use super::document::Document;
use super::model::{Grid, Scene};
use crate::exit::Failure;
use thurible_core::{Template, TemplateKind};
use toml::{Table, Value};

const KEYS: &[&str] = &[
    "kind",
    "center",
    "radius",
    "from",
    "to",
    "interval",
    "move",
    "amplitude",
    "size",
    "seed",
];

/// The templates of a scene with so many steps.
pub(super) fn templates(
    document: &Document,
    raw: Option<Vec<Table>>,
    grid: &Grid,
    steps: usize,
) -> Result<Vec<Template>, Failure> {
    let tables = raw.unwrap_or_default().into_iter().enumerate();
    tables
        .map(|(index, table)| {
            Given {
                document,
                grid,
                steps,
                table,
                key: format!("template[{index}]"),
            }
            .template()
        })
        .collect()
}

/// Refuses templates that act after the release, where no force does.
pub(super) fn check_release(scene: &Scene) -> Result<(), Failure> {
    let Some(release) = scene.release else {
        return Ok(());
    };
    // Without a `to` a template ends with the force.
    let late = |template: &Template| template.from + 1 >= release;
    let found = scene
        .templates
        .iter()
        .enumerate()
        .find(|(_, template)| late(template));
    found.map_or(Ok(()), |(index, template)| {
        let why = format!(
            "is {}, but no force turns the flow from step {} on, since it is released at {release}; let it act sooner, or release the smoke later",
            template.from,
            release - 1
        );
        Err(scene.document.refuse(&format!("template[{index}].from"), why))
    })
}

/// One `[[template]]` as it stands in the file.
struct Given<'a> {
    document: &'a Document,
    grid: &'a Grid,
    steps: usize,
    table: Table,
    key: String,
}

impl Given<'_> {
    fn at(&self, name: &str) -> String {
        format!("{}.{name}", self.key)
    }

    fn dims(&self) -> usize {
        self.grid.cells.len()
    }

    fn template(&self) -> Result<Template, Failure> {
        self.document.only(&self.key, &self.table, KEYS)?;
        let kind = self.kind()?;
        let radius = self.radius()?;
        let [from, to] = self.span()?;
        let standard = Template::new(kind, self.center()?, radius, self.steps);
        Ok(Template {
            from,
            to,
            interval: self.whole("interval", to - from, 1..=self.steps)?,
            moves: self.moves()?,
            amplitude: self.amplitude(kind)?,
            size: self.of_noise(kind, "size", standard.size, |key, found| {
                self.document.positive_value(key, found)
            })?,
            seed: self.of_noise(kind, "seed", standard.seed, |key, found| {
                let seed = self.document.whole_value(key, found, 0..=u32::MAX as usize)?;
                Ok(u32::try_from(seed).unwrap_or_default())
            })?,
            ..standard
        })
    }

    fn kind(&self) -> Result<TemplateKind, Failure> {
        let key = self.at("kind");
        let remedy = "write what it does, as in kind = \"vortex\"";
        match self.document.required(&key, self.table.get("kind"), remedy)? {
            Value::String(word) => self.document.word(&key, word),
            other => Err(self
                .document
                .outside(&key, shown(other), "a word, as in \"vortex\",")),
        }
    }

    fn center(&self) -> Result<[f64; 3], Failure> {
        let (key, dims) = (self.at("center"), self.dims());
        let example = if dims == 2 {
            "[0.5, 0.5]"
        } else {
            "[0.5, 0.5, 0.5]"
        };
        let remedy = format!("write where its middle is, as in center = {example}");
        let found = self.document.required(&key, self.table.get("center"), &remedy)?;
        let numbers = self.document.numbers(&key, found, dims, example)?;
        let mut center = [0.0; 3];
        let most = self.grid.cells.iter().copied().max().unwrap_or(1) as f64;
        for (axis, ((to, x), &n)) in center.iter_mut().zip(numbers).zip(&self.grid.cells).enumerate() {
            let side = n as f64 / most * self.grid.length;
            if !(0.0..=side).contains(&x) {
                let why = format!(
                    "is {x:?} along {}, outside the box, which ends at {side}; move it inside",
                    ["x", "y", "z"][axis.min(2)]
                );
                return Err(self.document.refuse(&format!("{key}[{axis}]"), why));
            }
            *to = x;
        }
        Ok(center)
    }

    fn radius(&self) -> Result<f64, Failure> {
        let key = self.at("radius");
        let remedy = "write how far it reaches, as in radius = 0.1";
        let found = self.document.required(&key, self.table.get("radius"), remedy)?;
        let radius = self.document.positive_value(&key, found)?;
        let cell = self.grid.length / self.grid.cells.iter().copied().max().unwrap_or(1) as f64;
        if radius < cell {
            let why = format!(
                "is {radius:?}, but a cell has a side of {cell:?}, and no flow turns within one; make it larger, or raise `grid.cells`"
            );
            return Err(self.document.refuse(&key, why));
        }
        Ok(radius)
    }

    fn whole(
        &self,
        name: &str,
        otherwise: usize,
        allowed: core::ops::RangeInclusive<usize>,
    ) -> Result<usize, Failure> {
        match self.table.get(name) {
            None => Ok(otherwise),
            Some(found) => self.document.whole_value(&self.at(name), found, allowed),
        }
    }

    /// The forces that it is part of: from the first to the one after the last.
    fn span(&self) -> Result<[usize; 2], Failure> {
        let from = self.whole("from", 0, 0..=self.steps - 2)?;
        let to = self.whole("to", self.steps, 1..=self.steps)?;
        if from < to {
            return Ok([from, to]);
        }
        let why =
            format!("is {to}, but the template begins at step {from}; let it end later, or begin sooner");
        Err(self.document.refuse(&self.at("to"), why))
    }

    fn moves(&self) -> Result<bool, Failure> {
        match self.table.get("move") {
            None => Ok(false),
            Some(Value::Boolean(moves)) => Ok(*moves),
            Some(other) => Err(self
                .document
                .outside(&self.at("move"), shown(other), "true or false")),
        }
    }

    fn amplitude(&self, kind: TemplateKind) -> Result<[f64; 3], Failure> {
        let mut amplitude = [0.0; 3];
        let count = kind.numbers(self.dims());
        if let Some(found) = self.table.get("amplitude") {
            let example = ["0.01", "[0.01, 0.0]", "[0.0, 0.0, 0.01]"][count.clamp(1, 3) - 1];
            let numbers = self
                .document
                .numbers(&self.at("amplitude"), found, count, example)?;
            amplitude
                .iter_mut()
                .zip(numbers)
                .for_each(|(to, from)| *to = from);
        }
        Ok(amplitude)
    }

    /// What only noise has.
    fn of_noise<V>(
        &self,
        kind: TemplateKind,
        name: &str,
        otherwise: V,
        read: impl FnOnce(&str, &Value) -> Result<V, Failure>,
    ) -> Result<V, Failure> {
        let key = self.at(name);
        match self.table.get(name) {
            None => Ok(otherwise),
            Some(found) if kind == TemplateKind::Noise => read(&key, found),
            Some(_) => {
                let why = "is a key of noise alone; take it out, or write kind = \"noise\"";
                Err(self.document.refuse(&key, why))
            }
        }
    }
}

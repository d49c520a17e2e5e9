//! From a text to the outlines of its glyphs.
//!
//! The built-in font is DejaVu Sans Bold (crate `dejavu`; free, its licence stands in `DEJAVU-LICENSE.txt`): its
//! strokes, a quarter of the height of a capital, are wide enough to be carried by smoke.

use rustybuzz::Face;
use ttf_parser::OutlineBuilder;

use super::outline::{Outline, Point};
use super::shaping::{Placed, is_ignorable, shape};
use crate::guard::guarded;

/// Straight pieces that a curve is cut into.
const PIECES: usize = 12;
/// More letters than this are not legible on any grid.
const MOST_LETTERS: usize = 256;

/// What is found where the shaping of a text ends in a panic.
const DAMAGED: &str = "is damaged: its tables contradict themselves";

/// A text, one outline a glyph, in em from the first line's baseline.
pub(super) struct Lettering {
    pub outlines: Vec<Outline>,
    /// Height of a capital letter, in em.
    pub capital: f64,
}

/// Why a text has no outlines.
pub(super) enum Trouble {
    /// The font file will not do: what was found.
    Font(String),
    /// The text will not do: what was found, what to do.
    Text(String, &'static str),
}

/// The bytes of the font that is built in.
pub(super) fn built_in() -> &'static [u8] {
    dejavu::sans::bold()
}

/// Sets `text`, line by line.
pub(super) fn set(text: &str, font: &[u8]) -> Result<Lettering, Trouble> {
    // rustybuzz panics on some tables that contradict themselves.
    let damaged = || Err(Trouble::Font(DAMAGED.into()));
    guarded(|| set_as_it_is(text, font)).unwrap_or_else(damaged)
}

fn set_as_it_is(text: &str, font: &[u8]) -> Result<Lettering, Trouble> {
    let face = Face::from_slice(font, 0).ok_or_else(|| {
        let error = ttf_parser::Face::parse(font, 0).err();
        let why = error.map_or_else(|| "it has no shapes".to_owned(), |error| error.to_string());
        Trouble::Font(format!("is no TrueType or OpenType font ({why})"))
    })?;
    if text.chars().count() > MOST_LETTERS {
        return Err(Trouble::Text(
            format!("has more than {MOST_LETTERS} letters"),
            "shorten it",
        ));
    }
    let em = f64::from(face.units_per_em());
    let mut outlines = Vec::new();
    let placed = shape(text, &face);
    refuse_unknown(text, &placed)?;
    let mut inked = vec![false; text.len()];
    // What is left of glyph 0, the box for letters that a font has not, are blanks such as tabs: they have none.
    for placed in placed.iter().filter(|placed| placed.glyph.0 != 0) {
        let mut pencil = Pencil {
            em,
            pen: placed.at.map(|place| place / em),
            contours: Vec::new(),
        };
        face.outline_glyph(placed.glyph, &mut pencil);
        let outline = Outline::new(&pencil.contours);
        if outline.is_some() {
            inked
                .get_mut(placed.letters.clone())
                .unwrap_or_default()
                .fill(true);
        }
        outlines.extend(outline);
    }
    refuse_inkless(text, &inked)?;
    if outlines.is_empty() {
        return Err(Trouble::Text(
            format!("is {text:?}"),
            "write at least one letter that leaves ink",
        ));
    }
    Ok(Lettering {
        outlines,
        capital: capital(&face, em),
    })
}

/// Whether a letter needs no ink.
fn is_blank(letter: char) -> bool {
    letter.is_whitespace() || is_ignorable(letter)
}

/// Refuses a letter that the font does not have.
fn refuse_unknown(text: &str, placed: &[Placed]) -> Result<(), Trouble> {
    let unknown = placed.iter().filter(|placed| placed.glyph.0 == 0);
    let mut letters = unknown.flat_map(|placed| text.get(placed.letters.clone()).unwrap_or_default().chars());
    match letters.find(|&letter| !is_blank(letter)) {
        None => Ok(()),
        Some(letter) => {
            let found = format!("has the letter {letter:?}, which the font does not have");
            Err(Trouble::Text(found, "leave it out, or name a `font` that has it"))
        }
    }
}

/// Refuses a letter that should leave ink and does not.
fn refuse_inkless(text: &str, inked: &[bool]) -> Result<(), Trouble> {
    let inkless = |&(at, letter): &(usize, char)| {
        !is_blank(letter) && !letter.is_control() && inked.get(at) == Some(&false)
    };
    match text.char_indices().find(inkless) {
        None => Ok(()),
        Some((_, letter)) => {
            let found = format!("has the letter {letter:?}, whose glyph has no outline in the font");
            Err(Trouble::Text(found, "leave it out, or name another `font`"))
        }
    }
}

/// Height of a capital letter: the font's own word for it, or the height of its H.
fn capital(face: &Face<'_>, em: f64) -> f64 {
    let of_h = || Some(face.glyph_bounding_box(face.glyph_index('H')?)?.y_max);
    let height = face
        .capital_height()
        .or_else(of_h)
        .map_or(0.7, |height| f64::from(height) / em);
    if (0.1..10.0).contains(&height) {
        height
    } else {
        0.7
    }
}

/// Draws a glyph as polygons, in em.
struct Pencil {
    em: f64,
    pen: Point,
    contours: Vec<Vec<Point>>,
}

impl Pencil {
    fn place(&self, x: f32, y: f32) -> Point {
        [
            f64::from(x) / self.em + self.pen[0],
            f64::from(y) / self.em + self.pen[1],
        ]
    }

    fn push(&mut self, point: Point) {
        if let Some(contour) = self.contours.last_mut() {
            contour.push(point);
        }
    }

    fn last(&self) -> Point {
        self.contours
            .last()
            .and_then(|contour| contour.last())
            .copied()
            .unwrap_or_default()
    }

    /// A Bezier curve from the last point, of any degree.
    fn curve(&mut self, through: &[Point]) {
        let mut control = vec![self.last()];
        control.extend(through);
        for piece in 1..=PIECES {
            let part = piece as f64 / PIECES as f64;
            let mut points = control.clone();
            while points.len() > 1 {
                let mix = |pair: &[Point]| {
                    core::array::from_fn(|axis| pair[0][axis] + part * (pair[1][axis] - pair[0][axis]))
                };
                points = points.windows(2).map(mix).collect();
            }
            points.into_iter().for_each(|point| self.push(point));
        }
    }
}

impl OutlineBuilder for Pencil {
    fn move_to(&mut self, x: f32, y: f32) {
        let point = self.place(x, y);
        self.contours.push(vec![point]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let point = self.place(x, y);
        self.push(point);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let through = [self.place(x1, y1), self.place(x, y)];
        self.curve(&through);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let through = [self.place(x1, y1), self.place(x2, y2), self.place(x, y)];
        self.curve(&through);
    }

    fn close(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What tells of how a letter looks leaves no ink of its own, not even the box that stands for an unknown one.
    #[test]
    fn selectors_and_joiners_leave_no_ink() {
        for text in ["F", "F\u{fe0f}", "F\u{200d}", "\u{2060}F"] {
            let found = set(text, built_in()).map(|lettering| lettering.outlines.len());
            assert!(matches!(found, Ok(1)), "{text:?}");
        }
        assert!(matches!(set("\u{10ffff}", built_in()), Err(Trouble::Text(..))));
    }

    #[test]
    fn a_letter_without_ink_is_named() {
        let found = refuse_inkless("a b", &[true, false, false]);
        assert!(matches!(found, Err(Trouble::Text(found, _)) if found.contains("'b'")));
        assert!(refuse_inkless("a b", &[true, false, true]).is_ok());
    }

    /// OpenType's curves have two points between their ends; DejaVu's have one.
    #[test]
    fn curves_of_both_kinds_go_through_the_middle() {
        let drawn = |draw: &dyn Fn(&mut Pencil)| {
            let mut pencil = Pencil {
                em: 2.0,
                pen: [1.0, 0.0],
                contours: Vec::new(),
            };
            pencil.move_to(0.0, 0.0);
            draw(&mut pencil);
            let contour = pencil.contours.remove(0);
            (contour[PIECES / 2], *contour.last().unwrap_or(&[0.0; 2]))
        };
        let end = [3.0, 0.0];
        assert_eq!(
            drawn(&|pencil| pencil.quad_to(2.0, 4.0, 4.0, 0.0)),
            ([2.0, 1.0], end)
        );
        assert_eq!(
            drawn(&|pencil| pencil.curve_to(0.0, 4.0, 4.0, 4.0, 4.0, 0.0)),
            ([2.0, 1.5], end)
        );
    }
}

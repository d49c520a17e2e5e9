//! From a text to placed glyphs: lines one below the other, each in the order in which it is seen (unicode-bidi), shaped run by run
//! (rustybuzz, HarfBuzz in Rust): ligatures, kerning, letters that join.

use core::ops::Range;

use rustybuzz::{Direction, Face, UnicodeBuffer};
use ttf_parser::GlyphId;
use unicode_bidi::BidiInfo;
use unicode_script::{Script, UnicodeScript};

/// A glyph with its pen's place, in the font's units from the first line's baseline: its beginning, or of several lines the middle.
pub(super) struct Placed {
    pub glyph: GlyphId,
    pub at: [f64; 2],
    /// The letters that it stands for, as bytes of the text.
    pub letters: Range<usize>,
}

/// Places the glyphs of `text`; its lines are centred.
pub(super) fn shape(text: &str, face: &Face<'_>) -> Vec<Placed> {
    let height = f64::from(face.ascender()) - f64::from(face.descender()) + f64::from(face.line_gap());
    let mut placed = Vec::new();
    let mut begin = 0;
    for (number, whole) in text.split('\n').enumerate() {
        let line = whole.strip_suffix('\r').unwrap_or(whole);
        let first = placed.len();
        let mut pen = 0.0;
        for run in runs(line) {
            pen = shape_run(line, &run, face, pen, &mut placed);
        }
        let middle = if text.contains('\n') { 0.5 * pen } else { 0.0 };
        for glyph in placed.iter_mut().skip(first) {
            glyph.at[0] -= middle;
            glyph.at[1] -= height * number as f64;
            glyph.letters = glyph.letters.start + begin..glyph.letters.end + begin;
        }
        begin += whole.len() + 1;
    }
    placed
}

/// A part of a line that is of one script and one direction.
struct Run {
    bytes: Range<usize>,
    direction: Direction,
}

/// The runs of a line from left to right.
fn runs(line: &str) -> Vec<Run> {
    let bidi = BidiInfo::new(line, None);
    let mut runs = Vec::new();
    for paragraph in &bidi.paragraphs {
        let (levels, visual) = bidi.visual_runs(paragraph, paragraph.range.clone());
        for run in visual {
            let backwards = levels.get(run.start).is_some_and(|level| level.is_rtl());
            let direction = if backwards {
                Direction::RightToLeft
            } else {
                Direction::LeftToRight
            };
            let mut parts = of_one_script(line, run);
            if backwards {
                parts.reverse();
            }
            runs.extend(parts.into_iter().map(|bytes| Run { bytes, direction }));
        }
    }
    runs
}

/// Cuts a run where the script changes; marks, spaces and the like go with the letters before them.
fn of_one_script(line: &str, run: Range<usize>) -> Vec<Range<usize>> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    let mut script = Script::Common;
    for (at, letter) in line.get(run.clone()).unwrap_or_default().char_indices() {
        let (at, own) = (run.start + at, letter.script());
        let plain = |script: Script| matches!(script, Script::Common | Script::Inherited | Script::Unknown);
        let end = at + letter.len_utf8();
        match parts.last_mut() {
            Some(part) if plain(own) || plain(script) || own == script => part.end = end,
            _ => parts.push(at..end),
        }
        if !plain(own) {
            script = own;
        }
    }
    parts
}

/// Shapes a run from `pen` on; where the pen is then.
fn shape_run(line: &str, run: &Run, face: &Face<'_>, pen: f64, placed: &mut Vec<Placed>) -> f64 {
    let mut buffer = UnicodeBuffer::new();
    buffer.push_str(line.get(run.bytes.clone()).unwrap_or_default());
    buffer.guess_segment_properties();
    buffer.set_direction(run.direction);
    let glyphs = rustybuzz::shape(face, &[], buffer);
    let mut starts: Vec<usize> = glyphs
        .glyph_infos()
        .iter()
        .map(|info| info.cluster as usize)
        .collect();
    starts.sort_unstable();
    starts.push(run.bytes.len());
    let mut pen = [pen, 0.0];
    for (info, position) in glyphs.glyph_infos().iter().zip(glyphs.glyph_positions()) {
        let start = info.cluster as usize;
        let end = starts
            .iter()
            .copied()
            .find(|&next| next > start)
            .unwrap_or(run.bytes.len());
        placed.push(Placed {
            glyph: GlyphId(u16::try_from(info.glyph_id).unwrap_or(0)),
            at: [
                pen[0] + f64::from(position.x_offset),
                pen[1] + f64::from(position.y_offset),
            ],
            letters: run.bytes.start + start..run.bytes.start + end,
        });
        pen[0] += f64::from(position.x_advance);
        pen[1] += f64::from(position.y_advance);
    }
    pen[0]
}

/// Whether a letter leaves no ink where a font does not know it: what Unicode calls default-ignorable.
pub(super) fn is_ignorable(letter: char) -> bool {
    matches!(
        letter as u32,
        0xad | 0x34f | 0x61c | 0x115f..=0x1160 | 0x17b4..=0x17b5 | 0x180b..=0x180f | 0x200b..=0x200f | 0x202a..=0x202e
            | 0x2060..=0x206f | 0x3164 | 0xfe00..=0xfe0f | 0xfeff | 0xffa0 | 0xfff0..=0xfff8 | 0x1bca0..=0x1bca3
            | 0x1d173..=0x1d17a | 0xe0000..=0xe0fff
    )
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn set(text: &str) -> Vec<Placed> {
        shape(text, &Face::from_slice(dejavu::sans::bold(), 0).unwrap())
    }

    /// The letters of a text from left to right, as each glyph stands for them.
    fn seen(text: &str) -> Vec<&str> {
        let mut placed = set(text);
        placed.sort_by(|one, other| one.at[0].total_cmp(&other.at[0]));
        placed
            .iter()
            .map(|glyph| text.get(glyph.letters.clone()).unwrap())
            .collect()
    }

    #[test]
    fn letters_stand_in_the_order_in_which_they_are_read() {
        assert_eq!(seen("שלום"), ["ם", "ו", "ל", "ש"]);
        assert_eq!(
            seen("ab שלום 12"),
            ["a", "b", " ", "1", "2", " ", "ם", "ו", "ל", "ש"]
        );
    }

    /// Runs of another script that are read from the right follow on the left.
    #[test]
    fn scripts_are_shaped_one_by_one() {
        assert_eq!(seen("של بد"), ["د", "ب", " ", "ל", "ש"]);
        assert_eq!(of_one_script("ab β γ1δ", 0..11), [0..3, 3..11]);
        assert_eq!(of_one_script("1a2", 0..3), [0..3; 1]);
    }

    #[test]
    fn letters_join_and_give_way() {
        // Lam and alef are one glyph, and beh between others is not the one that stands alone.
        assert_eq!(seen("لا"), ["لا"]);
        let (alone, joined) = (set("ب"), set("ببب"));
        assert!(joined.len() == 3 && joined.iter().all(|glyph| glyph.glyph != alone[0].glyph));
        let (close, apart) = (set("AV"), set("AH"));
        assert!(close[1].at[0] < apart[1].at[0]);
    }

    #[test]
    fn lines_are_centred_one_below_the_other() {
        let placed = set("H\r\nHH");
        let [alone, first, second] = [0, 1, 2].map(|number| placed[number].at);
        let wide = second[0] - first[0];
        assert_eq!(alone[0], -0.5 * wide);
        assert_eq!(first[0], -wide);
        assert!(first[1] == second[1] && first[1] < alone[1] - 0.9 * wide);
        assert_eq!(placed[1].letters, 3..4);
    }
}

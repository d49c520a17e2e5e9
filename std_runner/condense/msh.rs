//! Gmsh's .msh files, ASCII, versions 2.2 and 4.1.

use super::parsed::{Parsed, Read, coordinate, number};
use core::iter::Enumerate;
use core::str::{Lines, SplitWhitespace};

/// Most vertices, elements and tags.
const MOST: usize = 20_000_000;

/// The words of a .msh file one by one, with the line of each.
struct Words<'a> {
    text: &'a str,
    lines: Enumerate<Lines<'a>>,
    /// What is left of line `line`.
    words: SplitWhitespace<'a>,
    line: usize,
    /// The line of the last word.
    last: usize,
}

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            text,
            lines: text.lines().enumerate(),
            words: "".split_whitespace(),
            line: 1,
            last: 1,
        }
    }

    fn word(&mut self) -> (usize, Option<&'a str>) {
        loop {
            if let Some(word) = self.words.next() {
                self.last = self.line;
                return (self.line, Some(word));
            }
            let Some((index, line)) = self.lines.next() else {
                return (self.last, None);
            };
            (self.line, self.words) = (index + 1, line.split_whitespace());
        }
    }

    fn whole(&mut self, what: &str) -> Read<u64> {
        let (line, word) = self.word();
        number(word, line, what)
    }

    /// How many of something follow: no more than the file can have words.
    fn count(&mut self, what: &str) -> Read<usize> {
        let count = self.whole(what)? as usize;
        if count > MOST || count > self.text.len().div_ceil(2) {
            return Err(format!(
                "says that it has {count} {what}, more than it can hold; it is damaged"
            ));
        }
        Ok(count)
    }

    fn place(&mut self) -> Read<[f64; 3]> {
        let mut place = [0.0; 3];
        for x in &mut place {
            let (line, word) = self.word();
            *x = coordinate(word, line)?;
        }
        Ok(place)
    }

    /// Goes behind `$name`.
    fn section(&mut self, name: &str) -> Read<()> {
        *self = Self::new(self.text);
        loop {
            match self.word().1 {
                Some(word) if word == name => return Ok(()),
                Some(_) => {}
                None => return Err(format!("has no {name}; it is damaged")),
            }
        }
    }

    fn ends(&mut self, name: &str) -> Read<()> {
        let (line, word) = self.word();
        if word == Some(name) {
            return Ok(());
        }
        Err(format!(
            "has \"{}\" in line {line} where {name} belongs; it is damaged",
            word.unwrap_or("nothing")
        ))
    }
}

/// Reads a .msh file.
pub(super) fn msh(text: &str) -> Read<Parsed> {
    let mut words = Words::new(text);
    words.section("$MeshFormat")?;
    let (line, word) = words.word();
    let version: f64 = number(word, line, "the version of the format")?;
    if words.whole("the kind of the file")? != 0 {
        return Err("is binary; save it in ASCII (Mesh.Binary = 0)".into());
    }
    let mut parsed = Parsed::default();
    if version == 2.2 {
        older(&mut words, &mut parsed)?;
    } else if version == 4.1 {
        newer(&mut words, &mut parsed)?;
    } else {
        return Err(format!("is of version {version}; save it as 4.1 or 2.2"));
    }
    Ok(parsed)
}

/// Version 2.2: vertices and elements one by one.
fn older(words: &mut Words<'_>, parsed: &mut Parsed) -> Read<()> {
    words.section("$Nodes")?;
    for _ in 0..words.count("vertices")? {
        let number = words.whole("the number of a vertex")?;
        parsed.vertices.insert(number, words.place()?);
    }
    words.ends("$EndNodes")?;
    words.section("$Elements")?;
    for _ in 0..words.count("elements")? {
        words.whole("the number of an element")?;
        let kind = words.whole("the kind of an element")?;
        for _ in 0..words.count("tags")? {
            words.whole("a tag")?;
        }
        element(words, kind, parsed)?;
    }
    words.ends("$EndElements")
}

/// Version 4.1: in blocks.
fn newer(words: &mut Words<'_>, parsed: &mut Parsed) -> Read<()> {
    words.section("$Nodes")?;
    let blocks = words.count("blocks")?;
    let total = words.count("vertices")?;
    words.whole("the least number")?;
    words.whole("the largest number")?;
    let mut seen = 0;
    for _ in 0..blocks {
        words.whole("a dimension")?;
        words.whole("a tag")?;
        if words.whole("whether places are parametric")? != 0 {
            return Err("has parametric vertices; save it without (Mesh.SaveParametric = 0)".into());
        }
        let count = words.count("vertices of a block")?;
        let numbers: Read<Vec<u64>> = (0..count)
            .map(|_| words.whole("the number of a vertex"))
            .collect();
        for number in numbers? {
            parsed.vertices.insert(number, words.place()?);
        }
        seen += count;
    }
    agree("vertices", total, seen)?;
    words.ends("$EndNodes")?;
    words.section("$Elements")?;
    let blocks = words.count("blocks")?;
    let total = words.count("elements")?;
    words.whole("the least number")?;
    words.whole("the largest number")?;
    seen = 0;
    for _ in 0..blocks {
        words.whole("a dimension")?;
        words.whole("a tag")?;
        let kind = words.whole("the kind of elements")?;
        let count = words.count("elements of a block")?;
        for _ in 0..count {
            words.whole("the number of an element")?;
            element(words, kind, parsed)?;
        }
        seen += count;
    }
    agree("elements", total, seen)?;
    words.ends("$EndElements")
}

fn agree(what: &str, said: usize, found: usize) -> Read<()> {
    if said == found {
        return Ok(());
    }
    Err(format!(
        "says that it has {said} {what}, and its blocks have {found}; it is damaged"
    ))
}

/// The corners of an element: points and lines are passed over.
fn element(words: &mut Words<'_>, kind: u64, parsed: &mut Parsed) -> Read<()> {
    let corners = match kind {
        15 => 1,
        1 => 2,
        2 => 3,
        4 => 4,
        other => {
            return Err(format!(
                "has elements of kind {other}; mesh it by triangles or tetrahedra of first order"
            ));
        }
    };
    let mut found = [0; 4];
    for corner in found.iter_mut().take(corners) {
        *corner = words.whole("a corner")?;
    }
    match kind {
        2 => parsed.triangles.push([found[0], found[1], found[2]]),
        4 => parsed.tetrahedra.push(found),
        _ => {}
    }
    Ok(())
}

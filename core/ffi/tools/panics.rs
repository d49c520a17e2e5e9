//! Counts the places where a program linked with the library may panic, and holds the count against a committed one.
//!
//! `panics PROGRAM COMMITTED [--write]`. PROGRAM is an ELF file for a 64-bit little-endian machine, linked statically with the
//! library built with `host_panic`, so that every call that panics carries its place in the source: file, line and column, as
//! `core::panic::Location` lies in memory. Distinct places are counted, file by file; copies of a function for other precisions,
//! dimensions and instruction sets count once. What is checked at a place is told by the function that it calls, which `objdump` shows;
//! why the check holds is told by the part of the source that it stands in, in `PARTS`: a file in none of them is refused. COMMITTED is
//! all that as a table: the sum of its counts may only fall.

use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;

type Failure = Box<dyn core::error::Error>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [program, committed] => compare(program, committed),
        [program, committed, "--write"] => {
            count(program).and_then(|counts| Ok(std::fs::write(committed, table(&counts)?)?))
        }
        _ => Err("usage: panics PROGRAM COMMITTED [--write]".into()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("panics: {error}");
            ExitCode::FAILURE
        }
    }
}

fn compare(program: &str, committed: &str) -> Result<(), Failure> {
    let found = count(program)?;
    let (now, text) = (table(&found)?, std::fs::read_to_string(committed)?);
    let last = text
        .lines()
        .last()
        .and_then(|line| line.split_whitespace().next())
        .ok_or("the committed file is empty")?;
    let before = last.parse::<usize>()?;
    println!(
        "{} places where the library may panic; committed: {before}",
        found.sum()
    );
    if found.sum() > before {
        print!("{now}");
        return Err(format!("{} more than committed", found.sum() - before).into());
    }
    if now != text {
        println!("{committed} is not current: run this with --write and commit it");
    }
    Ok(())
}

/// Distinct places, by file and by what is checked there.
struct Counts(BTreeMap<String, BTreeMap<&'static str, usize>>);

impl Counts {
    fn sum(&self) -> usize {
        self.0.values().flat_map(BTreeMap::values).sum()
    }

    /// The files of a part, each with its counts.
    fn of<'a>(
        &'a self,
        part: &'a Part,
    ) -> impl Iterator<Item = (&'a String, &'a BTreeMap<&'static str, usize>)> {
        self.0.iter().filter(|(file, _)| part.has(file))
    }
}

/// A part of the source, and why what is checked there holds.
struct Part {
    name: &'static str,
    files: &'static [&'static str],
    holds: &'static str,
}

impl Part {
    /// Whether a file belongs to it.
    fn has(&self, file: &str) -> bool {
        self.files.iter().any(|start| file.starts_with(start))
    }
}

const PARTS: [Part; 8] = [
    Part {
        name: "interface",
        files: &["problem.rs", "solver/"],
        holds: "steps, keyframes, axes and lengths of arrays are compared with the problem, and refused, before they come here",
    },
    Part {
        name: "methods",
        files: &[
            "method/",
            "objective/",
            "optimise/",
        ],
        holds: "fields, sums and scratch are cut by the plan for the cells, steps, threads and pairs that are used here; there is always a finest level",
    },
    Part {
        name: "Navier-Stokes problem",
        files: &["nso/"],
        holds: "the plan cuts states, lines and rings by the sizes from which places in them are counted; neighbours are folded into the grid or left out",
    },
    Part {
        name: "transport",
        files: &["transport/"],
        holds: "states, terms and halos are cut by the grid's cells and rows; places followed backwards are folded or clamped into the grid before they are indices",
    },
    Part {
        name: "projection",
        files: &["poisson/"],
        holds: "levels, batches and panels are cut by the sizes from which places in them are counted; the halves of a row, even and odd, together have its length",
    },
    Part {
        name: "rows",
        files: &["field/", "force/", "grid/", "operators/"],
        holds: "rows and blocks of rows are counted from the grid by which the fields were cut; a problem whose grid has an axis without cells is refused",
    },
    Part {
        name: "parts and lanes",
        files: &["exec/", "memory/", "simd/"],
        holds: "the number of a part is below their count, the pool is as large as the plan that is carved from it, a vector is loaded where a whole one is left",
    },
    Part {
        name: "below",
        files: &["core/src/", "heapless-"],
        holds: "the language's own text of numbers, in buffers that it makes for it; steps of loops are never 0; no list is longer than a number that is refused above its capacity",
    },
];

/// What is checked, with the sums of all parts; then each part with its reason and its files; then the sum.
fn table(counts: &Counts) -> Result<String, Failure> {
    if let Some(file) = counts
        .0
        .keys()
        .find(|file| !PARTS.iter().any(|part| part.has(file)))
    {
        return Err(
            format!("{file} may panic and is in no part of PARTS, which says why it does not").into(),
        );
    }
    let mut kinds = BTreeMap::new();
    counts
        .0
        .values()
        .flatten()
        .for_each(|(kind, count)| *kinds.entry(kind).or_insert(0) += count);
    let mut text: String = kinds
        .iter()
        .map(|(kind, count)| format!("{count:5}  {kind}: {}\n", meaning(kind)))
        .collect();
    for part in &PARTS {
        let sum: usize = counts.of(part).flat_map(|(_, kinds)| kinds.values()).sum();
        text += &format!("\n{sum:5}  {}: {}\n", part.name, part.holds);
        for (file, kinds) in counts.of(part) {
            let kinds: Vec<String> = kinds
                .iter()
                .map(|(kind, count)| format!("{kind} {count}"))
                .collect();
            text += &format!("         {file}: {}\n", kinds.join(", "));
        }
    }
    Ok(text + &format!("\n{:5}  places in all\n", counts.sum()))
}

/// Functions of the language that panic, by a part of their names, what calls them, and what is asked there.
const KINDS: [(&str, &str, &str); 10] = [
    (
        "slice_index_fail",
        "range",
        "a slice has the numbers from here to there",
    ),
    (
        "panic_bounds_check",
        "index",
        "a slice has a number of this index",
    ),
    ("len_mismatch_fail", "copy", "two slices have the same length"),
    ("div_by_zero", "division", "a count is not 0"),
    ("rem_by_zero", "division", "a count is not 0"),
    ("assert_failed", "assertion", "what is asserted holds"),
    ("expect_failed", "value", "there is a value"),
    ("9panicking5panic", "assertion", "what is asserted holds"),
    (
        "9panicking",
        "split",
        "a slice is long enough to be split there, or chunks are not empty",
    ),
    ("", "unknown", "no call was found that belongs to it"),
];

fn meaning(kind: &str) -> &'static str {
    KINDS
        .iter()
        .find(|(_, name, _)| *name == kind)
        .map_or("", |(_, _, meaning)| meaning)
}

/// What is checked before a function of the language is called that panics.
fn kind(function: &str) -> Option<&'static str> {
    KINDS
        .iter()
        .find(|(part, ..)| !part.is_empty() && function.contains(part))
        .map(|(_, kind, _)| *kind)
}

/// What is checked at the places at these addresses: the last one that was loaded before a call that panics is the call's.
fn kinds(program: &str, places: &BTreeMap<u64, Place>) -> Result<BTreeMap<Place, &'static str>, Failure> {
    let shown = std::process::Command::new("objdump")
        .args(["-d", "--no-show-raw-insn", program])
        .output()?;
    let mut kinds = BTreeMap::new();
    let mut loaded = None;
    for line in String::from_utf8_lossy(&shown.stdout).lines() {
        let address = line
            .split_once("# ")
            .and_then(|(_, rest)| u64::from_str_radix(rest.split_whitespace().next()?, 16).ok());
        if let Some(place) = address.and_then(|address| places.get(&address)) {
            loaded = Some(place.clone());
        }
        let function = line
            .split_once("call ")
            .and_then(|(_, rest)| rest.split_once('<'))
            .map(|(_, name)| name);
        if let Some(kind) = function.and_then(kind) {
            loaded.take().map(|place| kinds.insert(place, kind));
        }
    }
    Ok(kinds)
}

/// File, line and column.
type Place = (String, u32, u32);

/// A part of the program that is in memory when it runs.
struct Section<'a> {
    address: u64,
    bytes: &'a [u8],
    code: bool,
}

fn number<const N: usize>(bytes: &[u8], at: usize) -> Result<[u8; N], Failure> {
    let found = bytes.get(at..).and_then(|rest| rest.first_chunk::<N>());
    Ok(*found.ok_or("the program ends too early")?)
}

fn sections(file: &[u8]) -> Result<Vec<Section<'_>>, Failure> {
    if !file.starts_with(b"\x7fELF\x02\x01") {
        return Err("not an ELF file for a 64-bit little-endian machine".into());
    }
    let table = u64::from_le_bytes(number(file, 0x28)?) as usize;
    let (size, count) = (
        u16::from_le_bytes(number(file, 0x3a)?) as usize,
        u16::from_le_bytes(number(file, 0x3c)?) as usize,
    );
    let mut list = Vec::new();
    for header in (0..count).map(|index| table + index * size) {
        let (kind, flags) = (
            u32::from_le_bytes(number(file, header + 4)?),
            u64::from_le_bytes(number(file, header + 8)?),
        );
        let word = |at: usize| Ok::<_, Failure>(u64::from_le_bytes(number(file, header + at)?));
        let (address, start, length) = (word(0x10)?, word(0x18)? as usize, word(0x20)? as usize);
        // Bytes of the program (SHT_PROGBITS) that are in memory (SHF_ALLOC).
        if kind == 1 && flags & 2 != 0 {
            let bytes = file.get(start..start + length).ok_or("a section is not there")?;
            list.push(Section {
                address,
                bytes,
                code: flags & 4 != 0,
            });
        }
    }
    Ok(list)
}

/// The text at an address.
fn text_at<'a>(sections: &[Section<'a>], address: u64, length: u64) -> Option<&'a str> {
    let section = sections
        .iter()
        .find(|section| (section.address..section.address + section.bytes.len() as u64).contains(&address))?;
    let start = (address - section.address) as usize;
    core::str::from_utf8(section.bytes.get(start..start.checked_add(length as usize)?)?).ok()
}

/// Finds the places of a program.
fn count(program: &str) -> Result<Counts, Failure> {
    let file = std::fs::read(program)?;
    let sections = sections(&file)?;
    let mut places = BTreeMap::new();
    for section in sections.iter().filter(|section| !section.code) {
        // A place is 24 bytes on a multiple of 8: where the name of the file is, its length, line, column.
        for at in (0..section.bytes.len().saturating_sub(23)).step_by(8) {
            let (name, length) = (
                u64::from_le_bytes(number(section.bytes, at)?),
                u64::from_le_bytes(number(section.bytes, at + 8)?),
            );
            let (line, column) = (
                u32::from_le_bytes(number(section.bytes, at + 16)?),
                u32::from_le_bytes(number(section.bytes, at + 20)?),
            );
            if (4..400).contains(&length) && (1..100_000).contains(&line) && (1..1000).contains(&column) {
                let name = text_at(&sections, name, length).filter(|name| name.ends_with(".rs"));
                places.extend(name.map(|name| (section.address + at as u64, (short(name), line, column))));
            }
        }
    }
    if places.is_empty() {
        return Err("there is no place at all: was the library built with host_panic?".into());
    }
    let kinds = kinds(program, &places)?;
    let mut counts = Counts(BTreeMap::new());
    for place in places.into_values().collect::<BTreeSet<_>>() {
        let kind = kinds.get(&place).copied().unwrap_or("unknown");
        *counts.0.entry(place.0).or_default().entry(kind).or_insert(0) += 1;
    }
    Ok(counts)
}

/// The name of a file as it does not depend on the machine: from the last `core/` or `registry/` on.
fn short(name: &str) -> String {
    let known = ["/library/", "/registry/src/"]
        .iter()
        .find_map(|mark| name.split_once(mark));
    match known {
        Some((_, rest)) => rest
            .split_once('/')
            .filter(|(head, _)| head.starts_with("index."))
            .map_or(rest, |(_, rest)| rest)
            .to_owned(),
        None => name
            .rsplit_once("/core/")
            .map_or(name, |(_, rest)| rest)
            .to_owned(),
    }
}

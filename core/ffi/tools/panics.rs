//! Counts the places where a program linked with the library may panic, and holds the count against a committed one.
//!
//! `panics PROGRAM COMMITTED [--write]`. PROGRAM is an ELF file for a 64-bit little-endian machine, linked statically with the
//! library built with `host_panic`, so that every call that panics carries its place in the source: file, line and column, as
//! `core::panic::Location` lies in memory. Distinct places are counted, file by file; copies of a function for other precisions,
//! dimensions and instruction sets count once. The reason of a place is the function that it calls, which `objdump` shows. COMMITTED
//! holds the counts: their sum may only fall.

use std::collections::{BTreeMap, BTreeSet};
use std::process::ExitCode;

type Failure = Box<dyn core::error::Error>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [program, committed] => compare(program, committed),
        [program, committed, "--write"] => count(program).and_then(|counts| Ok(std::fs::write(committed, table(&counts))?)),
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
    let text = std::fs::read_to_string(committed)?;
    let last = text.lines().last().and_then(|line| line.split_whitespace().next()).ok_or("the committed file is empty")?;
    let (now, before) = (found.sum(), last.parse::<usize>()?);
    println!("{now} places where the library may panic; committed: {before}");
    if now > before {
        print!("{}", table(&found));
        return Err(format!("{} more than committed", now - before).into());
    }
    if now < before {
        println!("commit the lower count: run this with --write");
    }
    Ok(())
}

/// Distinct places.
struct Counts {
    by_file: BTreeMap<String, usize>,
    by_reason: BTreeMap<&'static str, usize>,
}

impl Counts {
    fn sum(&self) -> usize {
        self.by_file.values().sum()
    }
}

/// One line for each reason and each file, and the sum.
fn table(counts: &Counts) -> String {
    let line = |name: &str, count: &usize| format!("{count:5}  {name}\n");
    let reasons: String = counts.by_reason.iter().map(|(reason, count)| line(reason, count)).collect();
    let files: String = counts.by_file.iter().map(|(file, count)| line(file, count)).collect();
    format!("{reasons}\n{files}\n{}", line("places in all", &counts.sum()))
}

/// Why a function of the core library is called that panics.
fn reason(function: &str) -> Option<&'static str> {
    const REASONS: [(&str, &str); 8] = [
        ("slice_index_fail", "a range that a slice must have"),
        ("panic_bounds_check", "an index that a slice must have"),
        ("len_mismatch_fail", "a copy between slices of one length"),
        ("div_by_zero", "a division by a count that is not 0"),
        ("rem_by_zero", "a division by a count that is not 0"),
        ("assert_failed", "an assertion"),
        ("expect_failed", "a value that must be there"),
        ("9panicking", "a split, chunk or step that a slice must have"),
    ];
    REASONS.iter().find(|(part, _)| function.contains(part)).map(|(_, reason)| *reason)
}

/// The reasons of the places at these addresses: of the last one that was loaded before a call that panics.
fn reasons(program: &str, places: &BTreeMap<u64, Place>) -> Result<BTreeMap<Place, &'static str>, Failure> {
    let shown = std::process::Command::new("objdump").args(["-d", "--no-show-raw-insn", program]).output()?;
    let mut reasons = BTreeMap::new();
    let mut loaded = None;
    for line in String::from_utf8_lossy(&shown.stdout).lines() {
        let address = line.split_once("# ").and_then(|(_, rest)| u64::from_str_radix(rest.split_whitespace().next()?, 16).ok());
        if let Some(place) = address.and_then(|address| places.get(&address)) {
            loaded = Some(place.clone());
        }
        let function = line.split_once("call ").and_then(|(_, rest)| rest.split_once('<')).map(|(_, name)| name);
        if let Some(reason) = function.and_then(reason) {
            loaded.take().map(|place| reasons.insert(place, reason));
        }
    }
    Ok(reasons)
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
    let (size, count) = (u16::from_le_bytes(number(file, 0x3a)?) as usize, u16::from_le_bytes(number(file, 0x3c)?) as usize);
    let mut list = Vec::new();
    for header in (0..count).map(|index| table + index * size) {
        let (kind, flags) = (u32::from_le_bytes(number(file, header + 4)?), u64::from_le_bytes(number(file, header + 8)?));
        let word = |at: usize| Ok::<_, Failure>(u64::from_le_bytes(number(file, header + at)?));
        let (address, start, length) = (word(0x10)?, word(0x18)? as usize, word(0x20)? as usize);
        // Bytes of the program (SHT_PROGBITS) that are in memory (SHF_ALLOC).
        if kind == 1 && flags & 2 != 0 {
            let bytes = file.get(start..start + length).ok_or("a section is not there")?;
            list.push(Section { address, bytes, code: flags & 4 != 0 });
        }
    }
    Ok(list)
}

/// The text at an address.
fn text_at<'a>(sections: &[Section<'a>], address: u64, length: u64) -> Option<&'a str> {
    let section = sections.iter().find(|section| (section.address..section.address + section.bytes.len() as u64).contains(&address))?;
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
            let (name, length) = (u64::from_le_bytes(number(section.bytes, at)?), u64::from_le_bytes(number(section.bytes, at + 8)?));
            let (line, column) = (u32::from_le_bytes(number(section.bytes, at + 16)?), u32::from_le_bytes(number(section.bytes, at + 20)?));
            if (4..400).contains(&length) && (1..100_000).contains(&line) && (1..1000).contains(&column) {
                let name = text_at(&sections, name, length).filter(|name| name.ends_with(".rs"));
                places.extend(name.map(|name| (section.address + at as u64, (short(name), line, column))));
            }
        }
    }
    if places.is_empty() {
        return Err("there is no place at all: was the library built with host_panic?".into());
    }
    let reasons = reasons(program, &places)?;
    let (mut by_file, mut by_reason) = (BTreeMap::new(), BTreeMap::new());
    for place in places.into_values().collect::<BTreeSet<_>>() {
        *by_reason.entry(reasons.get(&place).copied().unwrap_or("not found")).or_insert(0) += 1;
        *by_file.entry(place.0).or_insert(0) += 1;
    }
    Ok(Counts { by_file, by_reason })
}

/// The name of a file as it does not depend on the machine: from the last `core/` or `registry/` on.
fn short(name: &str) -> String {
    let known = ["/library/", "/registry/src/"].iter().find_map(|mark| name.split_once(mark));
    match known {
        Some((_, rest)) => rest.split_once('/').filter(|(head, _)| head.starts_with("index.")).map_or(rest, |(_, rest)| rest).to_owned(),
        None => name.rsplit_once("/core/").map_or(name, |(_, rest)| rest).to_owned(),
    }
}

//! Places in a program that may panic, found in its bytes and its machine code.

use crate::Failure;
use crate::counts::{Counts, kind};
use std::collections::{BTreeMap, BTreeSet};

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

/// The `N` bytes at `at`.
fn word_at<const N: usize>(bytes: &[u8], at: usize) -> Result<[u8; N], Failure> {
    let found = bytes.get(at..).and_then(|rest| rest.first_chunk::<N>());
    Ok(*found.ok_or("the program ends too early")?)
}

fn sections(file: &[u8]) -> Result<Vec<Section<'_>>, Failure> {
    if !file.starts_with(b"\x7fELF\x02\x01") {
        return Err("not an ELF file for a 64-bit little-endian machine".into());
    }
    let table = u64::from_le_bytes(word_at(file, 0x28)?) as usize;
    let (size, count) = (
        u16::from_le_bytes(word_at(file, 0x3a)?) as usize,
        u16::from_le_bytes(word_at(file, 0x3c)?) as usize,
    );
    let mut list = Vec::new();
    for header in (0..count).map(|index| table + index * size) {
        let (kind, flags) = (
            u32::from_le_bytes(word_at(file, header + 4)?),
            u64::from_le_bytes(word_at(file, header + 8)?),
        );
        let word = |at: usize| Ok::<_, Failure>(u64::from_le_bytes(word_at(file, header + at)?));
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
pub fn count(program: &str) -> Result<Counts, Failure> {
    let file = std::fs::read(program)?;
    let sections = sections(&file)?;
    let mut places = BTreeMap::new();
    for section in sections.iter().filter(|section| !section.code) {
        // A place is 24 bytes on a multiple of 8: where the name of the file is, its length, line, column.
        for at in (0..section.bytes.len().saturating_sub(23)).step_by(8) {
            let (name, length) = (
                u64::from_le_bytes(word_at(section.bytes, at)?),
                u64::from_le_bytes(word_at(section.bytes, at + 8)?),
            );
            let (line, column) = (
                u32::from_le_bytes(word_at(section.bytes, at + 16)?),
                u32::from_le_bytes(word_at(section.bytes, at + 20)?),
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

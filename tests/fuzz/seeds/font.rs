//! A font of few glyphs: DejaVu Sans Bold cut down to the first ones, so that what is changed of it matters.

/// Glyphs that stay: those of ASCII are among them.
const GLYPHS: usize = 128;

fn half(bytes: &[u8], at: usize) -> usize {
    usize::from(u16::from_be_bytes([bytes[at], bytes[at + 1]]))
}

fn word(bytes: &[u8], at: usize) -> usize {
    half(bytes, at) << 16 | half(bytes, at + 2)
}

/// The tables of a font by their names.
fn tables(font: &[u8]) -> Vec<([u8; 4], Vec<u8>)> {
    let entry = |index: usize| {
        let at = 12 + 16 * index;
        let (begin, size) = (word(font, at + 8), word(font, at + 12));
        (
            font[at..at + 4].try_into().unwrap(),
            font[begin..begin + size].to_vec(),
        )
    };
    (0..half(font, 4)).map(entry).collect()
}

/// Which glyphs letters have, one by one: format 6 for the letters of ASCII.
fn letters(font: &[u8]) -> Vec<u8> {
    let face = ttf_parser::Face::parse(font, 0).unwrap();
    let glyph = |letter: u8| face.glyph_index(char::from(letter)).map_or(0, |glyph| glyph.0);
    let count = 96_u16;
    let mut table = [0, 0, 0, 1, 0, 3, 0, 1, 0, 0, 0, 12, 0, 6].to_vec();
    table.extend((10 + 2 * count).to_be_bytes());
    table.extend([0, 0]);
    table.extend(32_u16.to_be_bytes());
    table.extend(count.to_be_bytes());
    table.extend((32..128).flat_map(|letter| glyph(letter).to_be_bytes()));
    table
}

/// The font with its first glyphs.
pub fn small(font: &[u8]) -> Vec<u8> {
    let all = tables(font);
    let find = |name: &[u8; 4]| &all.iter().find(|(found, _)| found == name).unwrap().1;
    let long = half(find(b"head"), 50) == 1;
    let end = if long {
        word(find(b"loca"), 4 * GLYPHS)
    } else {
        2 * half(find(b"loca"), 2 * GLYPHS)
    };
    let count = (GLYPHS as u16).to_be_bytes();
    let kept: Vec<([u8; 4], Vec<u8>)> = [
        b"GPOS", b"GSUB", b"cmap", b"glyf", b"head", b"hhea", b"hmtx", b"loca", b"maxp",
    ]
    .into_iter()
    .map(|name| {
        let mut table = find(name).clone();
        match name {
            b"cmap" => table = letters(font),
            b"glyf" => table.truncate(end),
            b"loca" => table.truncate((GLYPHS + 1) * if long { 4 } else { 2 }),
            b"hmtx" => table.truncate(4 * GLYPHS),
            b"hhea" => table[34..36].copy_from_slice(&count),
            b"maxp" => table[4..6].copy_from_slice(&count),
            _ => {}
        }
        (*name, table)
    })
    .collect();
    let mut small = font[..4].to_vec();
    small.extend((kept.len() as u16).to_be_bytes());
    small.extend([0; 6]);
    let mut begin = 12 + 16 * kept.len();
    for (name, table) in &kept {
        small.extend(name);
        small.extend([0; 4]);
        small.extend((begin as u32).to_be_bytes());
        small.extend((table.len() as u32).to_be_bytes());
        begin += table.len().next_multiple_of(4);
    }
    for (_, table) in &kept {
        small.extend(table);
        small.resize(small.len().next_multiple_of(4), 0);
    }
    small
}

//! `thurible.h`, read as far as a host without a C compiler needs it.

use std::fs;

/// A field of a structure.
#[derive(Clone, Debug)]
pub struct Field {
    pub declaration: String,
    pub name: String,
    /// Where it lies on wasm32.
    pub at: u32,
}

/// The text of the header.
pub fn text() -> String {
    fs::read_to_string(super::root().join("core/ffi/thurible.h")).unwrap()
}

/// The names of all functions.
pub fn functions() -> Vec<String> {
    let text = text();
    let code = text
        .lines()
        .filter(|line| !line.starts_with("//") && line.contains('('));
    code.filter_map(|line| {
        line.split('(')
            .next()?
            .rsplit([' ', '*'])
            .next()
            .filter(|name| name.starts_with("thurible_"))
            .map(str::to_owned)
    })
    .collect()
}

/// The number of an enumerator or a macro.
pub fn code(name: &str) -> u32 {
    let text = text();
    let line = text.lines().find(|line| {
        line.trim_start()
            .trim_start_matches("#define ")
            .split([' ', '='])
            .next()
            == Some(name)
    });
    let line = line.unwrap_or_else(|| panic!("thurible.h has no {name}"));
    line.rsplit(' ')
        .next()
        .unwrap()
        .trim_end_matches(',')
        .parse()
        .unwrap()
}

/// The fields of a structure and its bytes: a double takes eight, everything else four.
pub fn structure(name: &str) -> (Vec<Field>, u32) {
    let text = text();
    let body = text
        .split(&format!("}} {name};"))
        .next()
        .unwrap()
        .rsplit("typedef struct {")
        .next()
        .unwrap();
    let (mut fields, mut end) = (Vec::new(), 0_u32);
    for line in body
        .lines()
        .map(str::trim)
        .filter(|line| !line.is_empty() && !line.starts_with("//"))
    {
        let declaration = line.trim_end_matches(';').to_owned();
        let (front, count) = declaration
            .trim_end_matches(']')
            .split_once('[')
            .unwrap_or((&declaration, "1"));
        let name = front.rsplit([' ', '*']).next().unwrap().to_owned();
        let width = if front.starts_with("double ") && !front.contains('*') {
            8
        } else {
            4
        };
        let at = end.next_multiple_of(width);
        end = at + width * count.parse::<u32>().unwrap();
        fields.push(Field {
            declaration,
            name,
            at,
        });
    }
    (fields, end.next_multiple_of(8))
}

//! Words and signs of Rust source, and the paths that stand in them.

/// A word, `::` or a single sign; strings, comments and lifetimes are left out.
pub type Token = String;

/// The tokens of `text`, up to its unit tests.
pub fn tokens(text: &str) -> Vec<Token> {
    let text = text.split("#[cfg(test)]\nmod ").next().unwrap_or(text);
    let mut list = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = match first {
            _ if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            _ if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
            'r' if rest.starts_with("r\"") => 2 + rest[2..].find('"').map_or(0, |end| end + 1),
            '"' => string(rest),
            '\'' => letter_or_lifetime(rest),
            _ if first.is_alphanumeric() || first == '_' => {
                let end = |c: char| !(c.is_alphanumeric() || c == '_');
                let length = rest.find(end).unwrap_or(rest.len());
                list.push(rest[..length].to_owned());
                length
            }
            _ => {
                let length = if rest.starts_with("::") {
                    2
                } else {
                    first.len_utf8()
                };
                if !first.is_whitespace() {
                    list.push(rest[..length].to_owned());
                }
                length
            }
        };
        rest = &rest[length.max(first.len_utf8())..];
    }
    list
}

/// Bytes of the string that `text` begins with.
fn string(text: &str) -> usize {
    let mut escaped = true;
    for (at, c) in text.char_indices() {
        match c {
            '"' if !escaped => return at + 1,
            '\\' if !escaped => escaped = true,
            _ => escaped = false,
        }
    }
    text.len()
}

/// Bytes of `'a'`, `'\n'` or of the lifetime `'a`.
fn letter_or_lifetime(text: &str) -> usize {
    let inner = &text[1..];
    if inner.starts_with('\\') {
        return 2 + inner[2..].find('\'').map_or(0, |end| end + 2);
    }
    let letter = inner.chars().next().map_or(1, char::len_utf8);
    if inner[letter..].starts_with('\'') {
        letter + 2
    } else {
        1
    }
}

/// A path with all its segments, as in `crate::grid::Grid`.
pub type Segments = Vec<String>;

/// The paths that begin at `tokens[at]`, `{a, b::c}` taken apart, and where they end.
pub fn paths(tokens: &[Token], at: usize) -> (Vec<Segments>, usize) {
    let word = |at: usize| tokens.get(at).map_or("", String::as_str);
    if word(at) == "{" {
        let (mut all, mut at) = (Vec::new(), at + 1);
        while !matches!(word(at), "}" | "") {
            let (found, end) = paths(tokens, at);
            all.extend(found);
            at = end + usize::from(word(end) == ",");
        }
        return (all, at + 1);
    }
    let first = word(at).to_owned();
    let mut end = at + 1;
    let mut all = vec![vec![first.clone()]];
    if word(end) == "::" && !matches!(word(end + 1), "<" | "") {
        let (rest, after) = paths(tokens, end + 1);
        all = rest
            .into_iter()
            .map(|rest| [vec![first.clone()], rest].concat())
            .collect();
        end = after;
    }
    if word(end) == "as" {
        end += 2;
    }
    (all, end)
}

//! The parts of `performance.md` that commands write, between marks; what people wrote around them stays.

use super::files;
use std::fs;
use std::path::Path;
use thurible::exit::Failure;

/// The page that the commands share.
const PAGE: &str = "performance.md";

/// Refuses a folder that cannot be written, before anything is measured.
pub(super) fn check(folder: Option<&Path>) -> Result<(), Failure> {
    folder.map_or(Ok(()), files::check)
}

/// Puts `text` between the marks of part `name`, which come last if the page does not have them yet.
pub(super) fn write(folder: Option<&Path>, name: &str, text: &str) -> Result<(), Failure> {
    let Some(folder) = folder else { return Ok(()) };
    let path = folder.join(PAGE);
    let page = match fs::read_to_string(&path) {
        Ok(page) => page,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => "# Performance\n".into(),
        Err(error) => {
            return Err(Failure::File(format!(
                "cannot read {}: {error}; make it readable or choose another folder",
                path.display()
            )));
        }
    };
    files::put(folder, PAGE, &replaced(&page, name, text))
}

fn replaced(page: &str, name: &str, text: &str) -> String {
    let [begin, end] = [format!("<!-- begin {name} -->\n"), format!("<!-- end {name} -->")];
    let parts = page
        .split_once(&begin)
        .and_then(|(before, rest)| Some((before, rest.split_once(&end)?.1)));
    let (before, after) = parts.map_or_else(
        || (format!("{page}\n"), "\n"),
        |(before, after)| (before.into(), after),
    );
    format!("{before}{begin}\n{}\n\n{end}{after}", text.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_its_own_part_changes() {
        let once = replaced("# Title\n", "a", "first\n");
        assert_eq!(once, "# Title\n\n<!-- begin a -->\n\nfirst\n\n<!-- end a -->\n");
        let both = replaced(&format!("{once}By hand.\n"), "b", "other");
        assert_eq!(replaced(&both, "a", "first"), both);
        assert_eq!(replaced(&both, "a", "second"), both.replace("first", "second"));
        assert!(both.contains("By hand.\n\n<!-- begin b -->"));
    }
}

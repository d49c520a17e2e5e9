//! The folder of a page, and the page in it: shared by `compare` and `paper`.

use crate::console;
use crate::destination::Destination;
use crate::exit::Failure;
use crate::output::{OutputError, create_folder, write_bytes};
use crate::progress::{Display, Mode};
use crate::report::Document;
use serde_json::{Value, json};
use std::path::Path;

/// Refuses a folder that holds something else; else marks it as a result folder before anything is solved.
pub(crate) fn prepare(folder: &Path, stem: &str) -> Result<(), Failure> {
    let mark = format!("{stem}.json");
    Destination::check_for(folder, &mark)?;
    let cannot = |error: OutputError| Failure::File(error.to_string());
    create_folder(folder).map_err(cannot)?;
    let path = folder.join(mark);
    if path.exists() {
        Ok(())
    } else {
        write_bytes(&path, json!({ "format": 1 }).to_string().as_bytes()).map_err(cannot)
    }
}

/// Refuses a folder for a method below `folder` that holds something else.
pub(crate) fn check_below(folder: &Path, methods: &[String]) -> Result<(), Failure> {
    create_folder(folder).map_err(|error| Failure::File(error.to_string()))?;
    methods
        .iter()
        .try_for_each(|name| Destination::check(&folder.join(name)).map(drop))
}

/// Writes the page as HTML and Markdown, and its facts as JSON.
pub(crate) fn write(folder: &Path, stem: &str, page: &Document, facts: &Value) -> Result<(), Failure> {
    let path = folder.join(format!("{stem}.json"));
    let json = serde_json::to_vec_pretty(facts).map_err(OutputError::of(&path));
    json.and_then(|json| write_bytes(&path, &json))
        .and_then(|()| page.write(folder, stem))
        .map_err(|error| Failure::File(error.to_string()))
}

/// Prints the table and where the page is.
pub(crate) fn announce(mode: Mode, folder: &Path, stem: &str, table: &str, facts: Value) {
    let page = folder.join(format!("{stem}.html"));
    match mode {
        Mode::Human => {
            console::print(&format!("\n{table}"));
            console::print(&format!("the page is {}", page.display()));
        }
        Mode::Json => {
            let mut fields = facts;
            fields["page"] = page.display().to_string().into();
            Display::new(Mode::Json, 0).event(stem, fields);
        }
        Mode::Quiet => {}
    }
}

//! `thurible new NAME`: a commented scene to start from.

use super::schema;
use super::words::Words;
use crate::condense::{preset, preset_names};
use crate::console;
use crate::exit::{DONE, Failure};
use crate::scene::{section, steering};
use clap::Args;
use std::ffi::OsStr;
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use thurible_core::choices::{Choices, Kind, Value};
use thurible_core::{FluidsParams, Method, Named, Params, stable_fluids};

/// The scene that `new` writes, but for its name, the names of the methods and their tables of choices.
const TEMPLATE: &str = include_str!("template.toml");
/// Where comments begin in it.
const COMMENTS: usize = 35;

/// Arguments of `new`.
#[derive(Args, Debug)]
pub struct NewArguments {
    /// Name of the scene; NAME.toml is written, and the schema by which editors check it beside it.
    pub name: PathBuf,
    /// Write this problem of `thurible condense` instead: rod, stretch, cantilever, buckle, noise or spring, or one with _3d at its end.
    #[arg(long, value_name = "P", value_parser = Words(preset_names()), hide_possible_values = true)]
    pub preset: Option<String>,
    /// Print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}

/// Writes the scene; the answer is the exit code.
pub fn run(arguments: &NewArguments) -> Result<u8, Failure> {
    let path = scene_path(&arguments.name)?;
    let shown = path.display();
    let name = path
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let (text, command) = match &arguments.preset {
        Some(asked) => {
            let found = preset(asked).ok_or_else(|| {
                Failure::Input(format!(
                    "--preset {asked}: there is no such preset; presets are {}",
                    preset_names().join(", ")
                ))
            })?;
            (found.text.to_owned(), "condense")
        }
        None => (template(&name), "solve"),
    };
    let written = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&path)
        .and_then(|mut file| {
            // A part of a scene is of no use.
            file.write_all(text.as_bytes())
                .inspect_err(|_| drop(fs::remove_file(&path)))
        });
    written.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => Failure::File(format!(
            "{shown} is there already and is not overwritten; choose another name"
        )),
        _ => Failure::File(format!(
            "cannot write {shown}: {error}; choose a folder that exists and can be written"
        )),
    })?;
    let schema = match arguments.preset {
        Some(_) => None,
        None => schema::write_beside(&path)?,
    };
    if !arguments.quiet {
        if let Some(schema) = schema {
            console::print(&format!("wrote {}, by which editors check it", schema.display()));
        }
        console::print(&format!(
            "wrote {shown}; solve it with: thurible {command} {}",
            console::quoted_path(&path)
        ));
    }
    Ok(DONE)
}

/// The scene `name`: every key with its default and what it means.
fn template(name: &str) -> String {
    let folder = toml::Value::String(format!("out/{name}")).to_string();
    let others: Vec<String> = steering()
        .iter()
        .filter(|method| method.name() != Method::default().name())
        .map(|method| method.name())
        .chain([stable_fluids::NAME])
        .map(|name| format!("\"{name}\""))
        .collect();
    let params = Params::default();
    let table_of = |&method: &Method| table(&section(method), method.words(), params.choices(method), "");
    let tables: String = Method::ALL.iter().map(table_of).chain([fluids()]).collect();
    TEMPLATE
        .replace("METHODS", &others.join(", "))
        .replace("# CHOICES\n", &tables)
        .replace("\"out/NAME\"", &folder)
}

/// The table of Stable Fluids, of which two choices are no numbers and no words.
fn fluids() -> String {
    let section = format!("method.{}", stable_fluids::NAME);
    let first = [
        (
            "control = [\"initial_velocity\"]",
            "or \"forces\", \"templates\", or several: what is searched for",
        ),
        (
            "slots = \"auto\"",
            "or 1 .. steps: states that are kept for a gradient; 0: all that it reads; auto: what fits",
        ),
    ];
    let first: String = first.iter().map(|(key, words)| line(key, words)).collect();
    let words = "Stam's solver at cell centres: fast, smooth, and by few numbers.";
    table(&section, words, &FluidsParams::default(), &first)
}

/// A table of choices, which begins with the lines `first`.
fn table(section: &str, words: &str, choices: &dyn Choices, first: &str) -> String {
    let gap = if section.contains('.') { "" } else { "\n" };
    let mut lines = gap.to_owned() + &line(&format!("[{section}]"), words) + first;
    for (index, choice) in choices.table().iter().enumerate() {
        let Some(value) = choices.get(index) else {
            continue;
        };
        let allowed = match choice.kind {
            Kind::Number(_) | Kind::Flag => String::new(),
            Kind::Count(most) => format!("1 .. {most}: "),
            Kind::Automatic(most) => format!("or 1 .. {most}: "),
            Kind::Word(words) => {
                let others = words.iter().filter(|&&word| Value::Word(word) != value);
                let others: Vec<String> = others.map(|word| format!("\"{word}\"")).collect();
                format!("or {}: ", others.join(", "))
            }
        };
        let key = format!("{} = {}", choice.name, in_toml(value));
        lines += &line(&key, &format!("{allowed}{}", choice.words));
    }
    lines
}

fn line(key: &str, comment: &str) -> String {
    format!("{key:COMMENTS$}# {comment}\n")
}

fn in_toml(value: Value<'_>) -> String {
    match value {
        Value::Number(number) => format!("{number:?}"),
        Value::Count(count) => count.to_string(),
        Value::Automatic => "\"auto\"".into(),
        Value::Flag(flag) => flag.to_string(),
        Value::Word(word) => format!("\"{word}\""),
    }
}

/// `NAME.toml`, or `name` itself if it ends in `.toml`.
fn scene_path(name: &Path) -> Result<PathBuf, Failure> {
    let Some(file) = name.file_name() else {
        return Err(Failure::Input(format!(
            "\"{}\" is not a name for a scene; write a name such as my_scene",
            name.display()
        )));
    };
    if name.extension() == Some(OsStr::new("toml")) {
        return Ok(name.to_path_buf());
    }
    let mut file = file.to_os_string();
    file.push(".toml");
    Ok(name.with_file_name(file))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Document, Scene};

    #[test]
    fn the_template_names_every_choice_with_its_default() {
        let text = template("letter");
        assert!(text.contains("\nhistory = \"auto\"                   # or 1 .. 8: "));
        assert!(text.contains("\nnso = \"stfas\"                      # or \"newton_cg\": "));
        let document = Document::parse(Path::new("letter.toml"), text);
        let table = document
            .as_ref()
            .map_or_else(|_| toml::Table::new(), |document| document.table().clone());
        let params = Params::default();
        for &method in Method::ALL {
            let section = section(method);
            let found = section
                .split('.')
                .try_fold(&table, |table, part| table.get(part)?.as_table());
            let mut found: Vec<&str> = found
                .into_iter()
                .flat_map(|table| table.keys())
                .map(|key| &**key)
                .collect();
            let choices = params.choices(method).table().iter();
            let mut named: Vec<&str> = choices.map(|choice| choice.name).collect();
            found.sort_unstable();
            named.sort_unstable();
            assert_eq!(found, named, "{section}");
        }
        let read = document.and_then(Scene::of).map(|scene| scene.method.params);
        assert!(read.is_ok_and(|read| read == params));
    }
}

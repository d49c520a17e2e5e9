//! A page of tables, curves and pictures, written twice: as HTML that needs nothing else, and as Markdown with its pictures
//! beside it or without them.

use super::chart::Chart;
use super::page::{image, shell};
use super::words::escape;
use crate::output::{OutputError, create_folder, write_bytes};
use std::path::Path;

/// A page as a list of blocks below its title.
pub(crate) struct Document {
    /// Title of the page and of the browser's window.
    pub title: String,
    /// A sentence below the title.
    pub lead: String,
    /// The page's content, from top to bottom.
    pub blocks: Vec<Block>,
    /// Whether the Markdown page has its pictures beside it.
    pub pictures: bool,
}

/// A part of a page.
#[derive(Clone)]
pub(crate) enum Block {
    /// A title within the page.
    Heading(String),
    /// A title below that.
    Part(String),
    /// A paragraph of plain text.
    Text(String),
    /// Text as a machine reads it.
    Code(String),
    /// Rows of names and figures.
    Table(Table),
    /// Charts side by side.
    Charts(Vec<Chart>),
    /// Pictures side by side.
    Pictures(Vec<Shot>),
    /// Many small pictures side by side.
    Strip(Vec<Shot>),
}

/// Rows below a head: names stand left, figures right.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Names of the columns.
    pub head: Vec<&'static str>,
    /// How many columns, from the left, hold names.
    pub names: usize,
    /// How many columns, from the left, are ours; the others quote the paper.
    pub ours: usize,
    /// One text for each column of the head.
    pub rows: Vec<Vec<String>>,
}

/// Some of `count` entries, at most `most`: evenly chosen, the first and the last among them.
pub(crate) fn evenly(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let (shown, last) = (most.min(count), count.saturating_sub(1));
    (0..shown).map(move |index| (index * last).checked_div(shown - 1).unwrap_or(0))
}

/// A picture with a line below it.
#[derive(Clone)]
pub(crate) struct Shot {
    /// The line below it, as plain text.
    pub caption: String,
    /// The bytes of a PNG file.
    pub png: Vec<u8>,
}

impl Document {
    /// Writes `STEM.html`, `STEM.md` and the pictures of the latter, if it has any, below `folder`.
    pub fn write(&self, folder: &Path, stem: &str) -> Result<(), OutputError> {
        create_folder(folder)?;
        write_bytes(&folder.join(format!("{stem}.html")), self.html().as_bytes())?;
        let text = if self.pictures {
            self.with_pictures(folder, stem)?
        } else {
            self.without_pictures(stem)
        };
        write_bytes(
            &folder.join(format!("{stem}.md")),
            format!("# {}\n\n{}\n\n{text}", in_line(&self.title), in_line(&self.lead)).as_bytes(),
        )
    }

    /// The blocks in Markdown, whose pictures are written beside it.
    fn with_pictures(&self, folder: &Path, stem: &str) -> Result<String, OutputError> {
        let mut pictures = Pictures {
            folder,
            stem,
            count: 0,
        };
        self.blocks
            .iter()
            .map(|block| markdown(block, &mut pictures))
            .collect()
    }

    /// The blocks in Markdown that are words and tables.
    fn without_pictures(&self, stem: &str) -> String {
        let blocks = self.blocks.iter().filter_map(words).collect::<String>();
        format!("Pictures and curves are in {stem}.html, which the same command writes.\n\n{blocks}")
    }

    /// The page as HTML.
    pub fn html(&self) -> String {
        let title = escape(&self.title);
        let head = format!(
            "<header><p class=\"brand\">thurible</p><h1>{title}</h1><p class=\"lead\">{}</p></header>\n",
            escape(&self.lead)
        );
        shell(
            &title,
            &(head + &self.blocks.iter().map(html).collect::<String>()),
        )
    }
}

fn html(block: &Block) -> String {
    match block {
        Block::Heading(text) => format!("<h2>{}</h2>\n", escape(text)),
        Block::Part(text) => format!("<h3 class=\"part\">{}</h3>\n", escape(text)),
        Block::Text(text) => format!("<p class=\"text\">{}</p>\n", escape(text)),
        Block::Code(text) => format!("<pre>{}</pre>\n", escape(text)),
        Block::Table(table) => table.html(),
        Block::Charts(charts) if charts.is_empty() => String::new(),
        Block::Charts(charts) => format!(
            "<div class=\"charts\">{}</div>\n",
            charts.iter().map(Chart::to_html).collect::<String>()
        ),
        Block::Pictures(shots) => format!("<div class=\"side\">{}</div>\n", figures(shots)),
        Block::Strip(shots) => format!("<div class=\"side small\">{}</div>\n", figures(shots)),
    }
}

fn figures(shots: &[Shot]) -> String {
    shots
        .iter()
        .map(|shot| {
            format!(
                "<figure>{}<figcaption>{}</figcaption></figure>",
                image(&shot.png, &shot.caption),
                escape(&shot.caption)
            )
        })
        .collect()
}

impl Table {
    /// Names and what belongs to each.
    pub(crate) fn of_facts<'a>(rows: impl IntoIterator<Item = (&'a str, String)>) -> Self {
        let row = |(name, value): (&str, String)| vec![name.to_owned(), value];
        Self {
            head: vec!["", ""],
            names: 1,
            ours: 2,
            rows: rows.into_iter().map(row).collect(),
        }
    }

    fn html(&self) -> String {
        let cells = |row: &mut dyn Iterator<Item = &str>| {
            let cell = |(column, text): (usize, &str)| match column {
                column if column < self.names => format!("<th>{}</th>", escape(text)),
                column if column < self.ours => format!("<td>{}</td>", escape(text)),
                _ => format!("<td class=\"paper\">{}</td>", escape(text)),
            };
            row.enumerate().map(cell).collect::<String>()
        };
        let row = |row: &Vec<String>| {
            let class = if row.first().is_some_and(|name| !name.is_empty()) {
                " class=\"first\""
            } else {
                ""
            };
            format!("<tr{class}>{}</tr>", cells(&mut row.iter().map(String::as_str)))
        };
        format!(
            "<div class=\"scroll\"><table class=\"figures\"><thead><tr>{}</tr></thead><tbody>{}</tbody></table></div>\n",
            cells(&mut self.head.iter().copied()),
            self.rows.iter().map(row).collect::<String>()
        )
    }

    /// The table in Markdown.
    pub fn markdown(&self) -> String {
        self.lines(|cell| in_line(cell).replace('|', "\\|"))
    }

    /// The same as a terminal shows it.
    pub fn plain(&self) -> String {
        self.lines(str::to_owned)
    }

    fn lines(&self, cell: impl Fn(&str) -> String) -> String {
        let line = |cells: &mut dyn Iterator<Item = &str>| {
            format!("| {} |\n", cells.map(&cell).collect::<Vec<_>>().join(" | "))
        };
        let rule = |column: usize| if column < self.names { "---" } else { "---:" };
        let rows: String = self
            .rows
            .iter()
            .map(|row| line(&mut row.iter().map(String::as_str)))
            .collect();
        line(&mut self.head.iter().copied()) + &line(&mut (0..self.head.len()).map(rule)) + &rows
    }
}

/// Where the pictures of the Markdown page go.
struct Pictures<'a> {
    folder: &'a Path,
    stem: &'a str,
    count: usize,
}

impl Pictures<'_> {
    /// Writes a picture and returns the Markdown that shows it.
    fn show(&mut self, caption: &str, kind: &str, bytes: &[u8]) -> Result<String, OutputError> {
        self.count += 1;
        let folder = format!("{}_pictures", self.stem);
        create_folder(&self.folder.join(&folder))?;
        let name = format!("{folder}/{:03}.{kind}", self.count);
        write_bytes(&self.folder.join(&name), bytes)?;
        let width = if kind == "svg" { 480 } else { 160 };
        Ok(format!(
            "<img src=\"{name}\" width=\"{width}\" alt=\"{0}\" title=\"{0}\">",
            escape(caption)
        ))
    }
}

/// More backquotes than stand side by side anywhere in a text, three at least: what ends it as code.
fn fence(text: &str) -> String {
    let longest = text.split(|c| c != '`').map(str::len).max();
    "`".repeat(longest.unwrap_or(0).max(2) + 1)
}

/// Plain text in Markdown, in one line: what would begin a tag or an entity does not.
fn in_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        let next = letters.peek().copied();
        let is_next =
            |other: &str| next.is_some_and(|next| next.is_ascii_alphabetic() || other.contains(next));
        match letter {
            '<' if is_next("/!?") => line.push_str("&lt;"),
            '&' if is_next("#") => line.push_str("&amp;"),
            '\n' | '\r' => line.push(' '),
            letter => line.push(letter),
        }
    }
    line
}

/// A block of words or a table in Markdown. A title below a heading ([`Block::Part`]) is one of pictures.
fn words(block: &Block) -> Option<String> {
    Some(match block {
        Block::Heading(text) => format!("## {}\n\n", in_line(text)),
        Block::Text(text) => format!("{}\n\n", in_line(text)),
        Block::Code(text) => {
            let fence = fence(text);
            format!("{fence}\n{text}\n{fence}\n\n")
        }
        Block::Table(table) => table.markdown() + "\n",
        Block::Part(_) | Block::Charts(_) | Block::Pictures(_) | Block::Strip(_) => return None,
    })
}

fn markdown(block: &Block, pictures: &mut Pictures<'_>) -> Result<String, OutputError> {
    Ok(match block {
        Block::Part(text) => format!("### {}\n\n", in_line(text)),
        Block::Charts(charts) => {
            let shown = charts.iter().map(|chart| {
                Ok(format!(
                    "{}: {}\n\n{}\n\n",
                    chart.title,
                    chart.note,
                    pictures.show(chart.title, "svg", chart.to_svg().as_bytes())?
                ))
            });
            shown.collect::<Result<String, OutputError>>()?
        }
        Block::Pictures(shots) | Block::Strip(shots) => {
            let shown = shots
                .iter()
                .map(|shot| pictures.show(&shot.caption, "png", &shot.png))
                .collect::<Result<Vec<_>, _>>()?;
            let captions: Vec<String> = shots.iter().map(|shot| in_line(&shot.caption)).collect();
            format!("{}\n\n*{}*\n\n", shown.join("\n"), captions.join(", "))
        }
        block => words(block).unwrap_or_default(),
    })
}

//! The documents: every link leads somewhere, every section that code cites is there, and the folder stays light.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

use std::fs;
use std::path::{Path, PathBuf};

/// Pictures of all documents together, at most; `thurible paper` makes the rest.
const MOST_PICTURES: usize = 26;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every file below `folder` that ends with one of `endings`, without what builds and runs leave there.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut list = Vec::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() {
            let made = ["target", "out", "shared"].contains(&name) || path == root().join("book");
            if !name.starts_with('.') && !made {
                list.extend(files(&path, endings));
            }
        } else if endings.iter().any(|ending| name.ends_with(ending)) {
            list.push(path);
        }
    }
    list.sort();
    list
}

/// The lines of a page outside of fenced code.
fn prose(text: &str) -> Vec<&str> {
    let mut fenced = false;
    text.lines()
        .filter(|line| {
            let fence = line.trim_start().starts_with("```");
            fenced ^= fence;
            !fenced && !fence
        })
        .collect()
}

/// A line without what stands between backticks.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect()
}

/// The targets of the links and pictures of a page.
fn links(text: &str) -> Vec<String> {
    let until = |rest: &str, end: char| rest.split(end).next().unwrap().to_owned();
    prose(text)
        .into_iter()
        .map(without_code)
        .flat_map(|line| {
            let markdown: Vec<_> = line.split("](").skip(1).map(|rest| until(rest, ')')).collect();
            let html = line.split("src=\"").skip(1).map(|rest| until(rest, '"'));
            markdown.into_iter().chain(html).collect::<Vec<_>>()
        })
        .collect()
}

/// The anchors that GitHub makes of the headings of a page.
fn anchors(text: &str) -> Vec<String> {
    let heading = |line: &&str| line.starts_with('#') && line.trim_start_matches('#').starts_with(' ');
    prose(text)
        .into_iter()
        .filter(heading)
        .map(|line| {
            let words = line.trim_start_matches('#').trim().to_lowercase();
            let kept = words
                .chars()
                .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            kept.map(|c| if c == ' ' { '-' } else { c }).collect()
        })
        .collect()
}

/// What is wrong with a link of the page `file`.
fn broken(file: &Path, link: &str) -> Option<String> {
    if ["http:", "https:", "mailto:"]
        .iter()
        .any(|scheme| link.starts_with(scheme))
    {
        return None;
    }
    let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
    let target = if path.is_empty() {
        file.to_owned()
    } else {
        file.parent().unwrap().join(path)
    };
    let fault = if !target.exists() {
        "there is no such file"
    } else if !anchor.is_empty()
        && !anchors(&fs::read_to_string(&target).unwrap()).contains(&anchor.to_owned())
    {
        "there is no such heading"
    } else {
        return None;
    };
    Some(format!(
        "{}: {link}: {fault}",
        file.strip_prefix(root()).unwrap().display()
    ))
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let mut count = 0;
    let mut wrong = Vec::new();
    for file in files(root(), &[".md"]) {
        let text = fs::read_to_string(&file).unwrap();
        for link in links(&text) {
            count += 1;
            wrong.extend(broken(&file, &link));
        }
    }
    assert!(count > 50, "only {count} links were found");
    assert!(wrong.is_empty(), "broken links:\n{}", wrong.join("\n"));
}

/// The values of an attribute in a page of HTML.
fn attributes<'a>(html: &'a str, name: &str) -> Vec<&'a str> {
    let begin = format!(" {name}=\"");
    html.split(begin.as_str())
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect()
}

/// What is wrong with a link of the built page `file`.
fn broken_in_book(file: &Path, html: &str, link: &str) -> Option<String> {
    let wrong = |fault: &str| Some(format!("{}: {link}: {fault}", file.display()));
    if let Some((scheme, rest)) = link.split_once("://") {
        let host = rest.split(['/', '#', '?']).next().unwrap();
        let named = host.contains('.') && !host.contains(' ');
        return if scheme.starts_with("http") && named {
            None
        } else {
            wrong("it has not the form of an address")
        };
    }
    if link.starts_with("mailto:") || link.starts_with("data:") || link.starts_with("javascript:") {
        return None;
    }
    let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
    let path = path.split('?').next().unwrap();
    let target = if path.is_empty() {
        file.to_owned()
    } else {
        file.parent().unwrap().join(path)
    };
    if !target.exists() {
        return wrong("there is no such file");
    }
    let other;
    let page = if target == file {
        html
    } else if anchor.is_empty() || target.extension().is_none_or(|end| end != "html") {
        return None;
    } else {
        other = fs::read_to_string(&target).unwrap();
        &other
    };
    if anchor.is_empty() || attributes(page, "id").contains(&anchor) {
        None
    } else {
        wrong("there is no such anchor")
    }
}

#[test]
#[ignore = "it looks at the pages that mdBook made: .ci/run book"]
fn every_link_of_the_built_book_leads_somewhere() {
    let (mut count, mut wrong) = (0, Vec::new());
    for file in built(&root().join("book")) {
        let html = fs::read_to_string(&file).unwrap();
        // The page for addresses that are not there has links from the root of a server.
        if file.ends_with("404.html") {
            continue;
        }
        for link in [attributes(&html, "href"), attributes(&html, "src")].concat() {
            count += 1;
            wrong.extend(broken_in_book(&file, &html, link));
        }
    }
    assert!(count > 2000, "only {count} links were found");
    assert!(wrong.is_empty(), "broken links:\n{}", wrong.join("\n"));
}

fn built(folder: &Path) -> Vec<PathBuf> {
    let mut list = Vec::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            list.extend(built(&path));
        } else if path.extension().is_some_and(|end| end == "html") {
            list.push(path);
        }
    }
    list
}

#[test]
fn links_and_anchors_are_found() {
    let text = "# A page, in short\n[a](b.md#c), `[no](code)` and <img src=\"d.png\">\n```\n[no](either)\n```\n[e](#f)";
    assert_eq!(links(text), ["b.md#c", "d.png", "#f"]);
    assert_eq!(anchors(text), ["a-page-in-short"]);
    let html = "<h2 id=\"b\"><a href=\"#b\"></a></h2>";
    assert_eq!(attributes(html, "href"), ["#b"]);
    assert_eq!(broken_in_book(Path::new("x.html"), html, "https://a.b/c"), None);
    let page = root().join("LICENSE");
    assert_eq!(broken_in_book(&page, html, "#b"), None);
    assert!(broken_in_book(&page, html, "#c").is_some() && broken_in_book(&page, html, "d.html").is_some());
    assert!(broken_in_book(&page, html, "ftp://a.b").is_some());
}

#[test]
fn every_page_has_one_line_in_the_contents_of_the_book() {
    let docs = root().join("docs");
    let contents = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let mut listed: Vec<PathBuf> = links(&contents).iter().map(|link| docs.join(link)).collect();
    listed.push(docs.join("SUMMARY.md"));
    listed.sort();
    assert_eq!(
        listed,
        files(&docs, &[".md"]),
        "docs/SUMMARY.md lists every page of docs/ once"
    );
    // mdBook makes .html of .md in every link, also of pages that are not in the book.
    for page in listed {
        let text = fs::read_to_string(&page).unwrap();
        for link in links(&text)
            .iter()
            .filter(|link| link.starts_with("../") && link.contains(".md"))
        {
            let path = page.parent().unwrap().join(link.split('#').next().unwrap());
            let inside = path
                .canonicalize()
                .unwrap()
                .starts_with(docs.canonicalize().unwrap());
            assert!(inside, "{}: {link} leads out of the book", page.display());
        }
    }
}

/// The files and folders of this repository that a page names between backticks.
fn named(text: &str) -> Vec<&str> {
    let folders = [
        "core/",
        "std_runner/",
        "tests/",
        "benches/",
        "tools/",
        "examples/",
        "docs/",
        ".ci/",
    ];
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
    prose(text)
        .into_iter()
        .flat_map(|line| line.split('`').skip(1).step_by(2))
        .filter(|code| folders.iter().any(|folder| code.starts_with(folder)) && code.chars().all(plain))
        .collect()
}

/// Made by a build, so not in the repository.
const MADE: [&str; 1] = ["examples/web/thurible.wasm"];

#[test]
fn every_file_that_a_page_names_is_there() {
    let mut wrong = Vec::new();
    for file in files(root(), &[".md"]) {
        // The journal speaks of files as they were.
        if file.starts_with(root().join("docs/log")) {
            continue;
        }
        let text = fs::read_to_string(&file).unwrap();
        for path in named(&text) {
            if !root().join(path).exists() && !MADE.contains(&path) {
                wrong.push(format!(
                    "{}: {path}",
                    file.strip_prefix(root()).unwrap().display()
                ));
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "pages name files that are not there:\n{}",
        wrong.join("\n")
    );
}

/// The sections of docs/mathematics.md that a text cites: "mathematics section 5", "mathematics (sections 1 to 4)", across lines.
fn cited(text: &str) -> Vec<usize> {
    let words: Vec<&str> = text
        .split_whitespace()
        .filter(|word| !["//", "///", "//!", "#"].contains(word))
        .collect();
    let number = |word: &str| {
        word.trim_matches(|c: char| !c.is_ascii_digit())
            .parse::<usize>()
            .ok()
    };
    let mut sections = Vec::new();
    for at in words.windows(3) {
        if at[0].contains("mathematics") && at[1].trim_matches('(').starts_with("section") {
            sections.extend(number(at[2]));
        }
    }
    for at in words.windows(5) {
        if at[0].contains("mathematics") && at[1].contains("sections") && at[3] == "to" {
            sections.extend(number(at[4]));
        }
    }
    sections
}

#[test]
fn every_section_of_the_mathematics_that_is_cited_is_there() {
    let page = fs::read_to_string(root().join("docs/mathematics.md")).unwrap();
    let sections: Vec<usize> = page
        .lines()
        .filter_map(|line| line.strip_prefix("## ")?.split('.').next()?.parse().ok())
        .collect();
    assert_eq!(
        sections,
        (1..=sections.len()).collect::<Vec<_>>(),
        "sections are numbered in order"
    );
    let mut count = 0;
    for file in files(root(), &[".rs", ".toml", ".md"]) {
        if file.ends_with("tests/docs.rs") {
            continue;
        }
        for section in cited(&fs::read_to_string(&file).unwrap()) {
            count += 1;
            assert!(
                sections.contains(&section),
                "{} cites section {section} of the mathematics, which is not there",
                file.display()
            );
        }
    }
    assert!(count >= 20, "only {count} citations were found");
}

#[test]
fn citations_are_found() {
    assert_eq!(
        cited("//! x (mathematics section 6): y. of the mathematics\n/// section 5"),
        [6, 5]
    );
    assert_eq!(
        cited("mathematics (sections 1 to 4), a; (docs: mathematics, section 7)"),
        [1, 7, 4]
    );
}

#[test]
fn the_documents_are_light_and_show_no_folder_of_a_machine() {
    let pictures = files(&root().join("docs"), &[".png", ".svg", ".gif", ".jpg"]);
    assert!(
        pictures.len() <= MOST_PICTURES,
        "{} pictures where at most {MOST_PICTURES} may be",
        pictures.len()
    );
    for file in files(root(), &[".md"]) {
        let text = fs::read_to_string(&file).unwrap();
        for folder in ["/tmp/", "/home/", "/root/", "/Users/", "-o /"] {
            assert!(!text.contains(folder), "{} shows {folder}", file.display());
        }
    }
}

//! The figures, by chapter, and their names.

use super::figure::Figure;
use super::{chapter3, chapter4, chapter5};
use crate::quoted::Names;

/// Words for several figures at once, and for those that share an entry.
const GROUPS: &[(&str, &[&str])] = &[
    (
        "all",
        &[
            "fig3.7", "fig3.8", "fig3.10", "fig3.12", "fig3.13", "fig4.3", "fig4.8", "fig4.9", "fig4.10",
            "fig4.11", "fig4.12", "speed", "fig5.1", "fig5.2", "fig5.3", "fig5.4", "fig5.5", "fig5.6",
            "fig5.7", "fig5.8", "fig5.9", "fig5.10",
        ],
    ),
    ("chapter3", &["fig3.7", "fig3.8", "fig3.10", "fig3.12", "fig3.13"]),
    (
        "chapter4",
        &[
            "fig4.3", "fig4.8", "fig4.9", "fig4.10", "fig4.11", "fig4.12", "speed",
        ],
    ),
    (
        "chapter5",
        &[
            "fig5.1", "fig5.2", "fig5.3", "fig5.4", "fig5.5", "fig5.6", "fig5.7", "fig5.8", "fig5.9",
            "fig5.10",
        ],
    ),
    ("fig3.9", &["fig3.8"]),
    ("fig3.11", &["fig3.10"]),
    ("fig4.4", &["fig4.3"]),
    ("fig4.5", &["fig4.3"]),
    ("fig4.6", &["fig4.3"]),
    ("fig4.7", &["fig4.3"]),
];

/// All figures, in the order of the page.
pub(crate) fn figures() -> impl Iterator<Item = &'static Figure> {
    let chapters: [&'static [Figure]; 3] = [&chapter3::FIGURES, &chapter4::FIGURES, &chapter5::FIGURES];
    chapters.into_iter().flatten()
}

/// The names of figures and groups.
pub(crate) fn known() -> Names {
    Names {
        command: "thesis",
        parts: figures().map(|figure| figure.name).collect(),
        groups: GROUPS,
    }
}

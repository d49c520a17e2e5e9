//! The test problems, each a commented scene.

/// A problem.
pub(crate) struct Preset {
    pub name: &'static str,
    /// The scene, as `thurible new NAME --preset X` writes it.
    pub text: &'static str,
}

macro_rules! presets {
    ($($name:literal),+ $(,)?) => {
        &[$(Preset { name: $name, text: include_str!(concat!("presets/", $name, ".toml")) }),+]
    };
}

/// All of them.
const ALL: &[Preset] = presets![
    "rod",
    "stretch",
    "cantilever",
    "buckle",
    "noise",
    "spring",
    "stretch_3d",
    "cantilever_3d",
    "buckle_3d",
    "noise_3d",
    "spring_3d",
];

impl Preset {
    /// What it is: its first line.
    pub fn words(&self) -> &'static str {
        self.text
            .lines()
            .next()
            .unwrap_or_default()
            .trim_start_matches(['#', ' '])
    }
}

/// All of them, in order.
pub(crate) fn presets() -> &'static [Preset] {
    ALL
}

/// Their names.
pub(crate) fn preset_names() -> Vec<&'static str> {
    ALL.iter().map(|preset| preset.name).collect()
}

/// The one with this name.
pub(crate) fn preset(name: &str) -> Option<&'static Preset> {
    ALL.iter().find(|preset| preset.name == name)
}

//! The files of a crate, and which of them names what another one defines.

use crate::tokens::{Segments, Token, paths, tokens};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Where a module stands: `["nso", "local"]`, empty for the root.
pub type Module = Vec<String>;

/// The modules of a crate that are files, and what they say.
pub struct Files {
    modules: BTreeMap<Module, Source>,
}

struct Source {
    path: PathBuf,
    tokens: Vec<Token>,
    /// Names that `pub use` gives to what is defined elsewhere.
    exports: BTreeMap<String, Segments>,
    macros: BTreeSet<String>,
}

impl Files {
    /// All of the crate whose root `lib.rs` lies in `folder`, but for the paths in `others`, which are not of it.
    pub fn read(folder: &Path, others: &[&str]) -> Self {
        let mut found = Vec::new();
        list(folder, folder, others, &mut found);
        let modules = found.into_iter().map(|path| {
            let module = module_of(&path);
            let text = fs::read_to_string(folder.join(&path)).unwrap();
            let tokens = tokens(&text);
            let exports = exports(&tokens);
            let macros = tokens
                .windows(3)
                .filter(|words| words[0] == "macro_rules")
                .map(|words| words[2].clone());
            let macros = macros.collect();
            let source = Source {
                path,
                tokens,
                exports,
                macros,
            };
            (module, source)
        });
        Self {
            modules: modules.collect(),
        }
    }

    /// The modules at the top, in alphabetical order.
    pub fn at_the_top(&self) -> BTreeSet<&str> {
        self.modules
            .keys()
            .filter_map(|module| module.first().map(String::as_str))
            .collect()
    }

    /// The path of a module's file.
    pub fn path(&self, module: &Module) -> String {
        self.modules[module].path.display().to_string()
    }

    /// Which modules each module names, itself left out.
    pub fn imports(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        self.modules
            .keys()
            .map(|module| (module.clone(), self.imports_of(module)))
            .collect()
    }

    fn imports_of(&self, module: &Module) -> BTreeSet<Module> {
        let tokens = &self.modules[module].tokens;
        // The modules within the file that the token stands in, with the depth of their braces.
        let (mut inner, mut depth): (Vec<(String, usize)>, usize) = (Vec::new(), 0);
        let mut imports = BTreeSet::new();
        for (at, token) in tokens.iter().enumerate() {
            match token.as_str() {
                "{" => {
                    depth += 1;
                    // `mod name {`, in a macro `mod $name {`.
                    let opens = (at.saturating_sub(3)..at.saturating_sub(1)).any(|at| tokens[at] == "mod");
                    if opens && tokens[at - 2] != ";" {
                        inner.push((tokens[at - 1].clone(), depth));
                    }
                }
                "}" => {
                    inner.retain(|&(_, opened)| opened < depth);
                    depth = depth.saturating_sub(1);
                }
                _ if at > 0 && tokens[at - 1] == "::" => {}
                _ if tokens.get(at + 1).is_some_and(|next| next == "::") && !self.is_export(tokens, at) => {
                    let within: Module = module
                        .iter()
                        .chain(inner.iter().map(|(name, _)| name))
                        .cloned()
                        .collect();
                    for path in paths(tokens, at).0 {
                        imports.extend(
                            self.absolute(&within, &path)
                                .and_then(|path| self.definer(&path, 8)),
                        );
                    }
                }
                _ => {}
            }
        }
        imports.remove(module);
        imports
    }

    /// Whether the path at `at` is that of a `pub use`: a signpost, not a use.
    fn is_export(&self, tokens: &[Token], at: usize) -> bool {
        at >= 2 && tokens[at - 1] == "use" && matches!(tokens[at - 2].as_str(), "pub" | ")")
    }

    /// `path`, seen from `within`, from the root; `None` if it does not lead into this crate.
    fn absolute(&self, within: &Module, path: &[String]) -> Option<Segments> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => Some(rest.to_vec()),
            "self" => Some([within.clone(), rest.to_vec()].concat()),
            "super" => {
                let (_, above) = within.split_last()?;
                if rest.first().is_some_and(|next| next == "super") {
                    return self.absolute(&above.to_vec(), rest);
                }
                Some([above.to_vec(), rest.to_vec()].concat())
            }
            _ => {
                let child = [within.clone(), vec![first.clone()]].concat();
                self.modules
                    .contains_key(&child)
                    .then(|| [child, rest.to_vec()].concat())
            }
        }
    }

    /// The module whose file defines what the absolute `path` names.
    fn definer(&self, path: &[String], depth: usize) -> Option<Module> {
        let module: Module = (0..=path.len())
            .rev()
            .map(|length| path[..length].to_vec())
            .find(|module| self.modules.contains_key(module))?;
        let Some(name) = path.get(module.len()) else {
            return Some(module);
        };
        if let Some(export) = self.modules[&module].exports.get(name)
            && depth > 0
            && let Some(export) = self.absolute(&module, export)
        {
            return self.definer(&export, depth - 1);
        }
        // Macros that are exported stand at the root, wherever they are written.
        let of_macro = || {
            self.modules
                .iter()
                .find(|(_, source)| source.macros.contains(name))
        };
        match of_macro() {
            Some((definer, _)) if module.is_empty() => Some(definer.clone()),
            _ => Some(module),
        }
    }
}

/// Sets of modules that reach each other, each in alphabetical order.
pub fn circles(imports: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<BTreeSet<Module>> {
    let reached: BTreeMap<&Module, BTreeSet<&Module>> = imports
        .keys()
        .map(|start| {
            let (mut seen, mut waiting) = (BTreeSet::new(), vec![start]);
            while let Some(module) = waiting.pop() {
                for next in imports.get(module).into_iter().flatten() {
                    if seen.insert(next) {
                        waiting.push(next);
                    }
                }
            }
            (start, seen)
        })
        .collect();
    let circle = |module: &Module| -> BTreeSet<Module> {
        reached[module]
            .iter()
            .filter(|other| reached.get(**other).is_some_and(|back| back.contains(module)))
            .map(|other| (*other).clone())
            .collect()
    };
    imports
        .keys()
        .map(circle)
        .filter(|circle| circle.len() > 1)
        .collect()
}

/// `nso/local/mod.rs` is the module `nso::local`.
fn module_of(path: &Path) -> Module {
    let mut module: Module = path
        .with_extension("")
        .iter()
        .map(|part| part.to_str().unwrap().to_owned())
        .collect();
    if module.last().is_some_and(|last| last == "mod" || last == "lib") {
        module.pop();
    }
    module
}

/// Adds every source file below `at`, as paths from `folder`.
fn list(folder: &Path, at: &Path, others: &[&str], found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(at).unwrap().map(|entry| entry.unwrap().path()) {
        let path = entry.strip_prefix(folder).unwrap();
        if others.iter().any(|other| path == Path::new(other)) {
            continue;
        }
        if entry.is_dir() {
            list(folder, &entry, others, found);
        } else if entry.extension().is_some_and(|end| end == "rs") {
            found.push(path.to_owned());
        }
    }
}

/// What `pub use` and `pub(..) use` name, by the last word or that after `as`.
fn exports(tokens: &[Token]) -> BTreeMap<String, Segments> {
    let mut found = BTreeMap::new();
    for at in 2..tokens.len() {
        if tokens[at - 1] == "use" && matches!(tokens[at - 2].as_str(), "pub" | ")") {
            for path in paths(tokens, at).0 {
                if let Some(name) = path.last() {
                    found.insert(name.clone(), path.clone());
                }
            }
        }
    }
    found
}

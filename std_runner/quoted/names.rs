//! Names on the command line: parts of a page, and words for several of them.

use crate::exit::Failure;

/// The names that a command knows.
pub(crate) struct Names {
    /// The command, as in `thurible paper`.
    pub command: &'static str,
    /// The parts of its page, in their order.
    pub parts: Vec<&'static str>,
    /// Words for several parts; without any name it is the first.
    pub groups: &'static [(&'static str, &'static [&'static str])],
}

impl Names {
    /// The parts that `asked` names, in the order of the page.
    pub fn chosen(&self, asked: &[String]) -> Result<Vec<&'static str>, Failure> {
        let mut wanted: Vec<&str> = Vec::new();
        for name in asked {
            match self.groups.iter().find(|(group, _)| group == name) {
                Some((_, members)) => wanted.extend_from_slice(members),
                None if self.parts.iter().any(|part| part == name) => wanted.push(name),
                None => return Err(self.unknown(name)),
            }
        }
        if asked.is_empty() {
            wanted.extend(self.groups.first().into_iter().flat_map(|(_, members)| *members));
        }
        Ok(self
            .parts
            .iter()
            .copied()
            .filter(|part| wanted.contains(part))
            .collect())
    }

    /// All of them: parts, then groups.
    pub fn words(&self) -> Vec<&'static str> {
        let groups = self.groups.iter().map(|(group, _)| *group);
        self.parts.iter().copied().chain(groups).collect()
    }

    fn unknown(&self, name: &str) -> Failure {
        let command = self.command;
        Failure::Input(format!(
            "the {command}'s list has no \"{name}\", only {}; name one of these, `thurible {command} --list` says what they are",
            self.words().join(", ")
        ))
    }

    /// The groups with their members, a line each, for `--list`.
    pub fn lines(&self) -> Vec<String> {
        let all = self.parts.len();
        let line = |(group, members): &(&str, &[&str])| format!("{group:<10}{}", members.join(" "));
        let mut lines: Vec<String> = self
            .groups
            .iter()
            .filter(|(_, members)| members.len() < all)
            .map(line)
            .collect();
        let first = self.groups.first().map_or("", |(group, _)| group);
        lines.push(format!("{:<10}all of them; without a name: {first}", "all"));
        lines
    }
}

//! The templates that a force is made of.

use super::{Lists, Script};
use crate::problem::Template;

impl<'a> Lists<'a> {
    /// The templates, in scaled numbers.
    pub fn templates(&self) -> impl ExactSizeIterator<Item = Template> + Clone + use<'a> {
        self.templates.as_chunks().0.iter().map(Template::unpack)
    }
}

impl<'a, T> Script<'a, T> {
    /// The templates, in scaled numbers; none after a release.
    pub fn templates(&self) -> impl ExactSizeIterator<Item = Template> + Clone + use<'a, T> {
        self.lists.templates()
    }
}

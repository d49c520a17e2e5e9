//! What a user should hear of a shape that was drawn.

/// A sentence about how a file was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The sentence.
    pub text: String,
    /// Whether what was read is probably not what was meant.
    pub warning: bool,
}

impl Note {
    /// A sentence that only informs.
    pub(crate) fn remark(text: String) -> Self {
        Self { text, warning: false }
    }

    /// A sentence about what is probably not meant.
    pub(super) fn warning(text: String) -> Self {
        Self { text, warning: true }
    }

    /// The same sentence, said of the table `key` of a scene.
    #[must_use]
    pub fn of(mut self, key: &str) -> Self {
        self.text = format!("in {key}: {}", self.text);
        self
    }
}

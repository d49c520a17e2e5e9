//! Threads with ranks or a device beside them.

use super::{Device, Exec, Ranks};

/// The threads of another [`Exec`], with what a solve has beside them.
#[derive(Clone, Copy)]
pub struct Together<'a> {
    exec: &'a dyn Exec,
    ranks: &'a dyn Ranks,
    device: Option<&'a dyn Device>,
}

impl<'a> Together<'a> {
    /// The threads of `exec` in the rank that `ranks` see.
    #[must_use]
    pub fn new(exec: &'a dyn Exec, ranks: &'a dyn Ranks) -> Self {
        Self {
            exec,
            ranks,
            device: exec.device(),
        }
    }

    /// The threads of `exec` beside `device`.
    #[must_use]
    pub fn beside(exec: &'a dyn Exec, device: &'a dyn Device) -> Self {
        Self {
            exec,
            ranks: exec.ranks(),
            device: Some(device),
        }
    }
}

impl Exec for Together<'_> {
    fn threads(&self) -> usize {
        self.exec.threads()
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        self.exec.run(tasks, task);
    }

    fn ranks(&self) -> &dyn Ranks {
        self.ranks
    }

    fn device(&self) -> Option<&dyn Device> {
        self.device
    }
}

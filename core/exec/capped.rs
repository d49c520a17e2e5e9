use super::{Device, Exec, Ranks};

/// An [`Exec`] that offers fewer threads than another, on which it runs: for work whose scratch was planned for fewer.
pub struct Capped<'a> {
    exec: &'a dyn Exec,
    threads: usize,
}

impl<'a> Capped<'a> {
    /// At most `threads` of the threads of `exec`, and at least one.
    pub fn new(exec: &'a dyn Exec, threads: usize) -> Self {
        Self {
            exec,
            threads: exec.threads().min(threads).max(1),
        }
    }
}

impl Exec for Capped<'_> {
    fn threads(&self) -> usize {
        self.threads
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        self.exec.run(tasks, task);
    }

    fn ranks(&self) -> &dyn Ranks {
        self.exec.ranks()
    }

    fn device(&self) -> Option<&dyn Device> {
        self.exec.device()
    }
}

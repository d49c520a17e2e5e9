use super::Exec;
use super::chunks::Chunks;
use super::schedule::schedule;
use core::marker::PhantomData;

/// Some columns of consecutive rows of a field, which one task has for itself.
#[derive(Debug)]
pub struct Panel<'a, T> {
    /// The first value of the first row.
    start: *mut T,
    rows: usize,
    /// Values from a row to the next.
    width: usize,
    first: usize,
    count: usize,
    field: PhantomData<&'a mut [T]>,
}

impl<'a, T> Panel<'a, T> {
    /// All columns of `field`, of rows of `width` values, at least one.
    #[must_use]
    pub fn whole(field: &'a mut [T], width: usize) -> Self {
        let width = width.max(1);
        Self {
            start: field.as_mut_ptr(),
            rows: field.len() / width,
            width,
            first: 0,
            count: width,
            field: PhantomData,
        }
    }

    /// Rows.
    #[inline(always)]
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Which column of its rows is the first.
    #[inline(always)]
    #[must_use]
    pub fn first(&self) -> usize {
        self.first
    }

    /// Columns.
    #[inline(always)]
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Its columns of a row.
    ///
    /// # Panics
    /// When there is no such row.
    #[inline(always)]
    #[must_use]
    pub fn row(&self, row: usize) -> &[T] {
        assert!(row < self.rows);
        // SAFETY: the row lies in the field, and nobody else has these columns of it.
        unsafe { core::slice::from_raw_parts(self.start.add(row * self.width), self.count) }
    }

    /// Its columns of a row, to be written.
    ///
    /// # Panics
    /// When there is no such row.
    #[inline(always)]
    #[must_use]
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        let [row, _] = self.pair(row, self.rows);
        row
    }

    /// The same of two rows at once; the second is empty where there is no such row.
    ///
    /// # Panics
    /// When there is no first row, or the second does not come after it.
    #[inline(always)]
    #[must_use]
    pub fn pair(&mut self, low: usize, high: usize) -> [&mut [T]; 2] {
        assert!(low < self.rows && low < high);
        let count = |row: usize| if row < self.rows { self.count } else { 0 };
        // SAFETY: both rows lie in the field or are empty, they are different ones, and nobody else has these columns of them.
        [low, high].map(|row| unsafe {
            let start = self.start.add(row.min(self.rows - 1) * self.width);
            core::slice::from_raw_parts_mut(start, count(row))
        })
    }
}

/// Cuts a field of slabs of `rows` rows, of `width` values each, into panels of `most` columns or what is left of them, and calls `task` for
/// each with the thread's chunk of the scratch. What is left of a field beyond whole slabs is in none.
pub fn for_panels<T: Send>(
    exec: &dyn Exec,
    field: &mut [T],
    [rows, width, most]: [usize; 3],
    scratch: &mut [T],
    task: impl Fn(Panel<'_, T>, &mut [T]) + Sync,
) {
    let slab = rows * width;
    if slab == 0 || most == 0 {
        return;
    }
    let slabs = field.len() / slab;
    let panels = width.div_ceil(most);
    let field = Chunks::new(field.split_at_mut(slabs * slab).0, slabs);
    let scratch = Chunks::new(scratch, exec.threads().max(1));
    schedule(
        exec,
        slabs * panels,
        rows * most.min(width),
        move |worker, turn| {
            for index in turn {
                let (slab, first) = (index / panels, index % panels * most);
                // SAFETY: `first < width`, so the panel begins inside its slab. `schedule` gives every index to one worker once, panels share no
                // column of a slab, and every worker index runs once.
                let (panel, scratch) = unsafe {
                    let panel = Panel {
                        start: field.start(slab).add(first),
                        rows,
                        width,
                        first,
                        count: most.min(width - first),
                        field: PhantomData,
                    };
                    (panel, scratch.get(worker..worker + 1))
                };
                task(panel, scratch);
            }
        },
    );
}

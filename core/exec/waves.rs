use super::Exec;
use super::chunks::Chunks;

/// Elements to write below which a second thread costs more than it brings.
const MIN_PARALLEL: usize = 1 << 12;

/// Cuts a field into chunks of `size` elements and calls `task` for the chunks `first`, `first + 2`, .., `count` of them, in any order: with
/// the chunk's number, the chunk, and those before and behind it, empty where there is none. What is left of a field beyond whole chunks is
/// in none.
///
/// # Panics
/// Where there are not so many chunks.
pub fn for_every_other<T: Send + Sync>(
    exec: &dyn Exec,
    field: &mut [T],
    size: usize,
    first: usize,
    count: usize,
    task: impl Fn(usize, &mut [T], [&[T]; 2]) + Sync,
) {
    let chunks = field.len().checked_div(size).unwrap_or(0);
    assert!(count == 0 || first.saturating_add(2 * count - 2) < chunks);
    let (field, _) = field.split_at_mut(chunks * size);
    let field = Chunks::new(field, chunks);
    let field = &field;
    let each = move |turn: usize| {
        let chunk = first + 2 * turn;
        // SAFETY: every chunk that is written is as far from the first as an even number, and each turn is another one, so no two are written
        // together and those beside, an odd number away, by nobody. All of them lie in the field.
        let (own, before, behind) = unsafe {
            (
                field.get(chunk..chunk + 1),
                chunk.checked_sub(1).map_or(&[][..], |before| field.peek(before)),
                if chunk + 1 < chunks {
                    field.peek(chunk + 1)
                } else {
                    &[]
                },
            )
        };
        task(chunk, own, [before, behind]);
    };
    let workers = exec.threads().min(count);
    if workers <= 1 || size * count < MIN_PARALLEL {
        return (0..count).for_each(each);
    }
    exec.run(workers, &move |worker| {
        (count * worker / workers..count * (worker + 1) / workers).for_each(&each);
    });
}

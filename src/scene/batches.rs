//! Long lists worked on by all threads, with the results taken in order.
//!
//! Comes in: a list, the work on a part of it, and what takes a part's result. Goes out: nothing more; the results arrive in the
//! order of the list, whatever the threads. Only a few parts are held at a time, so memory stays bounded.

use rayon::prelude::*;

/// Items of a part: enough work to be worth a task.
const PART: usize = 1 << 14;
/// Parts in work together.
const TOGETHER: usize = 8;

/// Calls `work` on parts of `items` (with the number of the part's first item), in parallel, and `take` on every result in order,
/// until one fails.
pub(super) fn in_batches<T: Sync, R: Send, E>(
    items: &[T],
    work: impl Fn(usize, &[T]) -> R + Sync,
    mut take: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E> {
    for (batch, items) in items.chunks(PART * TOGETHER).enumerate() {
        let first = batch * PART * TOGETHER;
        let results: Vec<R> =
            items.par_chunks(PART).enumerate().map(|(part, items)| work(first + part * PART, items)).collect();
        results.into_iter().try_for_each(&mut take)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_and_stop_at_the_first_failure() {
        let items: Vec<usize> = (0..PART * TOGETHER + 3 * PART + 5).collect();
        let mut seen = Vec::new();
        let firsts = |first: usize, part: &[usize]| {
            assert_eq!(part[0], first);
            part.to_vec()
        };
        let all: Result<(), ()> = in_batches(&items, firsts, |part| {
            seen.extend(part);
            Ok(())
        });
        assert!(all.is_ok() && seen == items);
        let mut parts = 0;
        let failed = in_batches(&items, firsts, |part| {
            parts += 1;
            if part[0] >= 2 * PART { Err(part[0]) } else { Ok(()) }
        });
        assert_eq!((failed, parts), (Err(2 * PART), 3));
    }
}

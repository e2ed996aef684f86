//! Work on the threads of the caller's pool.
//!
//! All of it runs through one loop that is compiled once: each chain of parallel iterators would be
//! compiled anew, at some 2,000 lines of code. Results are in order, and do not depend on the
//! number of threads.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// Calls `work` once with each index below `count`.
pub(crate) fn each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}

/// Calls `work` with the index and the items of each chunk of `size` items; the last may be
/// shorter. 0 is 1.
pub(crate) fn for_each_chunk<T: Send>(
    items: &mut [T],
    size: usize,
    work: &(dyn Fn(usize, &mut [T]) + Sync),
) {
    // No lock is ever waited for: each index comes once.
    let chunks: Vec<Mutex<&mut [T]>> = items.chunks_mut(size.max(1)).map(Mutex::new).collect();
    each(chunks.len(), &|i| work(i, &mut chunks[i].lock().unwrap_or_else(PoisonError::into_inner)));
}

/// Results of `work` for each index below `count`. An index is worth a lock: a task, not a pixel.
pub(crate) fn map<R: Send>(count: usize, work: &(dyn Fn(usize) -> R + Sync)) -> Vec<R> {
    let mut results = Vec::new();
    results.resize_with(count, || None);
    for_each_chunk(&mut results, 1, &|i, result| result[0] = Some(work(i)));
    results.into_iter().flatten().collect()
}

/// Results of `work` for `count` items, `size` at a time.
pub(crate) fn tasks<R: Send>(
    count: usize,
    size: usize,
    work: &(dyn Fn(Range<usize>) -> R + Sync),
) -> Vec<R> {
    map(count.div_ceil(size), &|i| work(i * size..(i * size + size).min(count)))
}

/// Calls `work` on so many threads; 0 is those of the pool it is called from.
pub(crate) fn install(threads: usize, work: &mut (dyn FnMut() + Send)) {
    if threads == 0 || threads == rayon::current_num_threads() {
        return work();
    }
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        // The system refuses threads: results are the same without.
        Err(_) => work(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::in_pool;

    #[test]
    fn every_index_comes_once_and_results_are_in_order() {
        for threads in [1, 3] {
            let squares = in_pool(threads, || map(1000, &|i| i * i));
            assert!(squares.iter().enumerate().all(|(i, n)| *n == i * i) && squares.len() == 1000);
            let mut counts = [0; 1001];
            in_pool(threads, || {
                for_each_chunk(&mut counts, 10, &|i, chunk| {
                    chunk.iter_mut().for_each(|n| *n += i);
                });
            });
            assert!(counts.iter().enumerate().all(|(i, n)| *n == i / 10));
        }
        assert_eq!(tasks(110, 64, &|range| range), [0..64, 64..110]);
        assert!(map(0, &|i| i).is_empty());
    }
}

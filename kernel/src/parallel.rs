//! The same work on many things: by threads with the feature `parallel`, one after the other without it. Results are
//! in order, so that they are the same whatever the number of threads.

/// `work` on every index below `count`.
pub fn map<R: Send>(count: usize, work: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().map(work).collect()
    }
    #[cfg(not(feature = "parallel"))]
    (0..count).map(work).collect()
}

/// `work` on every item, with its index and with room that `room` makes once for a run of items. What is left in the
/// room must not matter.
pub fn map_mut<T: Send, S, R: Send>(
    items: &mut [T],
    room: impl Fn() -> S + Sync + Send,
    work: impl Fn(&mut S, usize, &mut T) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        let items = items.par_iter_mut().enumerate();
        items.map_init(room, |room, (k, item)| work(room, k, item)).collect()
    }
    #[cfg(not(feature = "parallel"))]
    {
        let mut room = room();
        items.iter_mut().enumerate().map(|(k, item)| work(&mut room, k, item)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order() {
        let mut items: Vec<usize> = map(1000, |k| k * k);
        let before = map_mut(&mut items, || (), |(), k, item| std::mem::replace(item, k));
        assert_eq!(before[999], 999 * 999);
        assert_eq!(items, (0..1000).collect::<Vec<_>>());
    }
}

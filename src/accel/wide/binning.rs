//! What lies in slices across a set, and on both sides of each plane between two of them.

use super::build::Job;
use super::item::Item;
use super::split::folded;

/// What is summed up of the items in a slice.
pub(super) trait Bin: Copy + Send {
    const EMPTY: Self;

    fn add(&mut self, other: &Self);
}

/// The bins of `N` slices, by axis.
pub(super) type Bins<B, const N: usize> = [[B; N]; 3];

/// The sums of what `fill` puts into the bins; not of all items when cancelled.
pub(super) fn filled<B: Bin, const N: usize>(
    job: &Job,
    items: &[Item],
    fill: impl Fn(&[Item]) -> Bins<B, N> + Send + Sync,
) -> Bins<B, N> {
    folded(job.cancel, items, fill, |all, other| {
        for (all, other) in all.iter_mut().flatten().zip(other.iter().flatten()) {
            all.add(other);
        }
    })
}

/// What lies before and behind each plane between two slices along an axis, in order.
pub(super) fn sides<B: Bin, const N: usize>(bins: &[B; N]) -> impl Iterator<Item = (B, B)> {
    let mut from = [B::EMPTY; N];
    let mut behind = B::EMPTY;
    for (from, bin) in from.iter_mut().zip(bins).rev() {
        behind.add(bin);
        *from = behind;
    }
    let mut before = B::EMPTY;
    let planes = bins.iter().zip(from.into_iter().skip(1));
    planes.map(move |(bin, behind)| {
        before.add(bin);
        (before, behind)
    })
}

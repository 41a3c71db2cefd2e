//! Trajectories of Morris (1991): from a random corner of the grid one step in each dimension, in random
//! order.

use crate::study::stream::{Purpose, Stream};

/// Levels (0 … `levels` − 1) of every dimension at step `within` of trajectory `trajectory`. A step is half the
/// levels, δ = p/(2(p−1)) of the range, up or down, so that every level occurs equally often.
pub(super) fn point(
    seed: u64,
    trajectory: u64,
    within: usize,
    dimensions: usize,
    levels: usize,
) -> Vec<usize> {
    let mut stream = Stream::new(seed, Purpose::Trajectories, trajectory);
    let half = levels / 2;
    // (where it starts, where it ends)
    let moves: Vec<(usize, usize)> = (0..dimensions)
        .map(|_| {
            let low = stream.below(half);
            if stream.below(2) == 0 { (low, low + half) } else { (low + half, low) }
        })
        .collect();
    let mut order: Vec<usize> = (0..dimensions).collect();
    stream.shuffle(&mut order);
    let mut place: Vec<usize> = moves.iter().map(|(start, _)| *start).collect();
    for dimension in &order[..within.min(dimensions)] {
        place[*dimension] = moves[*dimension].1;
    }
    place
}

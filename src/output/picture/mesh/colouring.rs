//! A colour for each region, such that regions that touch can be told apart.

/// The index of each region's colour among `available` colours. `neighbours` are pairs of regions
/// that touch.
///
/// Regions take the colours in turn while there are enough. Else each region takes one that no
/// neighbour has, in smallest-last order (Matula and Beck 1983), which needs no more than six colours
/// for a planar map; where a region has more neighbours than there are colours, the one that the fewest
/// of them have.
pub(super) fn colour_indices(
    count: usize,
    neighbours: &[[usize; 2]],
    available: usize,
) -> Vec<usize> {
    if count <= available {
        return (0..count).collect();
    }
    let mut beside = vec![Vec::new(); count];
    for &[a, b] in neighbours {
        beside[a].push(b);
        beside[b].push(a);
    }
    let mut colours = vec![None; count];
    let mut uses = vec![0; available];
    for region in smallest_last(&beside) {
        let clashes = |colour: usize| {
            let others = beside[region]
                .iter()
                .filter(|&&b| colours[b] == Some(colour));
            others.count()
        };
        let best = (0..available).min_by_key(|&colour| (clashes(colour), uses[colour]));
        let best = best.expect("a palette has colours");
        uses[best] += 1;
        colours[region] = Some(best);
    }
    colours.into_iter().flatten().collect()
}

/// The regions such that each has few neighbours before it: the last has the fewest of all, the one
/// before it the fewest of the rest, and so on.
fn smallest_last(beside: &[Vec<usize>]) -> Vec<usize> {
    let mut left: Vec<usize> = beside.iter().map(Vec::len).collect();
    let mut remaining: Vec<usize> = (0..beside.len()).collect();
    let mut order = Vec::with_capacity(beside.len());
    while let Some(place) = (0..remaining.len()).min_by_key(|&k| left[remaining[k]]) {
        let region = remaining.remove(place);
        beside[region]
            .iter()
            .for_each(|&other| left[other] = left[other].saturating_sub(1));
        order.push(region);
    }
    order.reverse();
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hexagonal map of 10 × 10 regions: each touches six others.
    fn honeycomb() -> Vec<[usize; 2]> {
        let at = |[i, j]: [usize; 2]| 10 * j + i;
        let mut pairs = Vec::new();
        for j in 0..10 {
            for i in 0..10 {
                for next in [[i + 1, j], [i, j + 1], [i + 1, j + 1]] {
                    if next[0] < 10 && next[1] < 10 {
                        pairs.push([at([i, j]), at(next)]);
                    }
                }
            }
        }
        pairs
    }

    #[test]
    fn neighbours_differ_with_six_colours() {
        let pairs = honeycomb();
        let colours = colour_indices(100, &pairs, 6);
        assert_eq!(colours.len(), 100);
        assert!(pairs.iter().all(|&[a, b]| colours[a] != colours[b]));
    }

    #[test]
    fn few_regions_take_the_colours_in_turn() {
        assert_eq!(colour_indices(3, &[[0, 2]], 6), [0, 1, 2]);
    }

    /// Inclusions in a matrix, which touches all of them.
    #[test]
    fn no_inclusion_has_the_colour_of_the_matrix() {
        let pairs: Vec<[usize; 2]> = (1..100).map(|k| [0, k]).collect();
        let colours = colour_indices(100, &pairs, 6);
        assert_eq!(colours.iter().filter(|&&c| c == colours[0]).count(), 1);
    }
}

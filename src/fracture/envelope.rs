//! The outline of a path whose load turns back and forth. A load that only grows would jump from one point of it
//! to the next.

/// Number of the largest load factor of a path: there a load that only grows would break the body.
pub fn peak(load_factors: &[f64]) -> Option<usize> {
    let numbers = 0..load_factors.len();
    numbers.max_by(|&a, &b| load_factors[a].total_cmp(&load_factors[b]))
}

/// Numbers of the points on the outline: up to the peak those above all that come before them, from there on
/// those above all that come after them.
pub fn envelope(load_factors: &[f64]) -> Vec<usize> {
    let Some(peak) = peak(load_factors) else {
        return Vec::new();
    };
    let mut envelope = rising(load_factors, 0..=peak);
    let mut falling = rising(load_factors, (peak + 1..load_factors.len()).rev());
    falling.reverse();
    envelope.append(&mut falling);
    envelope
}

/// Those of some points that are above all before them.
fn rising(load_factors: &[f64], points: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut highest = f64::NEG_INFINITY;
    let is_higher = |&k: &usize| {
        let is_higher = load_factors[k] > highest;
        highest = highest.max(load_factors[k]);
        is_higher
    };
    points.filter(is_higher).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn teeth_are_left_out_on_both_sides_of_the_peak() {
        let path = [1.0, 0.5, 2.0, 1.5, 3.0, 2.5, 2.8, 1.0, 1.2, 0.1];
        assert_eq!(peak(&path), Some(4));
        assert_eq!(envelope(&path), [0, 2, 4, 6, 8, 9]);
        assert_eq!(envelope(&[]), [0; 0]);
    }
}

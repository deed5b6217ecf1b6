//! The nodes of a zone: those where bonds will break next, around the tips and ahead of them.
//!
//! A tip is a cluster of bonds close to their limits. Its crack goes on away from the bonds broken behind it, so that
//! the zone of a tip holds the strained nodes, the families of bonds close to their limits, and a strip along that
//! direction. Where nothing has broken nearby, it is a disc.

use super::event::Load;
use super::policy::{
    APART, BACK, FAMILY, HALF_WIDTH, LARGEST_ZONE, NO_DIRECTION, STRAINED, TIP, WAKE,
};
use super::problem::Problem;
use super::solutions::Solutions;
use rayon::prelude::*;

/// A tip of a crack.
struct Tip {
    /// Middle of its bonds [m].
    place: [f64; 2],
    /// Unit vector along which its crack goes on; `None` where nothing has broken nearby.
    direction: Option<[f64; 2]>,
}

/// `count` nodes, or up to [`LARGEST_ZONE`] times as many, ascending. `load` breaks the next bond.
pub fn zone_nodes(
    problem: &Problem,
    integrity: &[f64],
    solutions: &Solutions,
    load: Load,
    count: usize,
) -> Vec<usize> {
    let model = problem.model;
    let strained: Vec<(usize, f64)> = (model.interactions.axial())
        .into_par_iter()
        .filter(|&s| integrity[s] > 0.0)
        .map(|s| {
            let stretch = load.combine(solutions.rough_stretches(problem, s));
            (s, problem.laws.limits(s, integrity[s]).utilisation(stretch))
        })
        .filter(|&(_, utilisation)| utilisation > STRAINED)
        .collect();
    let length = |&(s, _): &(usize, f64)| model.interactions.length(s, &model.positions);
    let horizon = strained.iter().map(length).fold(0.0, f64::max);
    let tips = tips(problem, integrity, &strained, horizon);
    // Nodes are taken by their distance along the strips; a disc fills as fast. Nodes beside a strip come after
    // its end.
    let beside = 1e6 * horizon;
    let mut key = vec![f64::INFINITY; model.node_count()];
    let half_width = HALF_WIDTH * horizon;
    for (key, x) in key.iter_mut().zip(&model.positions) {
        for tip in &tips {
            let r = [x[0] - tip.place[0], x[1] - tip.place[1]];
            let own = match tip.direction {
                Some([a, b]) => {
                    let (along, aside) = (a * r[0] + b * r[1], a * r[1] - b * r[0]);
                    let inside = aside.abs() < half_width && along > -BACK * horizon;
                    if inside {
                        along.max(0.0)
                    } else {
                        beside + r[0].hypot(r[1])
                    }
                }
                None => std::f64::consts::PI * (r[0] * r[0] + r[1] * r[1]) / (2.0 * half_width),
            };
            *key = key.min(own);
        }
    }
    let is_close = |&&(_, utilisation): &&(usize, f64)| utilisation > TIP;
    let close = strained.iter().filter(is_close);
    let close: Vec<[f64; 2]> = close.map(|&(s, _)| middle(problem, s)).collect();
    let is_family = |&x: &[f64; 2]| close.iter().any(|&at| distance(at, x) < FAMILY * horizon);
    let family: Vec<bool> = model.positions.par_iter().map(is_family).collect();
    for &(interaction, utilisation) in &strained {
        for &node in model.interactions.nodes(interaction) {
            key[node as usize] = key[node as usize].min(-utilisation);
        }
    }
    // Before all else, since without them a zone sees no event; half as many again go ahead of the tips.
    let mut needed = 0;
    for (key, _) in key.iter_mut().zip(family).filter(|(_, is_in)| *is_in) {
        *key = -2.0;
        needed += 1;
    }
    let count = count.max((needed + needed / 2).min(LARGEST_ZONE * count));
    let mut nodes: Vec<usize> = (0..key.len()).filter(|&k| key[k] < f64::INFINITY).collect();
    let by_key = |a: &usize, b: &usize| key[*a].total_cmp(&key[*b]).then(a.cmp(b));
    if count < nodes.len() {
        nodes.select_nth_unstable_by(count, by_key);
        nodes.truncate(count);
    }
    nodes.sort_unstable();
    nodes
}

fn middle(problem: &Problem, interaction: usize) -> [f64; 2] {
    let model = problem.model;
    let [a, b] = model.interactions.segment(interaction, &model.positions);
    [0, 1].map(|k| 0.5 * (a[k] + b[k]))
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn mean(places: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|k| places.iter().map(|p| p[k]).sum::<f64>() / places.len() as f64)
}

fn tips(problem: &Problem, integrity: &[f64], strained: &[(usize, f64)], horizon: f64) -> Vec<Tip> {
    let mut by_strain: Vec<(usize, f64)> = strained.to_vec();
    by_strain.retain(|&(_, utilisation)| utilisation > TIP);
    by_strain.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut clusters: Vec<Vec<[f64; 2]>> = Vec::new();
    for (interaction, _) in by_strain {
        let place = middle(problem, interaction);
        let is_near = |c: &&mut Vec<[f64; 2]>| distance(c[0], place) < APART * horizon;
        match clusters.iter_mut().find(is_near) {
            Some(cluster) => cluster.push(place),
            None => clusters.push(vec![place]),
        }
    }
    let places: Vec<[f64; 2]> = clusters.iter().map(|c| mean(c)).collect();
    let mut wakes = vec![Vec::new(); places.len()];
    for interaction in (problem.model.interactions.axial()).filter(|&s| integrity[s] == 0.0) {
        let broken = middle(problem, interaction);
        for (wake, &place) in wakes.iter_mut().zip(&places) {
            if distance(broken, place) < WAKE * horizon {
                wake.push(broken);
            }
        }
    }
    let all = places.into_iter().zip(wakes);
    all.map(|(place, wake)| {
        let from = mean(&wake);
        let length = distance(place, from);
        // False where nothing has broken nearby.
        let has_direction = length > NO_DIRECTION * horizon;
        let direction = has_direction.then(|| [0, 1].map(|k| (place[k] - from[k]) / length));
        Tip { place, direction }
    })
    .collect()
}

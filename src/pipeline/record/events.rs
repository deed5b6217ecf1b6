//! The events of a fracture run that its results name, found in its history.

use super::history::HistoryLine;
use crate::fracture::envelope;

/// Whether only forces load the body: no boundary moves, and the reactions of supports may be rounding.
pub(crate) fn is_driven_by_forces(history: &[HistoryLine]) -> bool {
    history.iter().all(|line| line.grip_displacement == 0.0)
}

pub(crate) fn first_break(history: &[HistoryLine]) -> Option<&HistoryLine> {
    history.iter().find(|line| line.bonds_broken > 0)
}

/// The line with the largest reaction; where only forces load the body, with the largest load factor.
pub(crate) fn peak(history: &[HistoryLine]) -> Option<&HistoryLine> {
    match is_driven_by_forces(history) {
        true => largest_load_factor(history),
        false => history
            .iter()
            .max_by(|a, b| a.reaction.total_cmp(&b.reaction)),
    }
}

/// The line with the largest λ of the last phase: a load that only grows would have broken the body there.
pub(crate) fn largest_load_factor(history: &[HistoryLine]) -> Option<&HistoryLine> {
    let phase = history.last()?.phase;
    let lines: Vec<&HistoryLine> = history.iter().filter(|line| line.phase == phase).collect();
    let factors: Vec<f64> = lines.iter().map(|line| line.load_factor).collect();
    Some(lines[envelope::peak(&factors)?])
}

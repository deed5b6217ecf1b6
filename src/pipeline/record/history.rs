//! `history.csv`: a line for each load step or event, written as the run goes.

use crate::boundary::Boundary;
use crate::output::number::exact;
use crate::pipeline::read::plan::Probe;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// One line of the history: a load step, or an event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HistoryLine {
    pub step: usize,
    /// Index of the phase of the programme.
    pub phase: usize,
    /// λ of the phase [-].
    pub load_factor: f64,
    /// The largest λ of the phase so far [-].
    pub envelope_load_factor: f64,
    /// μ, the share of all loads that acts [-].
    pub load_share: f64,
    /// The largest prescribed displacement of the moment [m].
    pub grip_displacement: f64,
    /// Largest resultant on a group with prescribed displacements [N].
    pub reaction: f64,
    /// The same before bonds broke in the step [N]; it differs where the step has several passes.
    pub breaking_reaction: f64,
    /// [J].
    pub elastic_energy: f64,
    /// [J].
    pub dissipated_energy: f64,
    /// [J].
    pub external_work: f64,
    pub bonds_broken: usize,
    pub bonds_broken_total: usize,
    /// Changes of integrity since the start.
    pub changes: usize,
    pub passes: usize,
    /// Largest backward error of the step's solves.
    pub residual: f64,
    /// Energy that the broken bonds took at their critical stretch, over the energy release rate [m].
    pub crack_length: f64,
    /// Resultant on each group that prescribes displacements, in alphabetical order [N].
    pub reactions: Vec<[f64; 2]>,
    /// The displacement that each probe reads, in alphabetical order [m].
    pub probes: Vec<f64>,
}

const COLUMNS: &str = "step,phase,load_factor,envelope_load_factor,load_share,grip_displacement_m,\
                       reaction_n,elastic_energy_j,dissipated_energy_j,external_work_j,bonds_broken,\
                       bonds_broken_total,passes,residual,crack_length_m";

/// The names of the columns; two for each group that prescribes displacements, one for each probe.
pub(crate) fn header(supports: &Boundary, probes: &[Probe]) -> String {
    let groups: BTreeSet<&str> = (supports.prescribed.values())
        .map(|(_, group)| group.as_str())
        .collect();
    let mut header = COLUMNS.to_owned();
    for group in groups {
        for axis in ["x", "y"] {
            header += &format!(",{}", quoted(&format!("reaction_{group}_{axis}_n")));
        }
    }
    for probe in probes {
        header += &format!(",{}", quoted(&format!("probe_{}_m", probe.name)));
    }
    header
}

/// A cell as in RFC 4180.
pub(crate) fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

impl HistoryLine {
    /// `phase`: its name, where there are several.
    pub(crate) fn csv(&self, phase: &str) -> String {
        let numbers = [
            self.load_factor,
            self.envelope_load_factor,
            self.load_share,
            self.grip_displacement,
            self.reaction,
            self.elastic_energy,
            self.dissipated_energy,
            self.external_work,
        ];
        let counts = [self.bonds_broken, self.bonds_broken_total, self.passes];
        let mut cells = vec![self.step.to_string(), quoted(phase)];
        cells.extend(numbers.map(exact));
        cells.extend(counts.map(|count| count.to_string()));
        cells.extend([self.residual, self.crack_length].map(exact));
        cells.extend(self.reactions.iter().flatten().map(|&force| exact(force)));
        cells.extend(self.probes.iter().map(|&displacement| exact(displacement)));
        cells.join(",")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_a_comma_or_a_quote_stays_one_cell() {
        assert_eq!(quoted("top"), "top");
        assert_eq!(quoted("a, \"b\""), "\"a, \"\"b\"\"\"");
    }
}

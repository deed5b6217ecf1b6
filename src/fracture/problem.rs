//! The problem that a run solves: body, loads, bond laws, and how the load grows.

use super::bond_laws::BondLaws;
use super::programme::Programme;
use crate::model::Model;
use crate::statics::Backend;

/// The three controls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// One solve per load step; all bonds over their limit break, then the next step: Qian et al.
    /// (2021), section 4.2.
    OnePass,
    /// Solves again at the same load until no bond breaks.
    Equilibrium {
        /// More passes than these at one load end the run.
        most_passes: usize,
    },
    /// Scales the load to the next bond's limit: no step size, snap-back is traced.
    EventDriven,
}

/// Conditions that end a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Until {
    /// Load steps, or events; [`Until::NO_LIMIT`] where their number does not end the run.
    pub steps: usize,
    /// Whether the separation of the body ends the run.
    pub separated: bool,
}

impl Until {
    pub const NO_LIMIT: usize = usize::MAX;
}

/// Everything that a run needs and does not change.
pub struct Problem<'a> {
    pub model: &'a Model,
    pub programme: &'a Programme,
    pub laws: &'a BondLaws,
    pub control: Control,
    pub until: Until,
    pub resolution: Resolution,
}

/// How the response is found after bonds have broken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Resolution {
    /// By updates of the last factorisation, as long as they do.
    #[default]
    Fast,
    /// By a factorisation for every response: what all else is checked against.
    Reference,
    /// The same as [`Resolution::Fast`], by one backend whatever the size of the system. A backend that
    /// cannot update factorises for every response.
    By(Backend),
}

impl Resolution {
    /// Backend by which systems are solved; `None` for the one that suits their size.
    pub fn backend(self) -> Option<Backend> {
        match self {
            Resolution::Fast | Resolution::Reference => None,
            Resolution::By(backend) => Some(backend),
        }
    }
}

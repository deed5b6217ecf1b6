//! How a run ends.

use serde::{Deserialize, Serialize};

/// How a run ended. None of these is an error but [`Ending::Singular`], after which the last good state
/// stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Ending {
    /// The reaction fell under 2 % of its peak, or a loaded part broke off.
    Separated,
    /// A loaded part hangs on a hinge and swings freely.
    Collapsed,
    /// K of what is left is singular, or too close to it for a solution.
    Singular,
    /// The programme has come to its end.
    LoadLimit,
    /// All steps are done.
    StepLimit,
    /// Bonds still broke after the most passes at one load.
    PassLimit,
    /// No load breaks another bond.
    NothingLeftToBreak,
    /// Cracks have come to material that cannot break, and the load grows again.
    ReachedUnbreakable,
}

impl Ending {
    pub const ALL: [Ending; 8] = [
        Ending::Separated,
        Ending::Collapsed,
        Ending::Singular,
        Ending::LoadLimit,
        Ending::StepLimit,
        Ending::PassLimit,
        Ending::NothingLeftToBreak,
        Ending::ReachedUnbreakable,
    ];

    /// In a few words.
    pub fn describe(self) -> &'static str {
        match self {
            Ending::Separated => "separated",
            Ending::Collapsed => "collapsed",
            Ending::Singular => "stopped, singular",
            Ending::LoadLimit => "load limit",
            Ending::StepLimit => "step limit",
            Ending::PassLimit => "pass limit",
            Ending::NothingLeftToBreak => "nothing left to break",
            Ending::ReachedUnbreakable => "reached unbreakable material",
        }
    }
}

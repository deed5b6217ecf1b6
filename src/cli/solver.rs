//! `--solver`: what systems of equations are solved by.

use crate::statics::Backend;
use clap::{Args, ValueEnum};

#[derive(Args)]
pub(super) struct SolverArguments {
    /// Solve by this backend, whatever the size [default: own, and two-level for large lattices]
    #[arg(long, value_enum, value_name = "SOLVER")]
    solver: Option<SolverName>,
    /// The same as --solver two-level
    #[arg(long, conflicts_with = "solver")]
    iterative_solver: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum SolverName {
    /// The program's own Cholesky factorisation, which is updated while bonds break
    Own,
    /// Conjugate gradients on two levels, for systems whose factors would be too large
    TwoLevel,
    /// The Cholesky factorisation of the crate faer, as a whole after every break: to check the own one against
    Faer,
}

impl SolverArguments {
    pub(super) fn backend(&self) -> Option<Backend> {
        match self.solver {
            Some(SolverName::Own) => Some(Backend::Multifrontal),
            Some(SolverName::TwoLevel) => Some(Backend::TwoLevel),
            Some(SolverName::Faer) => Some(Backend::Faer),
            None => self.iterative_solver.then_some(Backend::TwoLevel),
        }
    }
}

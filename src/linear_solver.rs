//! K U = R, Qian et al. (2021), eq. (11): ordering, symbolic and numeric Cholesky factorisation,
//! solution and its residual, each apart from the others.

pub mod cholesky;
mod compliance;
mod metis;
pub mod ordering;

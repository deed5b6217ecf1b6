//! Quasi-static fracture: solve, break what is over its limit, solve again.
//!
//! Between two breaks the response is linear in the load factor λ, so that one solve for λ = 1
//! serves until the next bond breaks: u(λ) = λ u_1.

mod active_zone;
mod advance;
mod compliance;
pub mod control;
mod corridor;
pub mod crack_length;
mod dense;
pub mod ending;
pub mod event;
pub mod functional;
mod gone;
pub mod laws;
mod lost;
pub mod problem;
pub mod programme;
pub mod response;
mod solutions;
pub mod state;
mod touched;
mod update;
mod zone;

//! Quasi-static fracture: solve, break what is over its limit, solve again.
//!
//! Between two breaks the response is linear in the load factor λ, so that one solve for λ = 1
//! serves until the next bond breaks: u(λ) = λ u_1.

mod active_zone;
mod compliance;
pub mod control;
mod corridor;
mod dense;
pub mod event;
pub mod failure;
pub mod functional;
mod gone;
mod lost;
pub mod programme;
pub mod response;
pub mod state;
mod touched;
mod update;
mod zone;

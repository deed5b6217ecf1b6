//! Quasi-static fracture: solve, break what is over its limit, solve again.
//!
//! Between two breaks the response is linear in the load factor λ, so that one solve for λ = 1
//! serves until the next bond breaks: u(λ) = λ u_1.

mod advance;
pub mod bond_laws;
pub mod control;
mod costs;
pub mod crack_length;
mod dense;
pub mod earlier;
pub mod ending;
pub mod envelope;
pub mod event;
pub mod functional;
pub mod laws;
mod load_course;
mod look_ahead;
mod low_rank;
mod policy;
mod predictor;
pub mod problem;
pub mod programme;
mod rates;
pub mod response;
mod solutions;
pub mod state;
mod unbreakable;
mod update;
mod zone;
mod zone_compliance;
mod zone_nodes;
mod zone_response;
mod zone_run;
mod zone_start;

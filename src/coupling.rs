//! Couplings: the interactions that tie finite elements to the material points of a lattice.
//!
//! A coupling is a file here that implements [`Tie`], and a variant of [`Coupling`].

pub mod clip;
pub mod truss;

use crate::geometry::Outline;
use crate::interactions::Interactions;
use crate::mesh::{Edge, Mesh};
use crate::peridynamics::axes::Axes;
use crate::peridynamics::cells::{self, Cell};
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::lattice::Lattice;
use crate::peridynamics::surface::Surface;
use crate::peridynamics::visibility::Visibility;
use clip::FamilyShare;
use truss::NodeArea;

/// The couplings between finite elements and material points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coupling {
    /// Trusses of the paper, with this area A_FE of the interface nodes.
    Truss(NodeArea),
    /// Bonds end where they cross the interface.
    Clip,
}

impl Coupling {
    /// The implementation of the coupling.
    pub fn tie(self) -> Box<dyn Tie> {
        match self {
            Coupling::Truss(node_area) => Box::new(node_area),
            Coupling::Clip => Box::new(clip::Clip),
        }
    }
}

/// Finite elements and one lattice beside them, as a coupling sees them.
pub struct Parts<'a> {
    pub mesh: &'a Mesh,
    /// The mesh's cells that are finite elements.
    pub elements: &'a [usize],
    /// The node at each of the mesh's nodes, where finite elements use it.
    pub node_of: &'a [Option<u32>],
    /// Edges of the lattice's outline, with the lattice on their left.
    pub edges: &'a [Edge],
    /// Edges shared by finite elements, on their left, and the lattice.
    pub interface: &'a [Edge],
    /// Outline of the lattice along its axes.
    pub outline: &'a Outline,
    /// Material points along the lattice's axes.
    pub lattice: &'a Lattice,
    pub axes: Axes,
    /// The node of the first material point.
    pub first_node: u32,
    pub micromodulus: &'a Micromodulus,
    /// Correction of bonds near free surfaces.
    pub surface: Option<&'a Surface>,
    /// Visibility along the lattice's axes.
    pub visibility: &'a Visibility,
    /// h_t [m].
    pub thickness: f64,
}

/// The interactions of lattices after the coupling.
#[derive(Debug, Default)]
pub struct Tied {
    /// Bonds that the coupling leaves as they are, and the interactions that it adds.
    pub interactions: Interactions,
    /// The places of clipped bonds in the families of points.
    pub family_shares: Vec<FamilyShare>,
    /// ξ of the bond that each clipped bond is a part of [m].
    pub bond_lengths: Vec<f64>,
}

impl Tied {
    /// Adds the interactions of another lattice, each kind after its own.
    pub fn append(&mut self, other: Tied) {
        let before = self.interactions.clipped_bonds().len() as u32;
        let shares = other.family_shares.into_iter().map(|share| FamilyShare {
            interaction: before + share.interaction,
            ..share
        });
        self.family_shares.extend(shares);
        self.bond_lengths.extend(other.bond_lengths);
        self.interactions.append(other.interactions);
    }
}

/// A way to tie finite elements to a lattice.
pub trait Tie {
    /// Name of the interactions that the coupling adds, in the plural.
    fn name(&self) -> &'static str;

    /// Material points nearer to the interface than this share of dx are left out [-].
    fn clearance(&self) -> f64;

    /// Whether the areas of points end at the interface; else they end where the body does.
    fn interface_cuts_areas(&self) -> bool;

    /// Ties the `bonds` of a lattice to the finite elements.
    fn tie(&self, bonds: Interactions, parts: &Parts) -> Tied;

    /// The cells of a lattice: the squares between four of its points.
    ///
    /// # Errors
    /// The place of a square that makes no cell, along x and y [m].
    fn cells(&self, parts: &Parts) -> Result<Vec<Cell>, [f64; 2]> {
        let Parts {
            lattice,
            outline,
            visibility,
            first_node,
            ..
        } = *parts;
        Ok(cells::cells(
            lattice,
            outline,
            visibility,
            first_node,
            &|_| false,
        ))
    }
}

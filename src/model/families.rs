//! The family of a material point: the interactions that join it to its neighbours within the horizon.

use super::Model;

/// One member of a material point's family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FamilyMember {
    pub interaction: usize,
    /// Number of the material point whose family it is in.
    pub point: usize,
    neighbour: Neighbour,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Neighbour {
    /// Number of the material point at the other end of a bond.
    Point(usize),
    /// Area that a clipped bond stands for [m²].
    Area(f64),
}

impl Model {
    /// The members of all families: every bond twice, in the families of both of its ends, then the
    /// clipped bonds. Trusses belong to no family, eq. (7) being over bonds.
    pub fn families(&self) -> impl Iterator<Item = FamilyMember> {
        let first = self.fe_node_count();
        let bonds = self.interactions.bonds().zip(self.interactions.pairs());
        let bonds = bonds.flat_map(move |(interaction, pair)| {
            let [i, j] = pair.map(|node| node as usize - first);
            [(i, j), (j, i)].map(|(point, other)| FamilyMember {
                interaction,
                point,
                neighbour: Neighbour::Point(other),
            })
        });
        let first_clipped = self.interactions.clipped_bonds().start;
        let clipped = self.clipped.iter().map(move |share| FamilyMember {
            interaction: first_clipped + share.interaction as usize,
            point: share.point as usize - first,
            neighbour: Neighbour::Area(share.area),
        });
        bonds.chain(clipped)
    }

    /// Area A_j of a neighbour that counts in a family [m²].
    pub fn neighbour_area(&self, member: &FamilyMember) -> f64 {
        match member.neighbour {
            Neighbour::Area(area) => area,
            Neighbour::Point(other) => {
                let xi = self
                    .interactions
                    .length(member.interaction, &self.positions);
                let node = self.fe_node_count() + member.point;
                self.areas[other] * self.area_fraction(node, xi)
            }
        }
    }
}

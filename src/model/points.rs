//! The material points of peridynamic regions, and their bonds.

use super::check::check_count;
use super::{Method, Model, ModelError, PeridynamicSettings, PointRegion, Region};
use crate::coupling::Coupling;
use crate::coupling::clip::side::Side;
use crate::coupling::clip::{self, FamilyShare, clip};
use crate::geometry::{Outline, chords};
use crate::mesh::Edge;
use crate::peridynamics::axes::Axes;
use crate::peridynamics::bonds::bonds;
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::lattice::{
    Lattice, LatticeSettings, Neighbourhood, ON_BOUNDARY, lattice_beside,
};
use crate::peridynamics::surface::{Surface, SurfaceCorrection};
use crate::peridynamics::visibility::Visibility;
use std::collections::HashSet;

impl Model {
    pub(super) fn add_material_points(&mut self) -> Result<(), ModelError> {
        let fe_nodes = self.fe_node_count();
        for index in 0..self.regions.len() {
            let region = &self.regions[index];
            let Method::Peridynamics(settings) = region.method else {
                continue;
            };
            if self.leader[index] != index {
                continue;
            }
            let outline = Outline::of_cells(&self.mesh, &self.lattice_cells(index));
            let axes = settings.lattice.axes();
            let turned = axes.outline(&outline);
            check_count(region, &turned, &settings)?;
            let lattice = self.lattice(index, &turned, &settings.lattice);
            let [low, high] = turned.bounds();
            let is_larger = (0..2).all(|k| settings.lattice.spacing > high[k] - low[k]);
            if lattice.positions.is_empty() || is_larger {
                return Err(ModelError::NoMaterialPoint {
                    region: region.name.clone(),
                });
            }
            let micromodulus = settings.micromodulus(&region.material, self.settings.plane);
            let first = fe_nodes + self.areas.len();
            let Lattice {
                positions, areas, ..
            } = &lattice;
            let thickness = self.settings.thickness;
            let visibility = self.visibility(&axes, &micromodulus);
            let first_node = first as u32;
            let mut bonds = bonds(&lattice, &micromodulus, thickness, first_node, &visibility);
            let surface = self.surface(region, &turned, &settings, &micromodulus, &visibility)?;
            if let Some(surface) = &surface {
                surface.correct(&mut bonds, positions, first as u32);
            }
            if self.settings.coupling == Coupling::Clip {
                let clipped = clip(&clip::Region {
                    outline: &turned,
                    sides: &self.sides(index, &axes),
                    index: &lattice.index,
                    axes,
                    areas,
                    micromodulus: &micromodulus,
                    surface: surface.as_ref(),
                    visibility: &visibility,
                    thickness,
                    first_node: first as u32,
                });
                let first = first as u32;
                bonds.retain_bonds(|pair| {
                    let pair = pair.map(|node| node - first);
                    clipped.replaced.binary_search(&pair).is_err()
                });
                let before = self.interactions.clipped_bonds().len();
                self.clipped
                    .extend(clipped.shares.iter().map(|share| FamilyShare {
                        interaction: before as u32 + share.interaction,
                        ..*share
                    }));
                self.clipped_from.extend(clipped.bond_lengths);
                bonds.append(clipped.interactions);
            }
            let positions: Vec<[f64; 2]> = positions.iter().map(|&x| axes.global(x)).collect();
            let areas = lattice.areas;
            self.interactions.append(bonds);
            self.points.push(PointRegion {
                region: index,
                nodes: first..first + positions.len(),
                axes,
                index: lattice.index,
                micromodulus,
                area: outline.area(),
                outline,
            });
            self.region_of.extend(self.label(index, &positions));
            self.positions.extend(positions);
            self.areas.extend(areas);
        }
        Ok(())
    }

    /// The material points of a region, along the lattice's axes.
    fn lattice(&self, region: usize, turned: &Outline, settings: &LatticeSettings) -> Lattice {
        let axes = settings.axes();
        let segments = self.interface_segments(region).into_iter();
        let interface: Vec<_> = segments.map(|s| s.map(|x| axes.local(x))).collect();
        let body = axes.outline(&self.body_outline());
        let is_clip = self.settings.coupling == Coupling::Clip;
        let neighbourhood = Neighbourhood {
            interface: &interface,
            clearance: if is_clip {
                clip::CLEARANCE
            } else {
                ON_BOUNDARY
            },
            body: is_clip.then_some(&body),
        };
        lattice_beside(turned, &neighbourhood, &settings.along_axes())
    }

    /// The sides of a region's outline, with the region on the left, along the lattice's axes.
    fn sides(&self, region: usize, axes: &Axes) -> Vec<Side> {
        let interface: HashSet<[usize; 2]> = self
            .interfaces_of(region)
            .flat_map(|i| i.edges.iter().map(Edge::key))
            .collect();
        let position = |node: usize| axes.local(self.mesh.nodes[node]);
        let side = |edge: Edge| Side {
            ends: edge.ends.map(position),
            middle: edge.middle.map(position),
            nodes: if interface.contains(&edge.key()) {
                edge.nodes().filter_map(|node| self.node_of[node]).collect()
            } else {
                Vec::new()
            },
        };
        let edges = self.mesh.outline(&self.lattice_cells(region));
        edges.into_iter().map(side).collect()
    }

    /// The factors of a region's bonds near free surfaces, if it is to be corrected. `turned`: the
    /// region's outline along the lattice's axes.
    pub(super) fn surface(
        &self,
        region: &Region,
        turned: &Outline,
        settings: &PeridynamicSettings,
        micromodulus: &Micromodulus,
        visibility: &Visibility,
    ) -> Result<Option<Surface>, ModelError> {
        if settings.surface_correction == SurfaceCorrection::None {
            return Ok(None);
        }
        let surface = Surface::new(
            settings.surface_correction,
            turned,
            &settings.lattice.axes().outline(&self.body_outline()),
            &settings.lattice.along_axes(),
            micromodulus,
            visibility,
        );
        surface.map(Some).map_err(|source| ModelError::Surface {
            region: region.name.clone(),
            source,
        })
    }

    /// What the points of a lattice see of each other, along its axes.
    pub fn visibility(&self, axes: &Axes, micromodulus: &Micromodulus) -> Visibility {
        let body = axes.outline(&self.body_outline());
        Visibility::new(&body, micromodulus.spacing, micromodulus.reach())
    }

    /// The outline of all regions together.
    pub(super) fn body_outline(&self) -> Outline {
        let mut cells: Vec<usize> = self.regions.iter().flat_map(|r| r.cells.clone()).collect();
        cells.sort_unstable();
        Outline::of_cells(&self.mesh, &cells)
    }

    pub(super) fn interface_segments(&self, region: usize) -> Vec<[[f64; 2]; 2]> {
        let edges = self.interfaces_of(region).flat_map(|i| &i.edges);
        edges
            .flat_map(|edge| {
                let points = chords(edge, &self.mesh.nodes);
                (1..points.len())
                    .map(move |k| [points[k - 1], points[k]])
                    .collect::<Vec<_>>()
            })
            .collect()
    }
}

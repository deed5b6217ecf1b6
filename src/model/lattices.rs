//! The material points and bonds of one lattice, before a coupling ties them to finite elements.

use super::check::check_count;
use super::topology::{LatticePart, Topology};
use super::{ModelError, ModelSettings, PeridynamicSettings, Region};
use crate::geometry::{Outline, chords};
use crate::interactions::Interactions;
use crate::mesh::Mesh;
use crate::peridynamics::axes::Axes;
use crate::peridynamics::bonds::bonds;
use crate::peridynamics::kernel::Micromodulus;
use crate::peridynamics::lattice::{Lattice, Neighbourhood, lattice_beside};
use crate::peridynamics::surface::{Surface, SurfaceCorrection, SurfaceError};
use crate::peridynamics::visibility::Visibility;

/// Material points of a lattice, along its axes.
pub(super) struct LatticeOfPoints {
    pub lattice: Lattice,
    pub axes: Axes,
    /// Outline of the lattice's regions along its axes.
    pub outline: Outline,
    pub micromodulus: Micromodulus,
    pub visibility: Visibility,
    pub surface: Option<Surface>,
}

impl LatticeOfPoints {
    /// # Errors
    /// [`ModelError::NoMaterialPoint`], [`ModelError::TooManyPoints`], [`ModelError::TooManyBonds`],
    /// [`ModelError::Surface`].
    pub fn new(
        mesh: &Mesh,
        regions: &[Region],
        model: &ModelSettings,
        topology: &Topology,
        part: &LatticePart,
    ) -> Result<LatticeOfPoints, ModelError> {
        let region = &regions[part.leader()];
        let settings = part.settings;
        let axes = settings.lattice.axes();
        let outline = axes.outline(&part.part.outline);
        let body = axes.outline(&topology.body.outline);
        check_count(region, &outline, &settings)?;
        let segments = part.interface.iter().flat_map(|edge| {
            let points = chords(edge, &mesh.nodes);
            let segments = points.windows(2).map(|w| [w[0], w[1]]);
            segments.collect::<Vec<_>>()
        });
        let interface: Vec<_> = segments.map(|s| s.map(|x| axes.local(x))).collect();
        let tie = model.coupling.tie();
        let neighbourhood = Neighbourhood {
            interface: &interface,
            clearance: tie.clearance(),
            body: (!tie.interface_cuts_areas()).then_some(&body),
        };
        let lattice = lattice_beside(&outline, &neighbourhood, &settings.lattice.along_axes());
        let [low, high] = outline.bounds();
        let is_larger = (0..2).all(|k| settings.lattice.spacing > high[k] - low[k]);
        if lattice.positions.is_empty() || is_larger {
            return Err(ModelError::NoMaterialPoint {
                region: region.name.clone(),
            });
        }
        let micromodulus = settings.micromodulus(&region.material, model.plane);
        let visibility = Visibility::new(&body, micromodulus.spacing, micromodulus.reach());
        let surface = surface(&settings, &outline, &body, &micromodulus, &visibility);
        let surface = surface.map_err(|source| ModelError::Surface {
            region: region.name.clone(),
            source,
        })?;
        Ok(LatticeOfPoints {
            lattice,
            axes,
            outline,
            micromodulus,
            visibility,
            surface,
        })
    }

    /// Positions of all points along x and y [m].
    pub fn positions(&self) -> Vec<[f64; 2]> {
        let positions = self.lattice.positions.iter();
        positions.map(|&x| self.axes.global(x)).collect()
    }

    /// The bonds of all points, whose nodes count from `first_node`; corrected near free surfaces.
    pub fn bonds(&self, thickness: f64, first_node: u32) -> Interactions {
        let LatticeOfPoints {
            lattice,
            micromodulus,
            visibility,
            surface,
            ..
        } = self;
        let mut bonds = bonds(lattice, micromodulus, thickness, first_node, visibility);
        if let Some(surface) = surface {
            surface.correct(&mut bonds, &lattice.positions, first_node);
        }
        bonds
    }
}

/// The correction of bonds near free surfaces, if one is chosen.
fn surface(
    settings: &PeridynamicSettings,
    outline: &Outline,
    body: &Outline,
    micromodulus: &Micromodulus,
    visibility: &Visibility,
) -> Result<Option<Surface>, SurfaceError> {
    if settings.surface_correction == SurfaceCorrection::None {
        return Ok(None);
    }
    Surface::new(
        settings.surface_correction,
        outline,
        body,
        &settings.lattice.along_axes(),
        micromodulus,
        visibility,
    )
    .map(Some)
}

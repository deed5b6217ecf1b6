//! Warnings about a model that can be computed.

use super::Run;
use crate::coupling::Coupling;
use crate::gmsh::Extract;
use crate::model::{Method, Model};
use crate::pipeline::show::results::lattice_name;

/// A lattice whose areas are off by more than this is worth a word: the paper's full cells on grid
/// nodes are.
const AREA_WARNING: f64 = 1e-6;

/// Warnings of one program beyond these are counted: a mesher can have thousands.
const MOST_MESH_WARNINGS: usize = 5;

impl Run<'_> {
    /// The warnings of the program that made or read the mesh.
    pub(super) fn warn_of_mesh(&mut self, extract: &Extract) {
        let program = &extract.origin.program;
        for warning in extract.warnings.iter().take(MOST_MESH_WARNINGS) {
            self.observer.warns(&format!("{program}: {warning}"));
        }
        let more = extract.warnings.len().saturating_sub(MOST_MESH_WARNINGS);
        if more > 0 {
            let plural = if more == 1 { "" } else { "s" };
            self.observer
                .warns(&format!("{program}: {more} more warning{plural}"));
        }
    }

    pub(super) fn warn_of_areas(&mut self, model: &Model) {
        // Where cells extend beyond the interface, their areas need not sum to the region's.
        let is_truss = matches!(model.settings.coupling, Coupling::Truss(_));
        let points = model.points.iter().filter(|_| is_truss);
        for points in points {
            let first = model.fe_node_count();
            let areas = &model.areas[points.nodes.start - first..points.nodes.end - first];
            let share = areas.iter().sum::<f64>() / points.area;
            if (share - 1.0).abs() > AREA_WARNING {
                self.observer.warns(&format!(
                    "the material points of `{}` stand for {:.2} % of its area",
                    lattice_name(model, points),
                    100.0 * share
                ));
            }
        }
    }

    /// Under two horizons no point has a whole family, and the correction of free surfaces is all that there is.
    pub(super) fn warn_of_narrow_regions(&mut self, model: &Model) {
        for points in &model.points {
            let Method::Peridynamics(settings) = model.regions[points.region].method else {
                continue;
            };
            let [low, high] = settings.lattice.axes().outline(&points.outline).bounds();
            let width = [0, 1].map(|axis| (high[axis] - low[axis]) / settings.lattice.spacing);
            let width = width[0].min(width[1]);
            if width < 2.0 * settings.horizon_ratio * (1.0 - AREA_WARNING) {
                self.observer.warns(&format!(
                    "the region `{}` is {width:.1} spacings wide, under 2 horizons, which are {} spacings: \
                     choose a smaller `spacing`, or make it wider",
                    lattice_name(model, points),
                    2.0 * settings.horizon_ratio
                ));
            }
        }
    }
}

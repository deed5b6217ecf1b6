//! The mesh stage: its result is kept only after the model has been built from it.

use super::{MESH_FILE, Observer, Run};
use crate::gmsh::Extract;
use crate::meshio::{self};
use crate::output::write_whole;
use crate::phases::{Phases, collect, measure};
use crate::pipeline::account::costs::Costs;
use crate::pipeline::error::RunError;
use crate::pipeline::record::frames::encode;
use crate::pipeline::record::stamp::{self, Recipe, Stage};
use crate::pipeline::record::stored::read_stored;
use crate::pipeline::stages::meshing::mesh_geometry;
use crate::trace::Kind;

/// The mesh stage's result.
pub(super) struct Meshed {
    pub extract: Extract,
    bytes: Vec<u8>,
    recipe: Recipe,
    /// Made in this run, and not yet kept.
    pub is_new: bool,
    phases: Phases,
}

impl Run<'_> {
    /// The recipe is written down before Gmsh reads the geometry: an edit in the meantime is then
    /// noticed by the next run.
    pub(super) fn mesh(&mut self) -> Result<Meshed, RunError> {
        let recipe = self.recipe(Stage::Mesh)?;
        if self.is_fresh(Stage::Mesh, &recipe)
            && let Some((extract, bytes)) = read_stored(&self.plan.folder.join(MESH_FILE))
        {
            self.kept.insert(MESH_FILE, stamp::hash(&bytes));
            self.restore(Stage::Mesh);
            return Ok(Meshed {
                extract,
                bytes,
                recipe,
                is_new: false,
                phases: Phases::default(),
            });
        }
        self.observer.starts(Stage::Mesh);
        let _span = self.options.trace.span(Kind::Stage, Stage::Mesh.name());
        let program = match meshio::reads(&self.plan.geometry.file) {
            true => "meshio",
            false => "gmsh",
        };
        let (extract, phases) = collect(&self.options.trace, || {
            measure(program, || mesh_geometry(self.plan, self.options))
        });
        let extract = extract?;
        let bytes = encode(&extract);
        self.kept.insert(MESH_FILE, stamp::hash(&bytes));
        self.costs.phases.append(phases.list.clone());
        Ok(Meshed {
            extract,
            bytes,
            recipe,
            is_new: true,
            phases,
        })
    }

    pub(super) fn keep_mesh(&mut self, mesh: &Meshed) -> Result<(), RunError> {
        if !mesh.is_new {
            self.observer.is_fresh(Stage::Mesh);
            return Ok(());
        }
        self.lock()?;
        self.begin(Stage::Mesh, &[MESH_FILE.to_owned()])?;
        write_whole(&self.plan.folder.join(MESH_FILE), &mesh.bytes)?;
        let costs = Costs {
            phases: mesh.phases.clone(),
            ..Costs::default()
        };
        self.finish(
            Stage::Mesh,
            mesh.recipe.clone(),
            &[MESH_FILE.to_owned()],
            &costs,
        )?;
        let what = format!(
            "{}: {} nodes, {} groups",
            mesh.extract.origin,
            mesh.extract.nodes.len(),
            mesh.extract.groups.len()
        );
        self.observer.ends(Stage::Mesh, &what, mesh.phases.total());
        Ok(())
    }
}

//! The pictures of a run: mesh, displacements, damage, reaction over grip displacement.

use super::damage_picture::{DAMAGE_PICTURE, damage_file, damage_picture, dots};
use super::fracture::read_frame;
use super::history::Line;
use super::made::Made;
use super::plan::Plan;
use super::results::{Outcome, ResultsError};
use super::run::RunError;
use super::solved::Course;
use crate::fem::element::MappedPoint;
use crate::geometry::{chords, chords_of};
use crate::model::{Method, Model};
use crate::output::picture::{
    self, Axis, Chart, Curve, FieldPicture, Filling, Mark, MeshPicture, Patch, Picture,
    PictureError, Square,
};
use crate::output::write_whole;
use crate::trace::Trace;
use std::path::Path;

/// A picture of the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sheet {
    Mesh,
    /// A component of the displacement of the last state.
    Displacement(usize),
    /// Of the last state.
    Damage,
    /// At a step that the pipeline names.
    DamageAt(usize),
    LoadDisplacement,
}

impl Sheet {
    pub fn file(self) -> String {
        match self {
            Sheet::Mesh => MESH_PICTURE.to_owned(),
            Sheet::Displacement(axis) => format!("displacement_{}.png", ['x', 'y'][axis]),
            Sheet::Damage => DAMAGE_PICTURE.to_owned(),
            Sheet::DamageAt(step) => damage_file(step),
            Sheet::LoadDisplacement => "load_displacement.png".to_owned(),
        }
    }
}

pub(super) const MESH_PICTURE: &str = "mesh.png";

impl Outcome<'_> {
    /// The pictures that there are, in the order in which they are listed.
    pub(super) fn sheets(&self) -> Vec<Sheet> {
        let mut sheets = vec![Sheet::Mesh, Sheet::Displacement(0), Sheet::Displacement(1)];
        let course = self.solved.fracture.as_ref();
        if self.has_damage() {
            sheets.push(Sheet::Damage);
            let pictured = course.map_or_else(Vec::new, |course| self.pictured(course));
            sheets.extend(pictured.into_iter().map(Sheet::DamageAt));
        }
        sheets.extend(course.map(|_| Sheet::LoadDisplacement));
        sheets
    }

    /// Draws one into `folder`.
    pub(super) fn draw(
        &self,
        sheet: Sheet,
        folder: &Path,
        trace: &Trace,
    ) -> Result<Made, RunError> {
        let Outcome {
            plan,
            model,
            solved,
            ..
        } = self;
        let course = solved.fracture.as_ref();
        let frame = match sheet {
            Sheet::DamageAt(step) => Some(read_frame(&plan.folder, step)?),
            _ => None,
        };
        let made = Made::measured(sheet.file(), trace, |file| {
            let picture = match (sheet, course) {
                (Sheet::LoadDisplacement, Some(course)) => self.load_displacement(course).draw(),
                (Sheet::Displacement(axis), _) => self.displacement_picture(axis).draw(),
                (Sheet::Damage | Sheet::DamageAt(_), _) => {
                    let last = course.and_then(|course| course.history.last());
                    let (step, intact) = match &frame {
                        Some(frame) => (Some(frame.step), &frame.intact),
                        None => (last.map(|line| line.step), &solved.intact),
                    };
                    damage_picture(plan, model, step, intact).draw()
                }
                (Sheet::Mesh | Sheet::LoadDisplacement, _) => mesh_picture(plan, model).draw(),
            };
            put(&picture?, &folder.join(file))
        });
        Ok(made.map_err(ResultsError::from)?)
    }

    /// The steps of `output.pictures_at` that the run has come to.
    fn pictured(&self, course: &Course) -> Vec<usize> {
        let wanted = |step: &usize| self.plan.output.pictures_at.contains(step);
        course.frames.iter().copied().filter(wanted).collect()
    }

    /// What to say of steps in `output.pictures_at` that the run has not come to.
    pub(super) fn missing_pictures(&self) -> Option<String> {
        let course = self.solved.fracture.as_ref();
        let frames = course.map_or(&[][..], |course| &course.frames);
        let output = &self.plan.output;
        let missing = output.pictures_at.iter().filter(|s| !frames.contains(s));
        let missing: Vec<String> = missing.map(ToString::to_string).collect();
        if !output.pictures || missing.is_empty() {
            return None;
        }
        let end = match course.and_then(|course| course.history.last()) {
            Some(line) => format!("the run ended with step {}", line.step),
            None => "without `loading` there are no steps".to_owned(),
        };
        let missing = missing.join(", ");
        Some(format!(
            "output.pictures_at: no picture of step {missing}: {end}"
        ))
    }

    /// Reaction over grip displacement; over the load factor where nothing is displaced.
    fn load_displacement(&self, course: &Course) -> Chart {
        let grips_move = course
            .history
            .iter()
            .any(|line| line.grip_displacement > 0.0);
        let at = |line: &Line| {
            let x = if grips_move {
                line.grip_displacement
            } else {
                line.load_factor
            };
            [x, line.reaction]
        };
        let first = course.history.iter().find(|line| line.bonds_broken > 0);
        let first = first.map(|line| (line, "first bond".to_owned()));
        let last = course.history.last();
        let last = last.map(|line| (line, course.ending.describe().to_owned()));
        let mark = |(line, what): (&Line, String)| Mark {
            at: at(line),
            label: format!("{what}, step {}", line.step),
        };
        let (name, unit) = if grips_move {
            ("grip displacement", "m")
        } else {
            ("load factor", "")
        };
        let axis = |name: &str, unit: &str| Axis {
            name: name.to_owned(),
            unit: unit.to_owned(),
        };
        let start = std::iter::once([0.0, 0.0]);
        let on_envelope = envelope(&course.history);
        let envelope = (on_envelope.len() < course.history.len()).then(|| Curve {
            name: "envelope".to_owned(),
            points: on_envelope.into_iter().map(at).collect(),
            marks: Vec::new(),
        });
        Chart {
            title: format!("{}: reaction over {name}", self.plan.name),
            x: axis(name, unit),
            y: axis("reaction", "N"),
            curves: std::iter::once(Curve {
                name: "reaction".to_owned(),
                points: start.chain(course.history.iter().map(at)).collect(),
                marks: first.into_iter().chain(last).map(mark).collect(),
            })
            .chain(envelope)
            .collect(),
        }
    }

    /// u_x or u_y on the deformed shape.
    fn displacement_picture(&self, axis: usize) -> FieldPicture {
        let model = self.model;
        let u = &self.solved.solution.displacement;
        let exaggeration = picture::field::deformation_scale(self.extent(), u.iter().copied());
        let scale = exaggeration.unwrap_or(0.0);
        let moved = |node: usize| [0, 1].map(|k| model.positions[node][k] + scale * u[node][k]);
        let mut facets = Vec::new();
        for element in 0..model.elements.len() {
            let kind = model.cell(element).kind;
            let nodes: Vec<usize> = model
                .element_nodes(element)
                .into_iter()
                .map(|n| n as usize)
                .collect();
            let shape: Vec<[f64; 2]> = nodes.iter().map(|&n| moved(n)).collect();
            let divisions = if kind.is_quadratic() { 4 } else { 1 };
            facets.extend(picture::facets(kind, divisions, |at| {
                let point = MappedPoint::new(kind, &shape, at);
                let value = nodes
                    .iter()
                    .zip(point.value)
                    .map(|(&n, shape)| shape * u[n][axis])
                    .sum();
                (point.position, value)
            }));
        }
        let squares = dots(model).into_iter().zip(model.fe_node_count()..);
        let squares = squares.map(|(dot, node)| Square {
            centre: moved(node),
            side: dot.side,
            value: u[node][axis],
        });
        let edges = model
            .interfaces
            .iter()
            .flat_map(|interface| &interface.edges);
        let line =
            |n: usize| moved(model.node_of[n].expect("interfaces have element nodes") as usize);
        FieldPicture {
            title: format!("{}: displacement u_{}", self.plan.name, ['x', 'y'][axis]),
            quantity: format!("u_{}", ['x', 'y'][axis]),
            unit: "m".to_owned(),
            range: None,
            deformation_scale: exaggeration,
            facets,
            squares: squares.collect(),
            lines: edges.map(|edge| chords_of(edge, line)).collect(),
        }
    }

    /// The body's larger side [m].
    fn extent(&self) -> f64 {
        let [low, high] = self.model.bounds();
        (high[0] - low[0]).max(high[1] - low[1])
    }
}

/// Writes a picture; gives the bytes of its pixels and of the file.
pub(super) fn put(picture: &Picture, path: &Path) -> Result<[u64; 2], PictureError> {
    let bytes = picture.to_png()?;
    write_whole(path, &bytes)?;
    let [width, height] = picture.size().map(u64::from);
    Ok([3 * width * height, bytes.len() as u64])
}

/// Elements, material points, interfaces, cracks.
pub(super) fn mesh_picture(plan: &Plan, model: &Model) -> MeshPicture {
    let dots = dots(model);
    let region = |(index, region): (usize, &crate::model::Region)| {
        let (name, filling, count) = match region.method {
            Method::Peridynamics(_) => {
                let points = dots.iter().filter(|dot| dot.region == index);
                ("peridynamics", Filling::Points, points.count())
            }
            Method::FiniteElements => ("finite elements", Filling::Cells, region.cells.len()),
        };
        picture::Region {
            name: region.name.clone(),
            model: name.to_owned(),
            filling,
            count,
        }
    };
    let patch = |&(region, cell): &(usize, usize)| Patch {
        outline: picture::outline(&model.mesh.cells[cell], |n| model.mesh.nodes[n]),
        region,
    };
    let edges = model
        .interfaces
        .iter()
        .flat_map(|interface| &interface.edges);
    let cracks = plan.cracks.iter();
    let cracks = cracks.flat_map(|name| &model.mesh.curves[name]);
    MeshPicture {
        title: format!("{}: mesh and regions", plan.name),
        regions: model.regions.iter().enumerate().map(region).collect(),
        points: dots,
        cells: model.elements.iter().map(patch).collect(),
        interfaces: edges.map(|e| chords(e, &model.mesh.nodes)).collect(),
        cracks: cracks.map(|edge| chords(edge, &model.mesh.nodes)).collect(),
    }
}

/// The outline of a path that turns back and forth: up to the largest load factor what is above all that
/// went before, from there on what is above all that still comes.
fn envelope(history: &[Line]) -> Vec<&Line> {
    let by_load = |a: &&Line, b: &&Line| a.load_factor.total_cmp(&b.load_factor);
    let phase = history.last().map(|line| line.phase);
    let lines: Vec<&Line> = history.iter().filter(|l| Some(l.phase) == phase).collect();
    let Some(peak) = lines.iter().copied().max_by(by_load) else {
        return Vec::new();
    };
    let (before, after): (Vec<&Line>, Vec<&Line>) =
        lines.into_iter().partition(|line| line.step <= peak.step);
    let mut envelope = rising(before.into_iter());
    let mut falling = rising(after.into_iter().rev());
    falling.reverse();
    envelope.append(&mut falling);
    envelope
}

/// Lines above all that come before them.
fn rising<'a>(lines: impl Iterator<Item = &'a Line>) -> Vec<&'a Line> {
    let mut highest = f64::NEG_INFINITY;
    let higher = |line: &&Line| {
        let is_higher = line.load_factor > highest;
        highest = highest.max(line.load_factor);
        is_higher
    };
    lines.filter(higher).collect()
}

//! The pictures of a run: mesh, displacements, damage, reaction over grip displacement.

use super::history::Line;
use super::results::{Outcome, ResultsError};
use super::solved::Course;
use crate::fem::element::MappedPoint;
use crate::fracture::state;
use crate::geometry::{chords, chords_of};
use crate::output::picture::{
    self, Axis, Chart, Curve, Dot, FieldPicture, Filling, Mark, MeshPicture, Patch, Square,
};
use std::path::Path;

impl Outcome<'_> {
    pub(super) fn write_pictures(&self, folder: &Path) -> Result<Vec<String>, ResultsError> {
        self.mesh_picture()
            .draw()?
            .write(&folder.join("mesh.png"))?;
        let mut files = vec!["mesh.png".to_owned()];
        for (axis, file) in [(0, "displacement_x.png"), (1, "displacement_y.png")] {
            self.displacement_picture(axis)
                .draw()?
                .write(&folder.join(file))?;
            files.push(file.to_owned());
        }
        if self.has_damage() {
            self.damage_picture()
                .draw()?
                .write(&folder.join("damage.png"))?;
            files.push("damage.png".to_owned());
        }
        if let Some(course) = &self.solved.fracture {
            self.load_displacement(course)
                .draw()?
                .write(&folder.join("load_displacement.png"))?;
            files.push("load_displacement.png".to_owned());
        }
        Ok(files)
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

    /// Damage of the last state.
    fn damage_picture(&self) -> FieldPicture {
        let model = self.model;
        let course = self.solved.fracture.as_ref();
        let damage = state::damage(model, &self.solved.intact);
        let squares = self.dots().into_iter().zip(damage);
        let cells = model
            .elements
            .iter()
            .map(|&(_, cell)| &model.mesh.cells[cell]);
        let edges = cells.flat_map(|cell| cell.edges());
        FieldPicture {
            title: match course.and_then(|course| course.history.last()) {
                Some(line) => format!("{}: damage at step {}", self.plan.name, line.step),
                None => format!("{}: damage", self.plan.name),
            },
            quantity: "damage".to_owned(),
            unit: String::new(),
            deformation_scale: None,
            facets: Vec::new(),
            squares: squares
                .map(|(dot, value)| Square {
                    centre: dot.centre,
                    side: dot.side,
                    value,
                })
                .collect(),
            lines: edges.map(|edge| chords(&edge, &model.mesh.nodes)).collect(),
        }
    }

    fn mesh_picture(&self) -> MeshPicture {
        let model = self.model;
        let region = |(index, region): (usize, &crate::model::Region)| {
            let points = model.points.iter().find(|p| p.region == index);
            let (name, filling, count) = match points {
                Some(points) => ("peridynamics", Filling::Points, points.nodes.len()),
                None => ("finite elements", Filling::Cells, region.cells.len()),
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
        let cracks = self.plan.cracks.iter();
        let cracks = cracks.flat_map(|name| &model.mesh.curves[name]);
        MeshPicture {
            title: format!("{}: mesh and regions", self.plan.name),
            regions: model.regions.iter().enumerate().map(region).collect(),
            cells: model.elements.iter().map(patch).collect(),
            points: self.dots(),
            interfaces: edges.map(|e| chords(e, &model.mesh.nodes)).collect(),
            cracks: cracks.map(|edge| chords(edge, &model.mesh.nodes)).collect(),
        }
    }

    fn dots(&self) -> Vec<Dot> {
        let points = self.model.points.iter();
        let dot = |(node, side, region): (usize, f64, usize)| Dot {
            centre: self.model.positions[node],
            side,
            region,
        };
        points
            .flat_map(|p| {
                p.nodes
                    .clone()
                    .map(|n| (n, p.micromodulus.spacing, p.region))
            })
            .map(dot)
            .collect()
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
        let squares = self.dots().into_iter().zip(model.fe_node_count()..);
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

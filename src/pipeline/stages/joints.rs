//! Do the elements of the regions fit together? Elements that lie on each other or gape are refused; parts
//! that touch without being joined are reported.

use crate::mesh::conformity::{Misfit, MisfitKind, check_middle_nodes, check_sides};
use crate::mesh::contact::{Contact, contacts};
use crate::mesh::{CellKind, Mesh};
use crate::model::{Method, Model, Region};
use crate::pipeline::read::plan::Plan;
use crate::pipeline::read::source::InputError;
use std::collections::BTreeSet;

/// The remedy for parts that were drawn on their own.
const JOIN: &str = "join them: in the .geo, before the physical groups, `BooleanFragments{ Surface{:}; Delete; }{}`, or \
                    `Coherence;`; in another program, merge the parts or their coincident nodes";

/// # Errors
/// The first two elements that do not fit together.
pub(super) fn check(plan: &Plan, mesh: &Mesh, regions: &[Region]) -> Result<(), InputError> {
    let fail = |misfit: Misfit| misfit_error(plan, mesh, regions, &misfit);
    check_sides(mesh, &cells_of(regions, |_| true)).map_err(fail)?;
    // Of the elements below material points only the outline counts, which has no middle nodes.
    let finite_elements = |region: &Region| matches!(region.method, Method::FiniteElements);
    check_middle_nodes(mesh, &cells_of(regions, finite_elements)).map_err(fail)?;
    contacts(mesh, &cells_of(regions, |_| true)).map_err(fail)?;
    Ok(())
}

/// One sentence for each two parts that touch and are not joined.
pub(super) fn unjoined(plan: &Plan, model: &Model) -> Vec<String> {
    let cells = cells_of(&model.regions, |_| true);
    // A misfit has been refused before there was a model.
    let found = contacts(&model.mesh, &cells).unwrap_or_default();
    let sentence = |contact: &Contact| {
        let [first, second] = contact.cells.map(|cell| owner(&model.regions, cell));
        let parts = match first == second {
            true => format!("two parts of `{first}`"),
            false => format!("`{first}` and `{second}`"),
        };
        let length = contact.length / plan.geometry.unit_in_metres;
        format!(
            "{parts} lie side by side near {} over a length of {}, and share no nodes there: no force passes \
             between them. If they are one body, {JOIN}",
            place(plan, contact.at),
            rounded(length)
        )
    };
    found.iter().map(sentence).collect()
}

fn misfit_error(plan: &Plan, mesh: &Mesh, regions: &[Region], misfit: &Misfit) -> InputError {
    let [first, second] = misfit.cells.map(|cell| element(mesh, cell));
    let [first_owner, second_owner] = misfit.cells.map(|cell| owner(regions, cell));
    let near = place(plan, misfit.at);
    let file = plan.geometry.file.display();
    let (message, help) = match misfit.kind {
        MisfitKind::SameSide => (
            format!(
                "{first} of `{first_owner}` and {second} of `{second_owner}` in {file} lie on the same side of their \
                 common edge near {near}: one covers the other"
            ),
            "is a surface drawn twice on one loop, or an element listed twice? Remove one of them",
        ),
        MisfitKind::MiddleNode => (
            format!(
                "{first} and {second} in {file} share the ends of an edge near {near}, but not its middle node: \
                 they would gape there"
            ),
            "give neighbours the same order: four-node beside four-node, eight-node beside eight-node elements",
        ),
        MisfitKind::HangingNode => (
            format!(
                "a node of {second} in {file} lies within an edge of {first} near {near}, and is not joined to it: \
                 they would gape there"
            ),
            "divide the common line alike on both sides, so that they share all nodes",
        ),
        MisfitKind::Overlap => (
            format!(
                "{first} of `{first_owner}` and {second} of `{second_owner}` in {file} lie on each other near {near}, \
                 and are not joined"
            ),
            JOIN,
        ),
    };
    plan.source
        .error("geometry/file", message, Some(help.to_owned()))
}

fn cells_of(regions: &[Region], is_meant: impl Fn(&Region) -> bool) -> Vec<usize> {
    let meant = regions.iter().filter(|region| is_meant(region));
    // A cell of two regions is refused by the model.
    let cells: BTreeSet<usize> = meant
        .flat_map(|region| region.cells.iter().copied())
        .collect();
    cells.into_iter().collect()
}

fn owner(regions: &[Region], cell: usize) -> &str {
    let mut owners = regions.iter();
    let owner = owners.find(|region| region.cells.binary_search(&cell).is_ok());
    owner.map_or("", |region| &region.name)
}

/// `element 13 (quad8)`.
fn element(mesh: &Mesh, cell: usize) -> String {
    let kind = match mesh.cells[cell].kind {
        CellKind::Tri3 => "tri3",
        CellKind::Tri6 => "tri6",
        CellKind::Quad4 => "quad4",
        CellKind::Quad8 => "quad8",
    };
    let number = mesh.cell_numbers.get(cell).copied();
    format!("element {} ({kind})", number.unwrap_or(cell as i64))
}

/// A position in the geometry's unit.
fn place(plan: &Plan, at: [f64; 2]) -> String {
    let [x, y] = at.map(|x| rounded(x / plan.geometry.unit_in_metres));
    format!("({x}, {y})")
}

/// Six digits: enough to find the place.
fn rounded(x: f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let digits = 10_f64.powf(5.0 - x.abs().log10().floor());
    (x * digits).round() / digits + 0.0
}

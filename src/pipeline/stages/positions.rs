//! Places that the pipeline selects by position become groups of the mesh: what comes after sees no difference.

use crate::mesh::Mesh;
use crate::mesh::selection::{Place, Selected, SelectionError};
use crate::model::{Method, Region};
use crate::pipeline::read::plan::{Condition, Plan};
use crate::pipeline::read::source::InputError;

/// # Errors
/// A place at which there is nothing.
pub(super) fn add_groups(
    plan: &Plan,
    mesh: &mut Mesh,
    regions: &[Region],
) -> Result<(), InputError> {
    let mut cells: Vec<usize> = regions
        .iter()
        .flat_map(|region| region.cells.iter().copied())
        .collect();
    cells.sort_unstable();
    for condition in &plan.conditions {
        let Some(selection) = &condition.selection else {
            continue;
        };
        let name = condition.group.clone();
        match selection.select(mesh, &cells) {
            Err(error) => return Err(selection_error(plan, condition, &error)),
            Ok(Selected::Edges(edges)) => drop(mesh.curves.insert(name, edges)),
            Ok(Selected::Nodes(mut nodes)) => {
                if let (Place::Near(point), [node]) = (selection.place, nodes.as_slice())
                    && !is_of_finite_elements(mesh, regions, *node)
                {
                    // Material points do not stand on the nodes of the mesh.
                    mesh.nodes.push(point);
                    nodes = vec![mesh.nodes.len() - 1];
                }
                mesh.points.insert(name, nodes);
            }
        }
    }
    Ok(())
}

fn is_of_finite_elements(mesh: &Mesh, regions: &[Region], node: usize) -> bool {
    let mut elements = regions
        .iter()
        .filter(|region| matches!(region.method, Method::FiniteElements))
        .flat_map(|region| &region.cells);
    elements.any(|&cell| mesh.cells[cell].nodes().contains(&node))
}

fn selection_error(plan: &Plan, condition: &Condition, error: &SelectionError) -> InputError {
    let point = |[x, y]: [f64; 2]| format!("({x}, {y})");
    let help = match error {
        SelectionError::Empty {
            bounds: [low, high],
        } => format!(
            "the body reaches from {} to {} m; a bare number is in metres, and `tolerance` widens the place",
            point(*low),
            point(*high)
        ),
        SelectionError::NoEnd { end, nearest } => {
            let nearest: Vec<String> = nearest.iter().map(|&at| point(at)).collect();
            format!(
                "{} m is no node of the outline; the nearest are at {} m. Give one of them, or a `tolerance`",
                point(*end),
                nearest.join(" and ")
            )
        }
        SelectionError::Apart => {
            "the two ends lie on different outlines: give two entries".to_owned()
        }
    };
    let message = format!("`{}`: {error}", condition.group);
    let key = format!("{}/where", condition.key);
    plan.source.error(&key, message, Some(help))
}

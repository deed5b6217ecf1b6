use super::*;
use crate::gmsh::Group;

fn block(kind: i32, name: &str, order: usize, elements: &[(u64, &[usize])]) -> Block {
    Block {
        kind,
        kind_name: name.to_owned(),
        order,
        nodes_per_element: elements.first().map_or(1, |(_, nodes)| nodes.len()),
        tags: elements.iter().map(|(tag, _)| *tag).collect(),
        nodes: elements
            .iter()
            .flat_map(|(_, nodes)| nodes.to_vec())
            .collect(),
    }
}

fn group(dimension: u8, tag: i32, name: &str, blocks: Vec<Block>) -> Group {
    Group {
        dimension,
        tag,
        name: name.to_owned(),
        blocks,
    }
}

/// Two unit quads side by side: nodes 0 1 2 below, 3 4 5 above.
fn two_quads() -> Extract {
    let left = (7, &[0, 1, 4, 3][..]);
    let right = (5, &[1, 2, 5, 4][..]);
    Extract {
        nodes: (0..6)
            .map(|i| [f64::from(i % 3), f64::from(i / 3), 0.0])
            .collect(),
        groups: vec![
            group(0, 1, "origin", vec![block(15, "Point", 0, &[(1, &[0])])]),
            group(
                1,
                1,
                "base",
                vec![block(1, "Line 2", 1, &[(2, &[0, 1]), (3, &[1, 2])])],
            ),
            group(2, 1, "left", vec![block(3, "Quadrilateral 4", 1, &[left])]),
            group(
                2,
                9,
                "",
                vec![block(3, "Quadrilateral 4", 1, &[right, left])],
            ),
        ],
        entity_counts: [6, 7, 2, 0],
        ..Extract::default()
    }
}

/// One straight-sided 8-node quad on [0, 2]².
fn eight_node_quad() -> Extract {
    let positions = [
        [0., 0.],
        [2., 0.],
        [2., 2.],
        [0., 2.],
        [1., 0.],
        [2., 1.],
        [1., 2.],
        [0., 1.],
    ];
    let element = (1, &[0, 1, 2, 3, 4, 5, 6, 7][..]);
    Extract {
        nodes: positions.iter().map(|&[x, y]| [x, y, 0.0]).collect(),
        groups: vec![group(
            2,
            1,
            "q",
            vec![block(16, "Quadrilateral 8", 2, &[element])],
        )],
        ..Extract::default()
    }
}

#[test]
fn shared_element_is_one_cell_in_both_groups() {
    let mesh = two_quads().to_mesh(1.0).unwrap();
    assert_eq!(mesh.cells.len(), 2);
    assert_eq!(mesh.surfaces["left"], [1]);
    assert_eq!(mesh.surfaces["9"], [0, 1]);
    assert_eq!(mesh.cells[1].nodes(), [0, 1, 4, 3]);
    assert_eq!(mesh.points["origin"], [0]);
    let ends: Vec<[usize; 2]> = mesh.curves["base"].iter().map(|edge| edge.ends).collect();
    assert_eq!(ends, [[0, 1], [1, 2]]);
}

#[test]
fn an_element_that_stands_twice_is_one_cell_in_both_groups() {
    let mut extract = two_quads();
    extract.groups[3].blocks[0].tags = vec![9, 11];
    extract.groups[1].blocks[0] =
        block(1, "Line 2", 1, &[(2, &[0, 1]), (3, &[1, 2]), (4, &[1, 0])]);
    let mesh = extract.to_mesh(1.0).unwrap();
    assert_eq!(mesh.cells.len(), 2);
    assert_eq!(
        (&mesh.surfaces["left"][..], &mesh.surfaces["9"][..]),
        (&[0][..], &[0, 1][..])
    );
    assert_eq!(mesh.cell_numbers, [7, 9]);
    assert_eq!(mesh.curves["base"].len(), 2);
}

#[test]
fn a_group_that_nobody_names_may_be_anything() {
    let mut extract = two_quads();
    extract
        .nodes
        .extend([[0., 0., 1.], [1., 0., 1.], [1., 1., 1.]]);
    let solid = block(4, "Tetrahedron 4", 1, &[(20, &[0, 1, 4, 6])]);
    let face = block(2, "Triangle 3", 1, &[(21, &[6, 7, 8])]);
    extract.groups.push(group(2, 30, "face", vec![face]));
    extract.groups.push(group(3, 31, "solid", vec![solid]));
    let mesh = extract.to_mesh_of(1.0, &|label| label == "left").unwrap();
    assert_eq!(mesh.surfaces.keys().collect::<Vec<_>>(), ["9", "left"]);
    let is_face = |label: &str| label == "face";
    let error = extract.to_mesh_of(1.0, &is_face).unwrap_err();
    assert!(
        matches!(error, ExtractError::OffPlane { count: 3, .. }),
        "{error}"
    );
    assert!(extract.to_mesh(1.0).is_err());
}

#[test]
fn lengths_are_scaled_to_metres() {
    let mesh = two_quads().to_mesh(0.001).unwrap();
    assert_eq!(mesh.nodes[5], [0.002, 0.001]);
    for unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = two_quads().to_mesh(unit).unwrap_err();
        assert!(matches!(error, ExtractError::Unit { .. }), "{unit}");
    }
}

#[test]
fn clockwise_cells_are_turned_over() {
    let mut extract = eight_node_quad();
    extract.groups[0].blocks[0].nodes = vec![0, 3, 2, 1, 7, 6, 5, 4];
    let mesh = extract.to_mesh(1.0).unwrap();
    assert_eq!(mesh.cells[0].nodes(), [0, 1, 2, 3, 4, 5, 6, 7]);

    let mut extract = two_quads();
    let triangle = block(2, "Triangle 3", 1, &[(1, &[0, 3, 1])]);
    extract.groups[2].blocks = vec![triangle];
    extract.groups.truncate(3);
    assert_eq!(extract.to_mesh(1.0).unwrap().cells[0].nodes(), [0, 1, 3]);
}

#[test]
fn middle_nodes_are_snapped_only_within_the_tolerance() {
    let mut extract = eight_node_quad();
    extract.nodes[4] = [1.0 + 3e-12, -2e-12, 0.0];
    extract.nodes[5] = [2.0 + 5e-12, 1.0, 0.0];
    let mesh = extract.to_mesh(0.5).unwrap();
    assert_eq!(mesh.nodes[4], [0.5, 0.0]);
    assert_eq!(mesh.nodes[5], [1.0 + 2.5e-12, 0.5]);
}

#[test]
fn a_curve_outside_all_cells_keeps_its_nodes_and_is_snapped() {
    let mut extract = eight_node_quad();
    extract
        .nodes
        .extend([[0.5, 1.0, 0.0], [1.5, 1.0, 0.0], [1.0 + 1e-13, 1.0, 0.0]]);
    let line = block(8, "Line 3", 2, &[(2, &[8, 9, 10])]);
    extract.groups.insert(0, group(1, 1, "crack", vec![line]));
    let mesh = extract.to_mesh(1.0).unwrap();
    assert_eq!(mesh.curves["crack"][0].middle, Some(10));
    assert_eq!(mesh.nodes[10], [1.0, 1.0]);
}

#[test]
fn missing_surface_lists_what_is_there() {
    let mut extract = two_quads();
    extract.groups.truncate(2);
    let message = extract.to_mesh(1.0).unwrap_err().to_string();
    for part in [
        "2 plain",
        "point 'origin'",
        "curve 'base'",
        "Physical Surface(",
    ] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn empty_mesh_is_an_error() {
    let mut extract = two_quads();
    extract.groups[2].blocks.clear();
    extract.groups[3].blocks.clear();
    let surfaces = vec!["left".to_owned(), "9".to_owned()];
    let error = extract.to_mesh(1.0).unwrap_err();
    assert_eq!(error, ExtractError::NoElements { surfaces });
}

#[test]
fn wrong_elements_are_named_with_the_remedy() {
    let nine: &[usize] = &[0; 9];
    let cases = [
        (
            2,
            block(10, "Quadrilateral 9", 2, &[(1, nine)]),
            "SecondOrderIncomplete = 1",
        ),
        (
            2,
            block(21, "Triangle 10", 3, &[(1, &[0; 10])]),
            "Mesh.ElementOrder = 2",
        ),
        (
            1,
            block(26, "Line 4", 3, &[(1, &[0; 4])]),
            "Mesh.ElementOrder = 2",
        ),
        (
            3,
            block(4, "Tetrahedron 4", 1, &[(1, &[0; 4])]),
            "two-dimensional",
        ),
    ];
    for (dimension, block, remedy) in cases {
        let name = block.kind_name.clone();
        let mut extract = two_quads();
        extract
            .groups
            .push(group(dimension, 20, "odd", vec![block]));
        let message = extract.to_mesh(1.0).unwrap_err().to_string();
        for part in [name.as_str(), "'odd'", remedy] {
            assert!(message.contains(part), "{message}");
        }
    }
}

#[test]
fn nodes_off_the_plane_are_an_error() {
    let mut extract = two_quads();
    extract.nodes[3][2] = -0.5;
    let expected = ExtractError::OffPlane {
        count: 1,
        total: 6,
        farthest: -0.5,
    };
    assert_eq!(extract.to_mesh(1.0).unwrap_err(), expected);
    extract.nodes[3][2] = 1e-12;
    assert!(extract.to_mesh(1.0).is_ok());
}

#[test]
fn cells_without_area_are_an_error() {
    let mut extract = two_quads();
    for node in [3, 4, 5] {
        extract.nodes[node][1] = 0.0;
    }
    let error = extract.to_mesh(1.0).unwrap_err();
    assert!(
        matches!(error, ExtractError::Degenerate { tag: 7, .. }),
        "{error}"
    );
}

use super::*;
use crate::output::colour::WHITE;

/// Cells of 0.1 m for x < 1 m and points of 0.1 m beyond, 2 m × 1 m in all.
fn picture() -> MeshPicture {
    let places =
        (0..10).flat_map(|i| (0..10).map(move |j| [i, j].map(|k| (f64::from(k) + 0.5) / 10.0)));
    let region = |name: &str, filling| Region {
        name: name.to_owned(),
        model: "a model".to_owned(),
        filling,
        count: 100,
    };
    MeshPicture {
        title: "mesh".to_owned(),
        regions: vec![
            region("grip", Filling::Cells),
            region("band", Filling::Points),
        ],
        cells: places
            .clone()
            .map(|centre| Patch {
                outline: square(centre, [0.1, 0.0]).to_vec(),
                region: 0,
            })
            .collect(),
        points: places
            .map(|[x, y]| Dot {
                centre: [x + 1.0, y],
                side: [0.1, 0.0],
                is_whole: true,
                region: 1,
            })
            .collect(),
        pieces: Vec::new(),
        neighbours: Vec::new(),
        interfaces: vec![vec![[1.0, 0.0], [1.0, 1.0]]],
        cracks: vec![vec![[1.5, 0.0], [1.5, 0.5]]],
    }
}

#[test]
fn everything_has_its_colour_at_its_place() {
    let drawn = picture().draw().expect("a mesh");
    assert_eq!(drawn.colour_at([0.05, 0.05]), cell_fill(0));
    assert_eq!(drawn.colour_at([0.95, 0.95]), cell_fill(0));
    assert_eq!(drawn.colour_at([0.30, 0.55]), CELL_EDGE);
    assert_eq!(drawn.colour_at([1.05, 0.05]), point_fill(0));
    assert_eq!(
        drawn.colour_at([1.09, 0.09]),
        tint(point_fill(0), LIGHT_TINT)
    );
    assert_eq!(drawn.colour_at([1.0, 0.55]), INTERFACE);
    assert_eq!(drawn.colour_at([1.5, 0.25]), INK);
    for outside in [[-0.01, 0.5], [2.01, 0.5], [1.0, -0.01], [1.0, 1.01]] {
        assert_eq!(drawn.colour_at(outside), WHITE);
    }
}

#[test]
fn the_legend_shows_every_sign_and_some_text() {
    let drawn = picture().draw().expect("a mesh");
    let [width, height] = drawn.size();
    // Four keys in two rows.
    let legend = (height - (GAP + 2 * legend::ROW) as u32)..height;
    let pixels: Vec<Rgb> = legend
        .flat_map(|row| (0..width).map(move |column| [column, row]))
        .map(|[column, row]| drawn.pixel(column, row))
        .collect();
    let count = |colour: Rgb| pixels.iter().filter(|&&pixel| pixel == colour).count();
    assert!(count(cell_fill(0)) > 400);
    assert!(count(point_fill(0)) > 100);
    assert!(count(INTERFACE) > 50);
    assert!(count(INK) > 300);
    assert!(pixels.len() - count(WHITE) > 3_000);
}

#[test]
fn a_long_name_is_cut_and_not_what_follows_it() {
    let mut picture = picture();
    picture.regions[0].name = "grain ".repeat(60);
    for Key { text, .. } in picture.keys(900) {
        assert!(text_width(&text) < 900, "{text}");
    }
    assert!(picture.keys(900)[0].text.ends_with("…: a model, 100 cells"));
}

/// A row of regions in one picture: its legend has a dozen lines, and no two in a row look alike.
#[test]
fn many_regions_share_a_short_legend() {
    let region = |k: usize| Region {
        name: format!("grain {k}"),
        model: "a model".to_owned(),
        filling: Filling::Points,
        count: 1,
    };
    let dot = |region: usize| Dot {
        centre: [region as f64, 0.0],
        side: [1.0, 0.0],
        is_whole: true,
        region,
    };
    let picture = MeshPicture {
        regions: (0..68).map(region).collect(),
        neighbours: (1..68).map(|k| [k - 1, k]).collect(),
        points: (0..68).map(dot).collect(),
        interfaces: vec![vec![[0.0, 0.0], [1.0, 0.0]]],
        ..MeshPicture::default()
    };
    let keys = picture.keys(1000);
    assert_eq!(keys.len(), MOST_KEYS);
    assert_eq!(keys[10].text, "and 58 more");
    let drawn = picture.draw().expect("a mesh");
    for k in 1..68 {
        let [a, b] = [k - 1, k].map(|k| drawn.colour_at([f64::from(k), 0.2]));
        assert_ne!(a, b, "{k}");
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let refused = |picture: &MeshPicture| picture.draw().expect_err("must be refused");
    assert!(matches!(
        refused(&MeshPicture::default()),
        PictureError::Empty
    ));
    let mut broken = picture();
    broken.points[7].centre[1] = f64::NAN;
    assert!(matches!(refused(&broken), PictureError::NotFinite { .. }));
    let mut broken = picture();
    broken.cells[3].region = 2;
    let error = refused(&broken).to_string();
    assert_eq!(error, "region 2 is drawn, but only 2 are described");
}

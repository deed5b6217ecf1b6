use super::super::colour_bar::BAR_WIDTH;
use super::super::facets;
use super::*;
use crate::mesh::CellKind;
use crate::output::colour::{Rgb, WHITE, viridis};
use crate::peridynamics::axes::Axes;

/// The value x over 2 m × 1 m: cells for x < 1 m, points beyond.
fn ramp() -> FieldPicture {
    let cell = |[i, j]: [f64; 2]| {
        facets(CellKind::Quad8, 4, move |[r, s]| {
            let position = [(i + (r + 1.0) / 2.0) / 10.0, (j + (s + 1.0) / 2.0) / 10.0];
            (position, position[0])
        })
    };
    let places =
        |count: i32| (0..count).flat_map(move |i| (0..count).map(move |j| [i, j].map(f64::from)));
    let point = |[i, j]: [f64; 2]| {
        let centre = [1.0 + (i + 0.5) / 100.0, (j + 0.5) / 100.0];
        Square {
            centre,
            side: [0.01, 0.0],
            value: centre[0],
        }
    };
    FieldPicture {
        title: "ramp".to_owned(),
        quantity: "u_x".to_owned(),
        unit: "m".to_owned(),
        facets: places(10).flat_map(cell).collect(),
        squares: places(100).map(point).collect(),
        ..FieldPicture::default()
    }
}

#[track_caller]
fn assert_close(found: Rgb, expected: Rgb) {
    let apart = |k: usize| (i32::from(found[k]) - i32::from(expected[k])).abs();
    assert!((0..3).all(|k| apart(k) <= 3), "{found:?} for {expected:?}");
}

#[test]
fn every_place_has_the_colour_of_its_value() {
    let picture = ramp().draw().expect("a field");
    for x in [0.105, 0.355, 0.5, 0.995, 1.005, 1.255, 1.705] {
        for y in [0.105, 0.5, 0.995] {
            assert_close(picture.colour_at([x, y]), viridis(x / 1.995));
        }
    }
}

#[test]
fn no_seam_shows() {
    let picture = ramp().draw().expect("a field");
    for row in 1..500 {
        let y = f64::from(row) / 500.0;
        for column in 5..1_990 {
            let x = f64::from(column) / 1_000.0;
            let found = picture.colour_at([x, y]);
            let brighter = found.iter().zip(viridis(x / 1.995));
            let apart = brighter.map(|(&a, b)| (i32::from(a) - i32::from(b)).abs());
            assert!(apart.max() <= Some(8), "{found:?} at {x}, {y}");
        }
    }
}

#[test]
fn a_turned_lattice_is_filled_without_gaps() {
    let axes = Axes::new(0.5);
    let point = |[i, j]: [i32; 2]| Square {
        centre: axes.global([i, j].map(|k| (f64::from(k) + 0.5) / 20.0)),
        side: axes.global([1.0 / 20.0, 0.0]),
        value: f64::from(i),
    };
    let places = (0..20).flat_map(|i| (0..20).map(move |j| [i, j]));
    let picture = FieldPicture {
        title: "turned".to_owned(),
        squares: places.map(point).collect(),
        ..FieldPicture::default()
    };
    let picture = picture.draw().expect("a square of points");
    for row in 0..=200 {
        for column in 0..=200 {
            let at = [column, row].map(|k| f64::from(k) / 200.0 * 0.996 + 0.002);
            let found = picture.colour_at(axes.global(at));
            // Pixels on a side show both columns; white would be brighter than either.
            let columns = [at[0] - 0.004, at[0] + 0.004].map(|x| (x * 20.0).floor());
            let [a, b] = columns.map(|i| viridis(i.clamp(0.0, 19.0) / 19.0));
            for k in 0..3 {
                let between = a[k].min(b[k]).saturating_sub(1)..=a[k].max(b[k]).saturating_add(1);
                assert!(
                    between.contains(&found[k]),
                    "{found:?} at {at:?}, not {a:?} to {b:?}"
                );
            }
        }
    }
}

#[test]
fn both_directions_have_one_scale() {
    let mut picture = ramp();
    picture.facets.clear();
    let picture = picture.draw().expect("a square of points");
    let frame = &picture.frame;
    let [left, bottom] = frame.to_page([1.0, 0.0]);
    let [right, top] = frame.to_page([2.0, 1.0]);
    assert!((right - left - (bottom - top)).abs() < 1e-9);
    assert_eq!(picture.colour_at([0.99, 0.5]), WHITE);
    assert_eq!(picture.colour_at([1.5, 1.01]), WHITE);
}

#[test]
fn the_bar_runs_from_the_lowest_to_the_highest_colour() {
    let picture = ramp().draw().expect("a field");
    let [_, top, right, bottom] = picture.frame.plot;
    let column = (right + 2 * GAP + BAR_WIDTH / 2) as u32;
    assert_close(picture.pixel(column, top as u32 + 1), viridis(1.0));
    assert_close(picture.pixel(column, bottom as u32 - 2), viridis(0.0));
    let middle = (top + bottom) as u32 / 2;
    assert_close(picture.pixel(column, middle), viridis(0.5));
    let beside = (column + BAR_WIDTH as u32)..picture.size()[0];
    let has_ink =
        |column: u32| (top as u32..bottom as u32).any(|row| picture.pixel(column, row) == INK);
    assert!(beside.into_iter().any(has_ink));
}

#[test]
fn a_given_range_is_the_same_in_every_picture() {
    let mut picture = ramp();
    picture.range = Some([0.0, 10.0]);
    let drawn = picture.draw().expect("a field");
    for x in [0.355, 1.705] {
        assert_close(drawn.colour_at([x, 0.495]), viridis(x / 10.0));
    }
    // The note still tells the field's own range.
    let own = ColourScale::of(picture.values());
    let bar = ColourBar::new(ColourScale::of([0.0, 10.0].into_iter()), "m");
    assert_eq!(picture.note(&own, &bar), "min 0 m,  max 1.995 m");
}

/// A peak at one point leaves the others one colour, unless percentiles cut it off.
#[test]
fn percentiles_cut_a_peak_off() {
    let mut picture = ramp();
    picture.squares[9_999].value = 1e3;
    let spread = |picture: &FieldPicture| {
        let drawn = picture.draw().expect("a field");
        let [low, high] = [0.105, 1.855].map(|x| drawn.colour_at([x, 0.495]));
        (0..3).map(|k| low[k].abs_diff(high[k])).max()
    };
    assert!(spread(&picture) < Some(5));
    picture.percentiles = Some([0.0, 99.9]);
    assert!(spread(&picture) > Some(100));
    assert_eq!(
        percentiles((0..=100).map(f64::from), [1.0, 95.0]),
        [1.0, 95.0]
    );
}

#[test]
fn a_constant_field_is_one_colour_and_says_so() {
    let mut picture = ramp();
    picture.facets.clear();
    picture.squares.iter_mut().for_each(|s| s.value = -2.5e6);
    picture.unit = "Pa".to_owned();
    let bar = ColourBar::new(ColourScale::of(picture.values()), &picture.unit);
    assert_eq!(picture.note(&bar.scale, &bar), "constant −2.500 MPa");
    assert_eq!(bar.ticks(300), [(-2.5e6, "−2.500".to_owned())]);
    let drawn = picture.draw().expect("a field");
    assert_close(drawn.colour_at([1.5, 0.5]), viridis(0.5));
}

#[test]
fn the_range_and_the_exaggeration_are_told() {
    let mut picture = ramp();
    picture.deformation_scale = Some(20.0);
    let bar = ColourBar::new(ColourScale::of(picture.values()), &picture.unit);
    let note = picture.note(&bar.scale, &bar);
    assert_eq!(note, "min 0 m,  max 1.995 m,  u × 20");
}

#[test]
fn the_exaggeration_is_round() {
    let of = |largest: f64| deformation_scale(1.0, [[0.0, largest], [0.0, 0.0]].into_iter());
    assert_eq!(of(1e-3), Some(50.0));
    assert_eq!(of(1.3e-3), Some(20.0));
    assert_eq!(of(0.0), None);
    assert_eq!(of(f64::NAN), None);
}

#[test]
fn a_value_that_is_not_finite_is_refused() {
    let mut picture = ramp();
    picture.squares[5].value = f64::INFINITY;
    let error = picture.draw().expect_err("must be refused");
    assert_eq!(
        error.to_string(),
        "a position or value of the picture is inf"
    );
}

use super::*;
use crate::output::colour::{GRID, INK, ZERO, curve as colour_of};

fn axis(name: &str, unit: &str) -> Axis {
    Axis {
        name: name.to_owned(),
        unit: unit.to_owned(),
        ..Axis::default()
    }
}

fn mark(at: [f64; 2], label: &str) -> Mark {
    Mark {
        at,
        label: label.to_owned(),
    }
}

fn chart(curves: Vec<Curve>) -> Chart {
    Chart {
        title: "three-point bending".to_owned(),
        x: axis("grip displacement", "m"),
        y: axis("reaction", "N"),
        curves,
    }
}

fn curve(name: &str, points: Vec<[f64; 2]>, marks: Vec<Mark>) -> Curve {
    Curve {
        name: name.to_owned(),
        points,
        dots: Vec::new(),
        marks,
    }
}

/// Up to 800 N at 0.2 mm, straight down to 100 N, on to 0.4 mm.
fn rise_and_drop() -> Chart {
    let points = vec![[0.0, 0.0], [2e-4, 800.0], [2e-4, 100.0], [4e-4, 0.0]];
    let marks = vec![
        mark([2e-4, 800.0], "first bond, step 45"),
        mark([4e-4, 0.0], "separated, step 92"),
    ];
    chart(vec![curve("run", points, marks)])
}

/// Whether a pixel within the neighbours of a point has the colour.
fn shows(picture: &Picture, at: [f64; 2], colour: Rgb) -> bool {
    let [x, y] = picture.frame.to_page(at).map(|p| p as i32);
    let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [x + i, y + j]));
    around
        .into_iter()
        .any(|[x, y]| picture.pixel(x as u32, y as u32) == colour)
}

fn count(picture: &Picture, [l, t, r, b]: [i32; 4], colour: Rgb) -> usize {
    let pixels = (t..b).flat_map(|y| (l..r).map(move |x| [x as u32, y as u32]));
    pixels
        .filter(|&[x, y]| picture.pixel(x, y) == colour)
        .count()
}

#[test]
fn a_curve_passes_through_its_points_and_nowhere_else() {
    let mut chart = rise_and_drop();
    chart.curves[0].marks.clear();
    let picture = chart.draw().expect("a chart");
    for on in [
        [0.0, 0.0],
        [5e-5, 200.0],
        [1e-4, 400.0],
        [2e-4, 450.0],
        [3e-4, 50.0],
    ] {
        assert!(shows(&picture, on, colour_of(0)), "{on:?}");
    }
    for off in [
        [5e-5, 250.0],
        [2.1e-4, 450.0],
        [3e-4, 80.0],
        [3.9e-4, 790.0],
    ] {
        assert!(!shows(&picture, off, colour_of(0)), "{off:?}");
    }
}

#[test]
fn the_page_is_filled_in_both_directions() {
    let picture = rise_and_drop().draw().expect("a chart");
    assert_eq!(picture.size(), [1200, 780]);
    let frame = &picture.frame;
    let [left, bottom] = frame.to_plot([0.0, 0.0]);
    let [right, top] = frame.to_plot([4e-4, 800.0]);
    assert!((right - left) / f64::from(frame.plot_width()) > 0.9);
    assert!((bottom - top) / f64::from(frame.plot_height()) > 0.9);
}

#[test]
fn a_curve_that_turns_back_is_drawn_as_it_runs() {
    let points = vec![[0.0, 0.0], [3e-3, 900.0], [1e-3, 100.0], [3e-3, 50.0]];
    let picture = chart(vec![curve("snap-back", points, vec![])]).draw();
    let picture = picture.expect("a chart");
    for on in [[1.5e-3, 450.0], [2e-3, 500.0], [2e-3, 75.0]] {
        assert!(shows(&picture, on, colour_of(0)), "{on:?}");
    }
}

#[test]
fn the_line_is_four_pixels_wide() {
    let points = vec![[0.0, 500.0], [1.0, 500.0]];
    let picture = chart(vec![curve("constant", points, vec![])]).draw();
    let picture = picture.expect("a chart");
    let [x, y] = picture.frame.to_page([0.47, 500.0]).map(|p| p as i32);
    let covered: f64 = (y - 5..y + 5)
        .map(|row| picture.pixel(x as u32, row as u32)[0])
        .map(|red| (255.0 - f64::from(red)) / 255.0)
        .sum();
    // A grid line lies below the curve and shows where the curve's edge is soft.
    assert!((covered - 4.0).abs() < 0.5, "{covered}");
}

#[test]
fn zero_is_on_both_axes() {
    for sign in [1.0, -1.0] {
        let points = vec![[sign * 2.0, sign * 7e3], [sign * 3.0, sign * 8e3]];
        let picture = chart(vec![curve("far", points, vec![])]).draw();
        let picture = picture.expect("a chart");
        let [x, y] = picture.frame.to_plot([0.0, 0.0]);
        assert!((0.0..f64::from(picture.frame.plot_width())).contains(&x));
        assert!((0.0..f64::from(picture.frame.plot_height())).contains(&y));
        for zero in [[0.0, sign * 5e3], [sign * 0.7, 0.0]] {
            assert!(shows(&picture, zero, ZERO), "{zero:?}");
        }
    }
}

/// The axis of values that differ by a hundredth shows the hundredth.
#[test]
fn a_cropped_axis_shows_a_percent() {
    let points = vec![[10.0, 100.0], [20.0, 101.0]];
    let mut chart = chart(vec![curve("peak", points, vec![])]);
    let height = |chart: &Chart| {
        let frame = chart.frame().expect("a finite range");
        let [low, high] = [100.0, 101.0].map(|y| frame.to_plot([0.0, y])[1]);
        (low - high) / f64::from(frame.plot_height())
    };
    assert!(height(&chart) < 0.02);
    chart.y.is_cropped = true;
    assert!(height(&chart) > 0.8, "{}", height(&chart));
    // One value alone has no range to be cropped to.
    chart.curves[0].points[1][1] = 100.0;
    let frame = chart.frame().expect("a finite range");
    assert!(frame.to_plot([0.0, 0.0])[1] < f64::from(frame.plot_height()));
}

#[test]
fn a_unit_that_is_kept_gets_no_prefix() {
    let mut chart = chart(vec![curve("run", vec![[0.0, 0.0], [0.004, 1.0]], vec![])]);
    chart.x.unit = "mm".to_owned();
    chart.x.keeps_unit = true;
    let frame = chart.frame().expect("a finite range");
    assert_eq!(frame.axes[0].unit.label("crack"), "crack [mm]");
}

#[test]
fn a_grid_line_leads_to_the_middle_of_each_tick() {
    let picture = rise_and_drop().draw().expect("a chart");
    let frame = &picture.frame;
    let [left, top, right, bottom] = frame.plot;
    let found = |near: [i32; 2], axis: usize, colour: Rgb| -> Vec<i32> {
        let along = (-6..=6).map(|step| near[axis] + step);
        let is_there = |&along: &i32| {
            let mut pixel = near;
            pixel[axis] = along;
            picture.pixel(pixel[0] as u32, pixel[1] as u32) == colour
        };
        along.filter(is_there).collect()
    };
    for value in [1e-4, 3e-4] {
        let x = frame.to_page([value, 0.0])[0] as i32;
        let tick = found([x, bottom + 4], 0, INK);
        assert_eq!(found([x, top + 3], 0, GRID), tick[1..2]);
    }
    for value in [200.0, 600.0] {
        let y = frame.to_page([0.0, value])[1] as i32;
        let tick = found([left - 4, y], 1, INK);
        assert_eq!(found([right - 3, y], 1, GRID), tick[1..2]);
    }
}

#[test]
fn each_axis_has_the_prefix_of_its_values() {
    let labels = |x: f64, y: f64| {
        let chart = chart(vec![curve("run", vec![[0.0, 0.0], [x, y]], vec![])]);
        let frame = chart.frame().expect("a finite range");
        frame.axes.map(|axis| axis.unit.label(&axis.name))
    };
    assert_eq!(
        labels(4e-4, 800.0),
        ["grip displacement [µm]", "reaction [N]"]
    );
    assert_eq!(
        labels(-2e-3, 1.2e4),
        ["grip displacement [mm]", "reaction [kN]"]
    );
    assert_eq!(
        labels(0.0, -3e7),
        ["grip displacement [m]", "reaction [MN]"]
    );
}

#[test]
fn a_mark_is_a_disc_with_its_text_beside() {
    let picture = rise_and_drop().draw().expect("a chart");
    let [left, top, ..] = picture.frame.plot;
    let chart = rise_and_drop();
    let paths = vec![path(&chart.curves[0], &picture.frame)];
    let labels = chart.labels(&picture.frame, &paths);
    assert_eq!(labels.len(), 2);
    for label in labels {
        let [x, y] = label.at.map(|p| p as i32);
        let disc = [x - 4, y - 4, x + 5, y + 5].map(|p| p + left);
        let disc = [disc[0], disc[1] - left + top, disc[2], disc[3] - left + top];
        assert_eq!(count(&picture, disc, colour_of(0)), 81);
        let [l, t, r, b] = label.place;
        let text = [l + left, t + top, r + left, b + top];
        assert!(count(&picture, text, INK) > 100, "{}", label.text);
        // A corner of the text's box may touch a line: half of a curve's width, squared.
        let corner = (0.5 * CURVE_WIDTH).powi(2) as usize;
        for other in [colour_of(0), GRID, ZERO] {
            let covered = count(&picture, text, other);
            assert!(covered <= corner, "{}: {covered} pixels", label.text);
        }
    }
}

#[test]
fn several_curves_have_their_colours_and_a_legend() {
    let line = |slope: f64| vec![[0.0, 0.0], [1.0, slope]];
    let curves: Vec<Curve> = (0..3)
        .map(|k| curve("run", line(1.0 + f64::from(k)), vec![]))
        .collect();
    let one = chart(curves[..1].to_vec()).draw().expect("a chart");
    let picture = chart(curves).draw().expect("a chart");
    assert_eq!(picture.size()[1], one.size()[1] + legend::ROW as u32);
    let [width, height] = picture.size().map(|length| length as i32);
    for k in 0..3 {
        assert!(shows(&picture, [0.6, 0.6 * (1.0 + k as f64)], colour_of(k)));
        let legend = [0, height - GAP - legend::ROW, width, height];
        assert!(count(&picture, legend, colour_of(k)) > 100);
    }
}

#[test]
fn a_single_point_shows() {
    let picture = chart(vec![curve("start", vec![[1e-3, 20.0]; 3], vec![])]).draw();
    let picture = picture.expect("a chart");
    let [x, y] = picture.frame.to_page([1e-3, 20.0]).map(|p| p as i32);
    let around = [x - 4, y - 4, x + 5, y + 5];
    assert_eq!(count(&picture, around, colour_of(0)), 81);
    let origin = chart(vec![curve("start", vec![[0.0, 0.0]], vec![])]).draw();
    assert!(shows(&origin.expect("a chart"), [0.0, 0.0], colour_of(0)));
}

#[test]
fn any_magnitude_can_be_drawn() {
    for magnitude in [1e-299, 1e-21, 1e-7, 1e9, 1e40, 1e300] {
        let points = vec![[0.0, 0.0], [magnitude, magnitude], [2.0 * magnitude, 0.0]];
        let picture = chart(vec![curve("run", points, vec![])]).draw();
        let picture = picture.expect("a chart");
        for x in [0.4, 1.0, 1.6] {
            let on = [x * magnitude, (1.0 - (x - 1.0_f64).abs()) * magnitude];
            assert!(shows(&picture, on, colour_of(0)), "{x} × {magnitude}");
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let refused = |chart: Chart| chart.draw().expect_err("must be refused");
    assert!(matches!(refused(chart(vec![])), PictureError::Empty));
    let empty = chart(vec![Curve::default(), Curve::default()]);
    assert!(matches!(refused(empty), PictureError::Empty));
    for value in [f64::NAN, f64::INFINITY] {
        let mut broken = rise_and_drop();
        broken.curves[0].points[2][0] = value;
        assert!(matches!(refused(broken), PictureError::NotFinite { .. }));
        let mut broken = rise_and_drop();
        broken.curves[0].marks[1].at[1] = value;
        assert!(matches!(refused(broken), PictureError::NotFinite { .. }));
    }
    let endless = chart(vec![curve(
        "run",
        vec![[-1.7e308, 0.0], [1.7e308, 0.0]],
        vec![],
    )]);
    assert!(matches!(refused(endless), PictureError::NotFinite { .. }));
}

#[test]
fn a_text_too_long_is_shortened() {
    let long = "a label of many words ".repeat(20);
    let short = shortened(&long, 300, text_width);
    assert!(short.ends_with('…') && text_width(&short) <= 300 && short.len() > 15);
    assert_eq!(shortened("short", 300, text_width), "short");
}

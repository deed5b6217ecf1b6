//! Places of the labels of a chart's marks: inside the plot, beside their mark, and over as little
//! of the curves, the marks and each other as possible.

/// Left, top, right, bottom [pixels of the plot], the last two not included.
pub(super) type Place = [i32; 4];

/// The line from a mark to its label [pixels of the plot].
pub(super) type Leader = [[f64; 2]; 2];

/// Distance from which on a line leads from a mark to its label [pixels].
const LEADER_FROM: f64 = 24.0;
/// How much worse than a line over a curve is a pixel of a text over it, and of a line through a
/// text.
const COVERED: u32 = 4;
const STRUCK: u32 = 20;
/// Free room around a label [pixels].
const CLEAR: i32 = 4;
/// Distances between a mark's centre and its label [pixels]: the nearest free place is taken.
const DISTANCES: [i32; 10] = [16, 26, 36, 48, 64, 84, 106, 132, 160, 200];
/// Distance of the places that are tried where no near one is free [pixels].
const GRID: i32 = 24;
/// Directions from a mark to its label, y downwards, the best first.
const DIRECTIONS: [[i32; 2]; 8] = [
    [1, 0],
    [-1, 0],
    [1, -1],
    [-1, -1],
    [1, 1],
    [-1, 1],
    [0, -1],
    [0, 1],
];

/// The parts of a plot that are covered by curves, marks and labels.
pub(super) struct Labels {
    size: [i32; 2],
    /// Radius of the marks [pixels].
    radius: f64,
    /// Number of covered pixels above and left of each corner of a pixel, row by row.
    covered: Vec<u32>,
    placed: Vec<Place>,
    leaders: Vec<Leader>,
}

impl Labels {
    /// Labels in a plot of `size` with `paths` and `discs` (centres and common radius) [pixels].
    pub fn among(
        size: [i32; 2],
        paths: &[Vec<[f64; 2]>],
        discs: &[[f64; 2]],
        radius: f64,
    ) -> Labels {
        let [width, height] = size.map(|length| length as usize);
        let mut covered = vec![0; (width + 1) * (height + 1)];
        let mut cover = |[x, y]: [f64; 2]| {
            let [column, row] = [x.floor(), y.floor()];
            if (0.0..width as f64).contains(&column) && (0.0..height as f64).contains(&row) {
                covered[(row as usize + 1) * (width + 1) + column as usize + 1] = 1;
            }
        };
        for path in paths {
            for pair in path.windows(2) {
                along([pair[0], pair[1]]).for_each(&mut cover);
            }
        }
        let reach = radius.ceil() as i32;
        for [x, y] in discs {
            for row in -reach..=reach {
                for column in -reach..=reach {
                    let [dx, dy] = [column, row].map(f64::from);
                    if dx.hypot(dy) <= radius {
                        cover([x + dx, y + dy]);
                    }
                }
            }
        }
        for row in 1..=height {
            let mut sum = 0;
            for column in 1..=width {
                let at = row * (width + 1) + column;
                sum += covered[at];
                covered[at] = sum + covered[at - width - 1];
            }
        }
        Labels {
            size,
            radius,
            covered,
            placed: Vec::new(),
            leaders: Vec::new(),
        }
    }

    /// Finds a place for a label of `size` whose mark lies at `mark` [pixels].
    pub fn place(&mut self, mark: [f64; 2], size: [i32; 2]) -> Place {
        let pixel = mark.map(|x| x.round() as i32);
        let places = DISTANCES.into_iter().flat_map(|distance| {
            DIRECTIONS.map(|direction| self.within(beside(pixel, distance, direction, size)))
        });
        // Of equal ones the first.
        let best = places.min_by_key(|&place| self.cost(place, mark));
        let mut place = best.unwrap_or([0, 0, size[0], size[1]]);
        if self.is_covered(place) {
            let elsewhere = self.free_places(size);
            place = elsewhere
                .into_iter()
                .min_by_key(|&other| self.cost(other, mark) + distance(other, mark))
                .unwrap_or(place);
        }
        self.placed.push(place);
        self.leaders.extend(leader(place, mark));
        place
    }

    /// Whether a curve, a mark or a label lies under a label at `place`.
    fn is_covered(&self, place: Place) -> bool {
        let crowded = grown(place);
        self.covered_within(crowded) > 0
            || self.placed.iter().any(|&other| overlap(crowded, other) > 0)
    }

    /// Places of `size` all over the plot under which there is nothing.
    fn free_places(&self, size: [i32; 2]) -> Vec<Place> {
        let [columns, rows] = [0, 1].map(|axis| (self.size[axis] - size[axis]) / GRID);
        let places = (0..rows.max(0)).flat_map(|row| {
            (0..columns.max(0)).map(move |column| {
                let [x, y] = [column, row].map(|k| CLEAR + k * GRID);
                [x, y, x + size[0], y + size[1]]
            })
        });
        places.filter(|&place| !self.is_covered(place)).collect()
    }

    /// `place` moved into the plot.
    fn within(&self, [left, top, right, bottom]: Place) -> Place {
        let moved = |low: i32, high: i32, length: i32| {
            low.min(length - CLEAR - (high - low)).max(CLEAR) - low
        };
        let [dx, dy] = [
            moved(left, right, self.size[0]),
            moved(top, bottom, self.size[1]),
        ];
        [left + dx, top + dy, right + dx, bottom + dy]
    }

    /// How many pixels a label at `place` and its leader would cover or crowd, weighted.
    fn cost(&self, place: Place, mark: [f64; 2]) -> u32 {
        let crowded = grown(place);
        let labels = self.placed.iter().map(|&other| overlap(crowded, other));
        let cost = COVERED * (self.covered_within(crowded) + labels.sum::<u32>());
        let through = self.leaders.iter().map(|&other| length_in(crowded, other));
        let struck = through.sum::<u32>();
        let Some(leader) = leader(place, mark) else {
            return cost + STRUCK * struck;
        };
        let others = self.placed.iter();
        let strikes = others.map(|&other| length_in(grown(other), leader));
        // The mark covers the line's begin.
        let is_off = |[x, y]: &[f64; 2]| (x - mark[0]).hypot(y - mark[1]) > self.radius + 1.0;
        let crossed = along(leader).filter(is_off).map(|at| {
            let [x, y] = at.map(|p| p.floor() as i32);
            self.covered_within([x - 1, y - 1, x + 2, y + 2]).min(1)
        });
        cost + STRUCK * (struck + strikes.sum::<u32>()) + crossed.sum::<u32>()
    }

    fn covered_within(&self, [left, top, right, bottom]: Place) -> u32 {
        let [width, height] = self.size;
        let before = |x: i32, y: i32| {
            let [column, row] = [x.clamp(0, width), y.clamp(0, height)];
            self.covered[(row * (width + 1) + column) as usize]
        };
        before(right, bottom) + before(left, top) - before(left, bottom) - before(right, top)
    }
}

/// The place at `distance` from a mark.
fn beside(mark: [i32; 2], distance: i32, direction: [i32; 2], size: [i32; 2]) -> Place {
    // At a corner, as far from the mark as at a side.
    let distance = if direction.contains(&0) {
        distance
    } else {
        distance * 7 / 10
    };
    let [left, top] = [0, 1].map(|axis| match direction[axis] {
        1 => mark[axis] + distance,
        -1 => mark[axis] - distance - size[axis],
        _ => mark[axis] - size[axis] / 2,
    });
    [left, top, left + size[0], top + size[1]]
}

/// Distance from a mark to a label [pixels].
fn distance(place: Place, mark: [f64; 2]) -> u32 {
    let apart = [0, 1].map(|k| {
        let [low, high] = [place[k], place[k + 2]].map(f64::from);
        mark[k] - mark[k].clamp(low, high)
    });
    apart[0].hypot(apart[1]) as u32
}

/// Common area [pixels].
fn overlap(a: Place, b: Place) -> u32 {
    let common = |axis: usize| (a[axis + 2].min(b[axis + 2]) - a[axis].max(b[axis])).max(0);
    (common(0) * common(1)) as u32
}

/// `place` with free room around.
fn grown([left, top, right, bottom]: Place) -> Place {
    [left - CLEAR, top - CLEAR, right + CLEAR, bottom + CLEAR]
}

/// Points on a segment with its ends, at most a pixel apart.
fn along([[x0, y0], [x1, y1]]: Leader) -> impl Iterator<Item = [f64; 2]> {
    let steps = (x1 - x0).hypot(y1 - y0).ceil().max(1.0) as usize;
    let shares = (0..=steps).map(move |step| step as f64 / steps as f64);
    shares.map(move |t| [x0 + t * (x1 - x0), y0 + t * (y1 - y0)])
}

/// Length of the segment's part in `place`, about [pixels].
fn length_in(place: Place, segment: Leader) -> u32 {
    let [left, top, right, bottom] = place.map(f64::from);
    let inside = |[x, y]: &[f64; 2]| (left..right).contains(x) && (top..bottom).contains(y);
    along(segment).filter(inside).count() as u32
}

/// The line from a mark to its label at `place` that stands apart.
pub(super) fn leader(place: Place, mark: [f64; 2]) -> Option<Leader> {
    let place = place.map(f64::from);
    let end = [0, 1].map(|axis| mark[axis].clamp(place[axis], place[axis + 2]));
    let is_apart = (end[0] - mark[0]).hypot(end[1] - mark[1]) > LEADER_FROM;
    is_apart.then_some([mark, end])
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLOT: [i32; 2] = [1000, 600];
    const LABEL: [i32; 2] = [200, 26];

    fn empty() -> Labels {
        Labels::among(PLOT, &[], &[], 0.0)
    }

    #[test]
    fn a_label_stands_at_the_right_of_its_mark_if_nothing_is_there() {
        let place = empty().place([300.0, 300.0], LABEL);
        assert_eq!(place, [316, 287, 516, 313]);
    }

    #[test]
    fn a_label_stays_in_the_plot() {
        for x in [0.0, 500.0, 1000.0] {
            for y in [0.0, 300.0, 600.0] {
                let [l, t, r, b] = empty().place([x, y], LABEL);
                assert!(l >= CLEAR && r <= PLOT[0] - CLEAR, "{l} {r}");
                assert!(t >= CLEAR && b <= PLOT[1] - CLEAR, "{t} {b}");
                assert_eq!([r - l, b - t], LABEL);
            }
        }
    }

    #[test]
    fn covered_pixels_are_counted() {
        let path = vec![[10.5, 20.5], [110.5, 20.5]];
        let labels = Labels::among(PLOT, &[path], &[], 0.0);
        assert_eq!(labels.covered_within([0, 0, 1000, 600]), 101);
        assert_eq!(labels.covered_within([50, 20, 60, 21]), 10);
        assert_eq!(labels.covered_within([50, 21, 60, 600]), 0);
        let labels = Labels::among(PLOT, &[], &[[500.5, 300.5]], 7.0);
        let area = labels.covered_within([490, 290, 511, 311]);
        assert!((140..170).contains(&area), "{area}");
    }

    #[test]
    fn a_label_avoids_curves_marks_and_other_labels() {
        let peak = vec![[0.0, 590.0], [500.0, 100.0], [520.0, 590.0]];
        let marks = [
            [500.0, 100.0],
            [250.0, 345.0],
            [510.0, 345.0],
            [512.0, 350.0],
        ];
        let mut labels = Labels::among(PLOT, &[peak], &marks, 7.0);
        for mark in marks {
            let place = labels.place(mark, LABEL);
            let others = labels.placed.iter().filter(|&&other| other != place);
            assert_eq!(others.map(|&other| overlap(place, other)).sum::<u32>(), 0);
            assert_eq!(labels.covered_within(place), 0, "{mark:?}");
        }
        assert_eq!(labels.placed.len(), 4);
    }

    /// Teeth on all sides of the mark, higher than labels are far.
    #[test]
    fn a_label_crosses_no_curve_where_the_plot_has_room() {
        let tooth = |k: usize| {
            let x = 300.0 + 20.0 * k as f64;
            vec![[x, 250.0], [x + 10.0, 550.0]]
        };
        let teeth: Vec<Vec<[f64; 2]>> = (0..30).map(tooth).collect();
        let mut labels = Labels::among(PLOT, &teeth, &[], 0.0);
        let place = labels.place([600.0, 500.0], LABEL);
        assert_eq!(labels.covered_within(grown(place)), 0, "{place:?}");
    }

    #[test]
    fn a_line_leads_to_a_label_that_stands_apart() {
        let place = [100, 100, 300, 126];
        assert_eq!(leader(place, [84.0, 110.0]), None);
        let lead = |mark| leader(place, mark).expect("a leader")[1];
        assert_eq!(lead([50.0, 110.0]), [100.0, 110.0]);
        assert_eq!(lead([350.0, 200.0]), [300.0, 126.0]);
    }

    #[test]
    fn no_line_leads_through_a_text() {
        let floor = vec![[0.0, 560.0], [1000.0, 560.0]];
        let marks = [815.0, 810.0, 805.0, 800.0, 795.0].map(|x| [x, 560.0]);
        let mut labels = Labels::among(PLOT, &[floor], &marks, 7.0);
        for mark in marks {
            labels.place(mark, LABEL);
        }
        assert!(labels.leaders.len() >= 2, "{:?}", labels.placed);
        for &place in &labels.placed {
            let lengths = labels.leaders.iter().map(|&line| length_in(place, line));
            // A line may end on the border of its own label.
            assert!(lengths.max() <= Some(1));
        }
    }
}

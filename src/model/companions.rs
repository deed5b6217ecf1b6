//! Cells of the lattices, and the short bonds with which they break ([`crate::peridynamics::cells`]).

use super::{Model, PointRegion};
use crate::assembly::Lists;
use crate::peridynamics::cells::{Cell, LONGEST_SIDE};
use std::collections::HashMap;

/// Midpoints within this distance of a side lie on it [dx].
const ON_SIDE: f64 = 1e-6;

/// The cells that break with each interaction; empty where no lattice has cells.
#[derive(Clone, Debug, Default)]
pub struct Companions {
    cells: Lists,
    /// How many interactions come before the cells, where there are any.
    count: usize,
}

impl Companions {
    /// The cells that break with an interaction.
    pub fn of(&self, interaction: usize) -> &[u32] {
        match interaction < self.count {
            true => self.cells.of(interaction),
            false => &[],
        }
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }
}

impl Model {
    /// Adds the cells of the lattices, lattice by lattice.
    pub(super) fn add_cells(&mut self, cells: &[Vec<Cell>]) {
        let mut squares: Vec<HashMap<[i64; 2], Vec<u32>>> = Vec::new();
        for (lattice, cells) in cells.iter().enumerate() {
            let mut of_square: HashMap<[i64; 2], Vec<u32>> = HashMap::new();
            for cell in cells {
                let added = self.add_cell(lattice, cell);
                for &square in &cell.squares {
                    of_square.entry(square).or_default().extend(added.clone());
                }
            }
            squares.push(of_square);
        }
        self.integrity.resize(self.interactions.len(), 1.0);
        if self.interactions.cells().is_empty() {
            return;
        }
        let count = self.interactions.axial().len();
        let mut pairs = Vec::new();
        for interaction in self.interactions.axial() {
            let Some(lattice) = self.lattice_of_short(interaction) else {
                continue;
            };
            for square in self.squares_at_middle(&self.points[lattice], interaction) {
                let cells = squares[lattice].get(&square).into_iter().flatten();
                pairs.extend(cells.map(|&cell| (interaction as u32, cell)));
            }
        }
        self.companions = Companions {
            cells: Lists::collect(count, || pairs.iter().copied()),
            count,
        };
    }

    /// Adds the functionals of a cell; returns their numbers.
    fn add_cell(&mut self, lattice: usize, cell: &Cell) -> std::ops::Range<u32> {
        let points = &self.points[lattice];
        let (axes, dx) = (points.axes, points.micromodulus.spacing);
        let mut moduli = [0.0; 2];
        for &(node, area) in &cell.shares {
            let of_material = self.material_of_point(node as usize);
            let own = of_material.on_lattice(self.settings.plane);
            moduli[0] += area * own.area;
            moduli[1] += area * own.deviator;
        }
        let [area, deviator] = moduli.map(|k| k * self.settings.thickness / (dx * dx));
        let gradient =
            |&(node, g): &(u32, [f64; 2])| (node, axes.global(g).map(|g| dx / cell.area * g));
        let gradient: Vec<(u32, [f64; 2])> = cell.terms.iter().map(gradient).collect();
        let first = self.interactions.len() as u32;
        let mut push = |w: fn([f64; 2]) -> [f64; 2], stiffness: f64| {
            if stiffness > 0.0 {
                let terms: Vec<_> = gradient.iter().map(|&(node, g)| (node, w(g))).collect();
                self.interactions.push_cell(&terms, dx, stiffness);
            }
        };
        push(|g| g, area);
        push(|[x, y]| [x, -y], deviator);
        push(|[x, y]| [y, x], deviator);
        first..self.interactions.len() as u32
    }

    /// The lattice of an interaction that is a side or a diagonal of a square, or a part of one.
    fn lattice_of_short(&self, interaction: usize) -> Option<usize> {
        let is_bond = self.interactions.bonds().contains(&interaction);
        let clipped = interaction.checked_sub(self.interactions.clipped_bonds().start);
        if !is_bond && clipped.is_none() {
            return None;
        }
        let mut nodes = self.interactions.nodes(interaction).iter();
        let lattice = nodes.find_map(|&node| {
            let is_in = |points: &PointRegion| points.nodes.contains(&(node as usize));
            self.points.iter().position(is_in)
        })?;
        let length = match clipped {
            Some(clipped) => *self.clipped_from.get(clipped)?,
            None => self.interactions.length(interaction, &self.positions),
        };
        let longest = LONGEST_SIDE * self.points[lattice].micromodulus.spacing;
        (length < longest).then_some(lattice)
    }

    /// The squares in which, or on whose sides, the middle of an interaction lies.
    fn squares_at_middle(&self, points: &PointRegion, interaction: usize) -> Vec<[i64; 2]> {
        let ends = self.interactions.segment(interaction, &self.positions);
        let [a, b] = ends.map(|x| points.index.coordinates(points.axes.local(x)));
        let range = |axis: usize| {
            let middle = 0.5 * (a[axis] + b[axis]);
            (middle - ON_SIDE).floor() as i64..=(middle + ON_SIDE).floor() as i64
        };
        range(1)
            .flat_map(|j| range(0).map(move |i| [i, j]))
            .collect()
    }

    /// The cells that go where these interactions break, ascending, each once, none that has gone already.
    pub fn cells_with(&self, broken: &[usize], is_intact: impl Fn(usize) -> bool) -> Vec<usize> {
        if self.companions.is_empty() {
            return Vec::new();
        }
        let cells = broken.iter().flat_map(|&s| self.companions.of(s));
        let mut cells: Vec<usize> = cells.map(|&cell| cell as usize).collect();
        cells.sort_unstable();
        cells.dedup();
        cells.retain(|&cell| is_intact(cell));
        cells
    }
}

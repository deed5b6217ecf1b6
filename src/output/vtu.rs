//! VTK's XML format for unstructured grids (`.vtu`), binary and zlib-compressed.
//!
//! A [`Part`] is one grid: the finite-element region, the material points, or the bonds. Positions
//! and vectors get a third component, 0. No NaN and no infinity reaches a file: ParaView
//! would draw nothing and not tell why.

mod check;
mod xml;

use super::field::Field;
use super::packed::LEVEL;
use super::write_whole;
use crate::mesh::CellKind;
use std::path::Path;
use vtkio::model::{
    Attributes, ByteOrder, CellType, Cells, DataSet, UnstructuredGridPiece, Version, VertexNumbers,
    Vtk,
};
use vtkio::xml::Compressor;
use xml::{completed, in_space};

pub use check::{On, VtuError};

/// The kind of a cell of a [`Part`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartCell {
    Surface(CellKind),
    Vertex,
    Line,
}

impl PartCell {
    pub fn node_count(self) -> usize {
        match self {
            PartCell::Surface(kind) => kind.node_count(),
            PartCell::Vertex => 1,
            PartCell::Line => 2,
        }
    }

    fn vtk_type(self) -> CellType {
        match self {
            PartCell::Surface(CellKind::Tri3) => CellType::Triangle,
            PartCell::Surface(CellKind::Tri6) => CellType::QuadraticTriangle,
            PartCell::Surface(CellKind::Quad4) => CellType::Quad,
            PartCell::Surface(CellKind::Quad8) => CellType::QuadraticQuad,
            PartCell::Vertex => CellType::Vertex,
            PartCell::Line => CellType::Line,
        }
    }
}

/// One unstructured grid with its fields.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Positions [m].
    pub points: Vec<[f64; 2]>,
    cells: Vec<PartCell>,
    /// Nodes of all cells, one cell after the other.
    connectivity: Vec<u64>,
    /// End of each cell's nodes in `connectivity`.
    offsets: Vec<u64>,
    pub point_data: Vec<Field>,
    pub cell_data: Vec<Field>,
}

impl Part {
    /// Points without cells; see [`Part::push_cell`].
    pub fn new(points: Vec<[f64; 2]>) -> Part {
        Part {
            points,
            ..Part::default()
        }
    }

    /// Every point a vertex cell: material points.
    pub fn of_vertices(points: Vec<[f64; 2]>) -> Part {
        let mut part = Part::new(points);
        for point in 0..part.points.len() {
            part.push_cell(PartCell::Vertex, &[point]);
        }
        part
    }

    /// Every pair a line cell: bonds.
    pub fn of_lines(points: Vec<[f64; 2]>, pairs: &[[usize; 2]]) -> Part {
        let mut part = Part::new(points);
        for pair in pairs {
            part.push_cell(PartCell::Line, pair);
        }
        part
    }

    /// Appends a cell; `nodes` are indices of points, in the order of [`crate::mesh`] for surfaces.
    pub fn push_cell(&mut self, cell: PartCell, nodes: &[usize]) {
        self.cells.push(cell);
        self.connectivity.extend(nodes.iter().map(|&n| n as u64));
        self.offsets.push(self.connectivity.len() as u64);
    }

    pub fn cells(&self) -> &[PartCell] {
        &self.cells
    }

    /// Writes the part to `path` (`….vtu`). The same part gives the same bytes.
    ///
    /// # Errors
    /// See [`VtuError`].
    pub fn write(&self, path: &Path) -> Result<(), VtuError> {
        let bytes = self.to_bytes()?;
        Ok(write_whole(path, &bytes)?)
    }

    /// Size of the file's numbers before they are packed [bytes].
    pub fn raw_bytes(&self) -> u64 {
        let [points, cells] = [self.points.len(), self.cells.len()];
        let fields = self.point_data.iter().chain(&self.cell_data);
        let fields: usize = fields.map(|field| field.values.raw_bytes()).sum();
        (24 * points + 8 * self.connectivity.len() + 9 * cells + fields) as u64
    }

    /// The file's content.
    ///
    /// # Errors
    /// See [`VtuError`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, VtuError> {
        self.check()?;
        let vtk = Vtk {
            version: Version::new_xml(1, 0),
            title: String::new(),
            byte_order: ByteOrder::LittleEndian,
            file_path: None,
            data: DataSet::inline(self.to_piece()),
        };
        let mut bytes = Vec::new();
        vtk.try_into_xml_format(Compressor::ZLib, LEVEL)
            .and_then(|file| file.write(&mut bytes))
            .map_err(|source| VtuError::Encoding { source })?;
        Ok(completed(&bytes, self))
    }
}

/// The grid in vtkio's terms.
impl Part {
    fn to_piece(&self) -> UnstructuredGridPiece {
        UnstructuredGridPiece {
            points: in_space(&self.points).into(),
            cells: Cells {
                cell_verts: VertexNumbers::XML {
                    connectivity: self.connectivity.clone(),
                    offsets: self.offsets.clone(),
                },
                types: self.cells.iter().map(|cell| cell.vtk_type()).collect(),
            },
            data: Attributes::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::field::FieldName;

    fn triangle() -> Part {
        let mut part = Part::new(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        part.push_cell(PartCell::Surface(CellKind::Tri3), &[0, 1, 2]);
        part
    }

    fn message(part: &Part) -> String {
        part.to_bytes().expect_err("must be refused").to_string()
    }

    #[test]
    fn the_same_part_gives_the_same_bytes() {
        let mut part = triangle();
        part.point_data = vec![Field::scalar(FieldName::Area, vec![0.1, 0.2, 0.3])];
        let bytes = part.to_bytes().expect("valid");
        assert_eq!(bytes, part.clone().to_bytes().expect("valid"));
        assert!(String::from_utf8_lossy(&bytes).contains("vtkZLibDataCompressor"));
    }

    #[test]
    fn a_value_that_is_not_finite_is_named() {
        let mut part = triangle();
        part.point_data = vec![Field::vector(
            FieldName::Displacement,
            vec![[0.0; 2], [0.0, f64::NAN], [0.0; 2]],
        )];
        assert_eq!(message(&part), "the field `displacement` is NaN at point 1");

        let mut part = triangle();
        part.cell_data = vec![Field::scalar(FieldName::Area, vec![f64::INFINITY])];
        assert_eq!(message(&part), "the field `area` is inf at cell 0");

        let mut part = triangle();
        part.points[2][0] = f64::NEG_INFINITY;
        assert_eq!(message(&part), "the position of point 2 is -inf");
    }

    #[test]
    fn a_field_must_fit_and_be_unique() {
        let mut part = triangle();
        part.cell_data = vec![Field::integer(FieldName::Region, vec![0, 1])];
        assert_eq!(
            message(&part),
            "the field `region_id` has 2 values for 1 cells"
        );
        part.cell_data = vec![Field::integer(FieldName::Region, vec![0]); 2];
        assert_eq!(
            message(&part),
            "the field `region_id` is given twice on cells"
        );
    }

    #[test]
    fn a_cell_must_fit_its_kind_and_the_points() {
        let mut part = triangle();
        part.push_cell(PartCell::Line, &[0, 3]);
        assert_eq!(
            message(&part),
            "cell 1 refers to point 3, but there are 3 points"
        );
        let mut part = triangle();
        part.push_cell(PartCell::Surface(CellKind::Quad4), &[0, 1, 2]);
        assert_eq!(
            message(&part),
            "cell 1 is a Surface(Quad4) and has 3 nodes instead of 4"
        );
    }
}

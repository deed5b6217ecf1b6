//! VTK's XML format for unstructured grids (`.vtu`), binary and zlib-compressed.
//!
//! A [`Part`] is one grid: the finite-element region, the material points, or the bonds. Positions
//! and vectors get a third component, 0. No NaN and no infinity reaches a file: ParaView
//! would draw nothing and not tell why.

use super::field::{Field, Values, first_not_finite};
use super::packed::{LEVEL, packed};
use super::{WriteError, write_whole};
use crate::mesh::{self, CellKind};
use rayon::prelude::*;
use std::path::Path;
use vtkio::model::{
    Attributes, ByteOrder, CellType, Cells, DataSet, UnstructuredGridPiece, Version, VertexNumbers,
    Vtk,
};
use vtkio::xml::Compressor;

/// What a cell of a [`Part`] is.
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
    /// Where each cell's nodes end in `connectivity`.
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

    /// A cell of the mesh's own node numbers each.
    pub fn of_surface_cells<'a>(
        points: Vec<[f64; 2]>,
        cells: impl IntoIterator<Item = &'a mesh::Cell>,
    ) -> Part {
        let mut part = Part::new(points);
        for cell in cells {
            part.push_cell(PartCell::Surface(cell.kind), cell.nodes());
        }
        part
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

    /// Appends a cell; `nodes` are indices of points, in the order of [`mesh`] for surfaces.
    pub fn push_cell(&mut self, cell: PartCell, nodes: &[usize]) {
        self.cells.push(cell);
        self.connectivity.extend(nodes.iter().map(|&n| n as u64));
        self.offsets.push(self.connectivity.len() as u64);
    }

    pub fn cells(&self) -> &[PartCell] {
        &self.cells
    }

    /// Writes the part to `path` (`….vtu`). The same part gives the same bytes.
    pub fn write(&self, path: &Path) -> Result<(), VtuError> {
        let bytes = self.to_bytes()?;
        Ok(write_whole(path, &bytes)?)
    }

    /// What the numbers of the file take before they are packed [bytes].
    pub fn raw_bytes(&self) -> u64 {
        let [points, cells] = [self.points.len(), self.cells.len()];
        let fields = self.point_data.iter().chain(&self.cell_data);
        let fields: usize = fields.map(|field| field.values.raw_bytes()).sum();
        (24 * points + 8 * self.connectivity.len() + 9 * cells + fields) as u64
    }

    /// The file's content.
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

/// Two corrections of what vtkio writes, and the fields, each at a tag. The connectivity and the offsets
/// become Int64, as VTK declares them: vtkio knows unsigned indices only, which meshio turns into
/// floats. Counts of zero, which vtkio leaves out, are stated: VTK insists on them. The fields follow the
/// piece's tag: vtkio would pack them on one thread, number by number.
fn completed(file: &[u8], part: &Part) -> Vec<u8> {
    let mut piece = String::from("<Piece");
    if part.points.is_empty() {
        piece.push_str(" NumberOfPoints=\"0\"");
    }
    if part.cells.is_empty() {
        piece.push_str(" NumberOfCells=\"0\"");
    }
    let fields = [
        ("PointData", &part.point_data),
        ("CellData", &part.cell_data),
    ];
    let fields: Vec<Vec<String>> = fields.map(|(on, fields)| arrays(on, fields)).into();
    let length = fields.iter().flatten().map(String::len).sum::<usize>() + file.len() + 64;
    let mut completed = Vec::with_capacity(length);
    for tag in file.split_inclusive(|&byte| byte == b'>') {
        if let Some(rest) = tag.strip_prefix(b"<DataArray type=\"UInt64\"") {
            completed.extend_from_slice(b"<DataArray type=\"Int64\"");
            completed.extend_from_slice(rest);
        } else if let Some(rest) = tag.strip_prefix(b"<Piece") {
            completed.extend_from_slice(piece.as_bytes());
            completed.extend_from_slice(rest);
            for text in fields.iter().flatten() {
                completed.extend_from_slice(text.as_bytes());
            }
        } else {
            completed.extend_from_slice(tag);
        }
    }
    completed
}

/// The element `on` with the fields' arrays, in pieces.
fn arrays(on: &str, fields: &[Field]) -> Vec<String> {
    if fields.is_empty() {
        return Vec::new();
    }
    let arrays = fields.par_iter().map(|field| {
        let (kind, components, bytes) = numbers(&field.values);
        let name = field.name.as_str();
        let components = match components {
            1 => String::new(),
            many => format!(" NumberOfComponents=\"{many}\""),
        };
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"binary\">{}</DataArray>",
            packed(&bytes)
        )
    });
    let mut pieces = vec![format!("<{on}>")];
    pieces.par_extend(arrays);
    pieces.push(format!("</{on}>"));
    pieces
}

/// VTK's name of the type, components, and the numbers' bytes.
fn numbers(values: &Values) -> (&'static str, usize, Vec<u8>) {
    fn bytes<const N: usize>(rows: impl Iterator<Item = [f64; N]>) -> Vec<u8> {
        rows.flatten().flat_map(f64::to_le_bytes).collect()
    }
    match values {
        Values::Scalar(values) => ("Float64", 1, bytes(values.iter().map(|&value| [value]))),
        Values::Vector(vectors) => {
            let rows = vectors.iter().map(|&[x, y]| [x, y, 0.0]);
            ("Float64", 3, bytes(rows))
        }
        Values::SymmetricTensor(tensors) => ("Float64", 9, bytes(tensors.iter().map(rows))),
        Values::Integer(values) => {
            let bytes = values.iter().flat_map(|value| value.to_le_bytes());
            ("Int32", 1, bytes.collect())
        }
    }
}

/// Checks, in the order in which they are reported.
impl Part {
    fn check(&self) -> Result<(), VtuError> {
        self.check_points()?;
        self.check_cells()?;
        check_fields(On::Points, &self.point_data, self.points.len())?;
        check_fields(On::Cells, &self.cell_data, self.cells.len())
    }

    fn check_points(&self) -> Result<(), VtuError> {
        match first_not_finite(self.points.iter().map(<[f64; 2]>::as_slice)) {
            Some((index, value)) => Err(VtuError::PositionNotFinite { index, value }),
            None => Ok(()),
        }
    }

    fn check_cells(&self) -> Result<(), VtuError> {
        let mut start = 0;
        for (index, (cell, &end)) in self.cells.iter().zip(&self.offsets).enumerate() {
            let nodes = &self.connectivity[start..end as usize];
            start = end as usize;
            if nodes.len() != cell.node_count() {
                return Err(VtuError::NodeCount {
                    index,
                    cell: *cell,
                    given: nodes.len(),
                });
            }
            if let Some(&node) = nodes.iter().find(|&&n| n >= self.points.len() as u64) {
                return Err(VtuError::NodeMissing {
                    index,
                    node,
                    points: self.points.len(),
                });
            }
        }
        Ok(())
    }
}

fn check_fields(on: On, fields: &[Field], expected: usize) -> Result<(), VtuError> {
    for (position, field) in fields.iter().enumerate() {
        let name = field.name.as_str();
        if fields[..position].iter().any(|f| f.name == field.name) {
            return Err(VtuError::FieldTwice { on, field: name });
        }
        if field.values.len() != expected {
            return Err(VtuError::FieldLength {
                on,
                field: name,
                given: field.values.len(),
                expected,
            });
        }
        if let Some((index, value)) = field.values.first_not_finite() {
            return Err(VtuError::ValueNotFinite {
                on,
                field: name,
                index,
                value,
            });
        }
    }
    Ok(())
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

fn in_space(vectors: &[[f64; 2]]) -> Vec<f64> {
    vectors.iter().flat_map(|&[x, y]| [x, y, 0.0]).collect()
}

/// The nine components, row by row.
fn rows(&[xx, yy, zz, xy]: &[f64; 4]) -> [f64; 9] {
    [xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, zz]
}

/// What a field lives on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum On {
    Points,
    Cells,
}

impl std::fmt::Display for On {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            On::Points => "point",
            On::Cells => "cell",
        })
    }
}

/// Why a part was not written.
#[derive(Debug, thiserror::Error)]
pub enum VtuError {
    #[error("the position of point {index} is {value}")]
    PositionNotFinite { index: usize, value: f64 },
    #[error("cell {index} is a {cell:?} and has {given} nodes instead of {}", cell.node_count())]
    NodeCount {
        index: usize,
        cell: PartCell,
        given: usize,
    },
    #[error("cell {index} refers to point {node}, but there are {points} points")]
    NodeMissing {
        index: usize,
        node: u64,
        points: usize,
    },
    #[error("the field `{field}` is given twice on {on}s")]
    FieldTwice { on: On, field: &'static str },
    #[error("the field `{field}` has {given} values for {expected} {on}s")]
    FieldLength {
        on: On,
        field: &'static str,
        given: usize,
        expected: usize,
    },
    #[error("the field `{field}` is {value} at {on} {index}")]
    ValueNotFinite {
        on: On,
        field: &'static str,
        index: usize,
        value: f64,
    },
    #[error("cannot encode the grid as VTK XML")]
    Encoding { source: vtkio::xml::Error },
    #[error(transparent)]
    Write(#[from] WriteError),
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

    #[test]
    fn tensors_are_written_row_by_row() {
        assert_eq!(
            rows(&[1.0, 2.0, 3.0, 4.0]),
            [1.0, 4.0, 0.0, 4.0, 2.0, 0.0, 0.0, 0.0, 3.0]
        );
    }
}

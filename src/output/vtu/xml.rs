//! The XML of a part: what vtkio writes, completed, with the fields packed on all threads.

use super::super::field::{Field, Values};
use super::super::packed::packed;
use super::Part;
use rayon::prelude::*;

/// Two corrections of what vtkio writes, and the fields, each at a tag. The connectivity and the offsets
/// become Int64, as VTK declares them: vtkio knows unsigned indices only, which meshio turns into
/// floats. Counts of zero, which vtkio leaves out, are stated: VTK insists on them. The fields follow the
/// piece's tag: vtkio would pack them on one thread, number by number.
pub(super) fn completed(file: &[u8], part: &Part) -> Vec<u8> {
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

pub(super) fn in_space(vectors: &[[f64; 2]]) -> Vec<f64> {
    vectors.iter().flat_map(|&[x, y]| [x, y, 0.0]).collect()
}

/// The nine components, row by row.
fn rows(&[xx, yy, zz, xy]: &[f64; 4]) -> [f64; 9] {
    [xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, zz]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tensors_are_written_row_by_row() {
        assert_eq!(
            rows(&[1.0, 2.0, 3.0, 4.0]),
            [1.0, 4.0, 0.0, 4.0, 2.0, 0.0, 0.0, 0.0, 3.0]
        );
    }
}

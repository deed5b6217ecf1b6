//! Checks of a part before it is written, in the order in which they are reported.

use super::super::WriteError;
use super::super::field::{Field, first_not_finite};
use super::{Part, PartCell};

impl Part {
    pub(super) fn check(&self) -> Result<(), VtuError> {
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

/// The points or the cells of a part, on which a field is given.
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

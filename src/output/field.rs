//! Fields as they appear in result files: their names, once, and their values.

/// The quantity that a field holds. The name in the file is [`FieldName::as_str`]; units are SI.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FieldName {
    /// u [m]
    Displacement,
    /// ε, tensor components, so xy is γ/2 [-]
    Strain,
    /// σ [Pa]
    Stress,
    /// Relative elongation of a bond [-]
    Stretch,
    /// Broken share of a material point's family, weighted by area: 0 intact, 1 separated [-]
    Damage,
    /// 1 where a bond or truss is intact, 0 where it is broken [-]
    Intact,
    /// Stiffness of a bond or truss [N/m]
    Stiffness,
    /// 1 for a truss of the coupling, 0 for a bond [-]
    Truss,
    /// Area of a material point [m²]
    Area,
    /// Volume of a material point [m³]
    Volume,
    /// Index of the region, in the order of the pipeline [-]
    Region,
    /// Index of the material, in alphabetical order of the names [-]
    Material,
}

impl FieldName {
    pub const ALL: [FieldName; 12] = [
        FieldName::Displacement,
        FieldName::Strain,
        FieldName::Stress,
        FieldName::Stretch,
        FieldName::Damage,
        FieldName::Intact,
        FieldName::Stiffness,
        FieldName::Truss,
        FieldName::Area,
        FieldName::Volume,
        FieldName::Region,
        FieldName::Material,
    ];

    pub fn as_str(self) -> &'static str {
        match self {
            FieldName::Displacement => "displacement",
            FieldName::Strain => "strain",
            FieldName::Stress => "stress",
            FieldName::Stretch => "stretch",
            FieldName::Damage => "damage",
            FieldName::Intact => "intact",
            FieldName::Stiffness => "stiffness",
            FieldName::Truss => "truss",
            FieldName::Area => "area",
            FieldName::Volume => "volume",
            FieldName::Region => "region_id",
            FieldName::Material => "material_id",
        }
    }
}

impl std::fmt::Display for FieldName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

/// One value per point or per cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    Scalar(Vec<f64>),
    /// x, y; in a file a third component, 0, follows.
    Vector(Vec<[f64; 2]>),
    /// xx, yy, zz, xy; in a file the nine components row by row.
    SymmetricTensor(Vec<[f64; 4]>),
    Integer(Vec<i32>),
}

impl Values {
    /// Number of points or cells with a value.
    pub fn len(&self) -> usize {
        match self {
            Values::Scalar(values) => values.len(),
            Values::Vector(values) => values.len(),
            Values::SymmetricTensor(values) => values.len(),
            Values::Integer(values) => values.len(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Size of the values in a file before they are packed [bytes].
    pub fn raw_bytes(&self) -> usize {
        let each = match self {
            Values::Scalar(_) => 8,
            Values::Vector(_) => 3 * 8,
            Values::SymmetricTensor(_) => 9 * 8,
            Values::Integer(_) => 4,
        };
        each * self.len()
    }

    /// The first point or cell with a component that is NaN or infinite, and that component.
    pub fn first_not_finite(&self) -> Option<(usize, f64)> {
        match self {
            Values::Scalar(values) => first_not_finite(values.iter().map(std::slice::from_ref)),
            Values::Vector(values) => first_not_finite(values.iter().map(<[f64; 2]>::as_slice)),
            Values::SymmetricTensor(values) => {
                first_not_finite(values.iter().map(<[f64; 4]>::as_slice))
            }
            Values::Integer(_) => None,
        }
    }
}

/// The first item with a component that is NaN or infinite, and that component.
pub(super) fn first_not_finite<'a>(items: impl Iterator<Item = &'a [f64]>) -> Option<(usize, f64)> {
    items.enumerate().find_map(|(index, components)| {
        let value = components.iter().find(|value| !value.is_finite())?;
        Some((index, *value))
    })
}

/// A named field.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub name: FieldName,
    pub values: Values,
}

impl Field {
    pub fn scalar(name: FieldName, values: Vec<f64>) -> Field {
        let values = Values::Scalar(values);
        Field { name, values }
    }

    pub fn vector(name: FieldName, values: Vec<[f64; 2]>) -> Field {
        let values = Values::Vector(values);
        Field { name, values }
    }

    /// `values`: xx, yy, zz, xy of each point or cell.
    pub fn symmetric_tensor(name: FieldName, values: Vec<[f64; 4]>) -> Field {
        let values = Values::SymmetricTensor(values);
        Field { name, values }
    }

    pub fn integer(name: FieldName, values: Vec<i32>) -> Field {
        let values = Values::Integer(values);
        Field { name, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_distinct() {
        let names: std::collections::BTreeSet<&str> =
            FieldName::ALL.iter().map(|name| name.as_str()).collect();
        assert_eq!(names.len(), FieldName::ALL.len());
    }

    #[test]
    fn the_first_value_that_is_not_finite_is_found_in_every_kind() {
        let inf = f64::INFINITY;
        let cases = [
            Values::Scalar(vec![0.0, inf]),
            Values::Vector(vec![[0.0; 2], [0.0, inf]]),
            Values::SymmetricTensor(vec![[0.0; 4], [0.0, 0.0, 0.0, inf]]),
        ];
        for values in cases {
            assert_eq!(values.first_not_finite(), Some((1, inf)));
        }
        assert_eq!(Values::Integer(vec![1]).first_not_finite(), None);
    }
}

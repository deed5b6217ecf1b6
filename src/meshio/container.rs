//! The child's output: a line of JSON, the header, and then the arrays that it lists, little-endian 64-bit
//! numbers one behind the other. Nothing of it is trusted: every index and length is checked here.

use std::collections::BTreeMap;

use serde::Deserialize;

/// The kinds of cells that come over, as meshio names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    Vertex,
    Line,
    Line3,
    Triangle,
    Triangle6,
    Quad,
    Quad8,
}

impl Kind {
    pub fn node_count(self) -> usize {
        match self {
            Kind::Vertex => 1,
            Kind::Line => 2,
            Kind::Line3 | Kind::Triangle => 3,
            Kind::Quad => 4,
            Kind::Triangle6 => 6,
            Kind::Quad8 => 8,
        }
    }

    /// The name that meshio uses.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Vertex => "vertex",
            Kind::Line => "line",
            Kind::Line3 => "line3",
            Kind::Triangle => "triangle",
            Kind::Triangle6 => "triangle6",
            Kind::Quad => "quad",
            Kind::Quad8 => "quad8",
        }
    }

    pub fn dimension(self) -> u8 {
        match self {
            Kind::Vertex => 0,
            Kind::Line | Kind::Line3 => 1,
            _ => 2,
        }
    }
}

/// A cell as it stands in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cell {
    pub kind: Kind,
    /// Number of the cell in the file.
    pub id: i64,
    /// Indices of nodes.
    pub nodes: Vec<usize>,
}

/// A mesh and its sets, with sound indices.
#[derive(Clone, Debug, Default)]
pub struct Container {
    /// meshio's version.
    pub version: String,
    /// [unit of the file].
    pub points: Vec<[f64; 3]>,
    /// The nodes' numbers in the file.
    pub node_ids: Vec<i64>,
    pub cells: Vec<Cell>,
    /// Indices of cells.
    pub cell_sets: Vec<(String, Vec<usize>)>,
    /// Indices of nodes.
    pub node_sets: Vec<(String, Vec<usize>)>,
    /// Indices of plane cells and of their sides, side k from corner k on.
    pub side_sets: Vec<(String, Vec<[usize; 2]>)>,
    /// Kinds of cells that were left out, and how many.
    pub ignored: Vec<(String, u64)>,
    pub notes: Vec<String>,
}

/// The child's result.
#[derive(Debug)]
pub enum Outcome {
    Mesh(Container),
    Failed { kind: String, text: String },
}

#[derive(Deserialize)]
struct Header {
    #[serde(default)]
    error: Option<String>,
    #[serde(default)]
    text: String,
    #[serde(default)]
    meshio: String,
    #[serde(default)]
    blocks: Vec<Kind>,
    #[serde(default)]
    cell_sets: Vec<String>,
    #[serde(default)]
    node_sets: Vec<String>,
    #[serde(default)]
    side_sets: Vec<String>,
    #[serde(default)]
    ignored: Vec<(String, u64)>,
    #[serde(default)]
    notes: Vec<String>,
    #[serde(default)]
    arrays: Vec<Listed>,
}

#[derive(Deserialize)]
struct Listed {
    name: String,
    kind: NumberKind,
    length: usize,
}

#[derive(Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum NumberKind {
    F8,
    I8,
}

/// Reads what the child wrote.
///
/// # Errors
/// A sentence about the damage.
pub fn read(bytes: &[u8]) -> Result<Outcome, String> {
    let end = bytes.iter().position(|&byte| byte == b'\n');
    let end = end.ok_or("it has no header")?;
    let header: Header =
        serde_json::from_slice(&bytes[..end]).map_err(|error| error.to_string())?;
    if let Some(kind) = header.error {
        let text = header.text;
        return Ok(Outcome::Failed { kind, text });
    }
    let arrays = Arrays::new(&header.arrays, &bytes[end + 1..])?;
    let mut container = Container {
        version: header.meshio,
        points: triples(arrays.floats("points")?)?,
        node_ids: arrays.integers("node_ids")?,
        ignored: header.ignored,
        notes: header.notes,
        ..Container::default()
    };
    let node_count = container.points.len();
    if container.node_ids.len() != node_count {
        return Err("not every node has a number".to_owned());
    }
    for (block, &kind) in header.blocks.iter().enumerate() {
        let nodes = arrays.indices(&format!("nodes/{block}"), node_count)?;
        let ids = arrays.integers(&format!("ids/{block}"))?;
        if nodes.len() != ids.len().saturating_mul(kind.node_count()) {
            return Err(format!(
                "block {block} has another length than its elements"
            ));
        }
        let rows = nodes.chunks_exact(kind.node_count());
        container
            .cells
            .extend(rows.zip(ids).map(|(nodes, id)| Cell {
                kind,
                id,
                nodes: nodes.to_vec(),
            }));
    }
    let cell_count = container.cells.len();
    let named = |word: &str, names: Vec<String>, bound: usize| {
        let set = |(k, name)| Ok((name, arrays.indices(&format!("{word}/{k}"), bound)?));
        names
            .into_iter()
            .enumerate()
            .map(set)
            .collect::<Result<Vec<_>, String>>()
    };
    container.cell_sets = named("cell_set", header.cell_sets, cell_count)?;
    container.node_sets = named("node_set", header.node_sets, node_count)?;
    // Sides are smaller numbers than cells, and are checked beside theirs.
    for (name, flat) in named("side_set", header.side_sets, cell_count.max(4))? {
        let pairs: Vec<[usize; 2]> = flat
            .chunks_exact(2)
            .map(|pair| [pair[0], pair[1]])
            .collect();
        let is_sound = |&[cell, side]: &[usize; 2]| {
            container.cells.get(cell).is_some_and(|cell| {
                let corners = if cell.kind.node_count().is_multiple_of(4) {
                    4
                } else {
                    3
                };
                cell.kind.dimension() == 2 && side < corners
            })
        };
        if !flat.len().is_multiple_of(2) || !pairs.iter().all(is_sound) {
            return Err(format!("the surface `{name}` names a side that is none"));
        }
        container.side_sets.push((name, pairs));
    }
    Ok(Outcome::Mesh(container))
}

fn triples(numbers: Vec<f64>) -> Result<Vec<[f64; 3]>, String> {
    if !numbers.len().is_multiple_of(3) || !numbers.iter().all(|number| number.is_finite()) {
        return Err("a coordinate is missing or no number".to_owned());
    }
    let triples = numbers.chunks_exact(3);
    Ok(triples.map(|p| [p[0], p[1], p[2]]).collect())
}

/// The arrays by name, as bytes.
struct Arrays<'a>(BTreeMap<&'a str, (NumberKind, &'a [u8])>);

impl<'a> Arrays<'a> {
    fn new(listed: &'a [Listed], mut bytes: &'a [u8]) -> Result<Arrays<'a>, String> {
        let mut arrays = BTreeMap::new();
        for array in listed {
            let length = array
                .length
                .checked_mul(8)
                .filter(|&length| length <= bytes.len());
            let length = length.ok_or_else(|| format!("array `{}` is cut short", array.name))?;
            let (own, rest) = bytes.split_at(length);
            arrays.insert(array.name.as_str(), (array.kind, own));
            bytes = rest;
        }
        Ok(Arrays(arrays))
    }

    fn words(
        &self,
        name: &str,
        kind: NumberKind,
    ) -> Result<impl Iterator<Item = [u8; 8]> + 'a, String> {
        let found = self.0.get(name).filter(|(of, _)| *of == kind);
        let (_, bytes) = found.ok_or_else(|| format!("array `{name}` is missing"))?;
        let word = |chunk: &[u8]| chunk.try_into().expect("chunks of eight");
        Ok(bytes.chunks_exact(8).map(word))
    }

    fn floats(&self, name: &str) -> Result<Vec<f64>, String> {
        Ok(self
            .words(name, NumberKind::F8)?
            .map(f64::from_le_bytes)
            .collect())
    }

    fn integers(&self, name: &str) -> Result<Vec<i64>, String> {
        Ok(self
            .words(name, NumberKind::I8)?
            .map(i64::from_le_bytes)
            .collect())
    }

    /// Integers from 0 to below `bound`.
    fn indices(&self, name: &str, bound: usize) -> Result<Vec<usize>, String> {
        let index = |number: i64| {
            let index = usize::try_from(number).ok().filter(|&index| index < bound);
            index.ok_or_else(|| format!("`{name}` has the index {number}, of {bound}"))
        };
        self.integers(name)?.into_iter().map(index).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sound() -> Vec<u8> {
        let header = r#"{"meshio": "5", "blocks": ["triangle"], "cell_sets": ["a"], "side_sets": ["s"], "arrays": [
            {"name": "points", "kind": "f8", "length": 9}, {"name": "node_ids", "kind": "i8", "length": 3},
            {"name": "nodes/0", "kind": "i8", "length": 3}, {"name": "ids/0", "kind": "i8", "length": 1},
            {"name": "cell_set/0", "kind": "i8", "length": 1}, {"name": "side_set/0", "kind": "i8", "length": 2}]}"#;
        let mut bytes = header.replace('\n', " ").into_bytes();
        bytes.push(b'\n');
        let floats = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        bytes.extend(floats.iter().flat_map(|x: &f64| x.to_le_bytes()));
        let integers = [7, 8, 9, 0, 1, 2, 5, 0, 0, 2];
        bytes.extend(integers.iter().flat_map(|x: &i64| x.to_le_bytes()));
        bytes
    }

    #[test]
    fn a_sound_one_is_read() {
        let Ok(Outcome::Mesh(container)) = read(&sound()) else {
            panic!("it is sound");
        };
        assert_eq!(container.points[1], [1.0, 0.0, 0.0]);
        assert_eq!(container.node_ids, [7, 8, 9]);
        assert_eq!(container.cells[0].id, 5);
        assert_eq!(container.cell_sets, [("a".to_owned(), vec![0])]);
        assert_eq!(container.side_sets, [("s".to_owned(), vec![[0, 2]])]);
    }

    #[test]
    fn every_cut_is_an_error() {
        let whole = sound();
        for length in 0..whole.len() {
            assert!(read(&whole[..length]).is_err(), "{length}");
        }
    }

    proptest! {
        /// Neither a panic nor an index out of bounds, whatever the bytes.
        #[test]
        fn garbage_does_no_harm(changes in prop::collection::vec((0usize..1000, any::<u8>()), 1..8)) {
            let mut bytes = sound();
            for (at, byte) in changes {
                let length = bytes.len();
                bytes[at % length] = byte;
            }
            if let Ok(Outcome::Mesh(container)) = read(&bytes) {
                let nodes = container.cells.iter().flat_map(|cell| &cell.nodes);
                prop_assert!(nodes.copied().all(|node| node < container.points.len()));
                let members = container.cell_sets.iter().flat_map(|(_, cells)| cells);
                prop_assert!(members.copied().all(|cell| cell < container.cells.len()));
            }
        }
    }
}

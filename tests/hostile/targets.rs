//! Readers, and inputs to begin with: each target is fed with mutations of its seeds and must end,
//! without a panic, within the limits.

use super::random::Random;
use super::readers::{Read, STORED, reader};
use super::workplace::{PIPELINE, PLATE, repository};
use peristitch::gmsh::{Block, Extract, Group};
use peristitch::pipeline::record::stamp;
use peristitch::pipeline::record::stored::Kind;
use std::alloc::{GlobalAlloc, Layout, System};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Pieces that have broken readers before.
const PIECES: [&[u8]; 22] = [
    b"-1",
    b"1e999",
    b"NaN",
    b"18446744073709551616",
    b"0",
    b"1/0",
    b"\0",
    b"\xff\xfe",
    b"\xe2\x88\x9e",
    b"[[[[[[[[",
    b"{a: ",
    b"- - - - ",
    b"&a [*a, *a]",
    b"\"",
    b"/*",
    b"\n\n",
    b"\t",
    b": ",
    b"!!binary ",
    b"\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01",
    b"..",
    b"mm mm^9999999",
];

/// One to eight changes: bits, bytes, pieces, cuts, repeats, and parts of the other seeds.
pub fn mutated(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = seeds[random.below(seeds.len())].clone();
    for _ in 0..1 + random.below(8) {
        let at = random.below(bytes.len() + 1);
        match random.below(8) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            1 if at < bytes.len() => bytes[at] = random.below(256) as u8,
            2 => drop(bytes.splice(at..at, PIECES[random.below(PIECES.len())].iter().copied())),
            3 => bytes.truncate(at),
            4 => drop(bytes.drain(at..(at + 1 + random.below(40)).min(bytes.len()))),
            5 => {
                let end = (at + 1 + random.below(60)).min(bytes.len());
                // Now and then thousands of times: depth and length.
                let count = if random.below(50) == 0 {
                    2000
                } else {
                    1 + random.below(3)
                };
                let again = bytes[at..end].repeat(count);
                bytes.splice(at..at, again);
            }
            6 => {
                let other = &seeds[random.below(seeds.len())];
                let from = random.below(other.len() + 1);
                let end = (from + random.below(80)).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied());
            }
            _ => {
                // A number for a number.
                let digits = |byte: &u8| byte.is_ascii_digit();
                if let Some(first) = bytes[at..].iter().position(digits) {
                    let piece = PIECES[random.below(6)];
                    bytes.splice(at + first..at + first + 1, piece.iter().copied());
                }
            }
        }
    }
    bytes
}

/// Counts what is held, for each thread that asks.
pub struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

#[allow(unsafe_code)]
// SAFETY: the system's allocator does the work; the counters hold no memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(held, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        unsafe { System.dealloc(pointer, layout) }
    }
}

/// No input is longer than some 500 kB; a reader may hold a few hundred times as much, since a byte of
/// YAML becomes a node, and no more.
pub const MOST_BYTES: usize = 256 << 20;

/// An input of 500 kB may be quadratic to complain of; none may take longer [s].
pub const LONGEST: Duration = Duration::from_secs(5);

pub struct Target {
    pub name: &'static str,
    seeds: Vec<Vec<u8>>,
    read: Read,
    /// What every refusal holds: the place.
    place: Option<&'static str>,
}

/// What came of it.
#[derive(Debug, Default)]
pub struct Tally {
    pub inputs: usize,
    pub taken: usize,
    pub slowest: Duration,
    pub most_bytes: usize,
    pub time: Duration,
    /// What was wrong, and the input.
    pub faults: Vec<(String, Vec<u8>)>,
}

impl Target {
    /// The seeds themselves are sound.
    pub fn assert_seeds(&self) {
        for seed in &self.seeds {
            let taken = (self.read)(seed);
            assert!(taken.is_ok(), "{}: its own seed: {taken:?}", self.name);
        }
    }

    /// The seeds as files in `folder`/NAME, for `fuzz/`.
    pub fn write_seeds(&self, folder: &Path) {
        let folder = folder.join(self.name);
        std::fs::create_dir_all(&folder).expect("writable");
        for seed in &self.seeds {
            std::fs::write(folder.join(stamp::hash(seed)), seed).expect("writable");
        }
    }

    pub fn feed(&self, count: usize, seed: u64) -> Tally {
        let mut random = Random(seed);
        let mut tally = Tally::default();
        let start = Instant::now();
        for _ in 0..count {
            let input = mutated(&self.seeds, &mut random);
            let before = HELD.load(Ordering::Relaxed);
            PEAK.store(before, Ordering::Relaxed);
            let begin = Instant::now();
            let outcome = catch_unwind(AssertUnwindSafe(|| (self.read)(&input)));
            let time = begin.elapsed();
            let bytes = PEAK.load(Ordering::Relaxed).saturating_sub(before);
            tally.inputs += 1;
            tally.slowest = tally.slowest.max(time);
            tally.most_bytes = tally.most_bytes.max(bytes);
            let fault = match outcome {
                Err(panic) => Some(format!("panic: {}", told(&*panic))),
                Ok(_) if time > LONGEST => Some(format!("{time:?}")),
                Ok(_) if bytes > MOST_BYTES => Some(format!("{bytes} bytes")),
                Ok(Err(error)) if self.place.is_some_and(|place| !error.contains(place)) => {
                    Some(format!("no place: {error}"))
                }
                Ok(outcome) => {
                    tally.taken += usize::from(outcome.is_ok());
                    None
                }
            };
            tally.faults.extend(fault.map(|fault| (fault, input)));
        }
        tally.time = start.elapsed();
        tally
    }
}

fn told(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(|&text| text.to_owned()))
        .unwrap_or_default()
}

fn pipelines() -> Vec<Vec<u8>> {
    let mut seeds = vec![PIPELINE.into(), PLATE.into()];
    let sweep = "sweep: { over: { thickness: { from: 1 mm, to: 8 mm, count: 4, scale: log }, regions.1.horizon: [3, 4] } }\n";
    seeds.push([PIPELINE, sweep].concat().into_bytes());
    seeds
}

/// A square of two triangles and one of a quadrilateral, with a curve and a point.
fn extract() -> Extract {
    let block = |kind: i32, kind_name: &str, each: usize, tags: &[u64], nodes: &[usize]| Block {
        kind,
        kind_name: kind_name.to_owned(),
        order: 1,
        nodes_per_element: each,
        tags: tags.to_vec(),
        nodes: nodes.to_vec(),
    };
    let group = |dimension, tag, name: &str, blocks| Group {
        dimension,
        tag,
        name: name.to_owned(),
        blocks,
    };
    let triangles = block(2, "Triangle 3", 3, &[5, 6], &[0, 1, 2, 0, 2, 3]);
    let square = block(3, "Quadrilateral 4", 4, &[7], &[1, 4, 5, 2]);
    Extract {
        nodes: [[0., 0.], [1., 0.], [1., 1.], [0., 1.], [2., 0.], [2., 1.]]
            .map(|[x, y]| [x, y, 0.0])
            .to_vec(),
        entity_counts: [1, 1, 2, 0],
        groups: vec![
            group(0, 1, "corner", vec![block(15, "Point", 1, &[1], &[0])]),
            group(1, 2, "left", vec![block(1, "Line 2", 2, &[2], &[0, 3])]),
            group(2, 3, "plate", vec![triangles, square]),
        ],
        ..Extract::default()
    }
}

fn container_bytes() -> Vec<u8> {
    let header = r#"{"meshio": "5", "blocks": ["triangle", "line"], "cell_sets": ["a", "b"], "node_sets": ["n"], "side_sets": ["s"], "arrays": [{"name": "points", "kind": "f8", "length": 12}, {"name": "node_ids", "kind": "i8", "length": 4}, {"name": "nodes/0", "kind": "i8", "length": 6}, {"name": "ids/0", "kind": "i8", "length": 2}, {"name": "nodes/1", "kind": "i8", "length": 2}, {"name": "ids/1", "kind": "i8", "length": 1}, {"name": "cell_set/0", "kind": "i8", "length": 2}, {"name": "cell_set/1", "kind": "i8", "length": 1}, {"name": "node_set/0", "kind": "i8", "length": 2}, {"name": "side_set/0", "kind": "i8", "length": 2}]}"#;
    let floats = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.].map(f64::to_le_bytes);
    let integers: [i64; 24] = [
        7, 8, 9, 10, 0, 1, 2, 0, 2, 3, 5, 6, 0, 1, 3, 0, 1, 2, 1, 2, 0, 1, 0, 0,
    ];
    let mut bytes = header.as_bytes().to_vec();
    bytes.push(b'\n');
    bytes.extend(floats.iter().flatten());
    bytes.extend(
        integers[..22]
            .iter()
            .flat_map(|number| number.to_le_bytes()),
    );
    bytes
}

/// `stored`: files of a small fracture run and of what an interrupted one leaves.
pub fn targets(stored: &[(Kind, Vec<u8>)]) -> Vec<Target> {
    let geo = repository().join("geo");
    let target = |name, seeds, place| Target {
        name,
        seeds,
        read: reader(name, &geo).expect("a kind of input"),
        place,
    };
    let geometry = |name: &str| std::fs::read(geo.join(name)).expect("a .geo");
    let quantities = [
        "12.5 mm",
        "1/3",
        "1.05 MPa",
        "30 GPa",
        "2e-8 m",
        "5 N/m",
        "1 kg/m^3",
        "0.3",
        "-1.5e3 J/m^2",
    ];
    let geometries = vec![
        geometry("cantilever.geo"),
        geometry("plate_mode_i.geo"),
        b"DefineConstant[ a = {1, Min 0, Max 2, Name \"p/a\"}, b = \"x\" ];\nInclude \"geo/bar.geo\";\nPrintf(\"%g\", 1) >> \"f\";\nSystemCall StrCat(\"a\", 'b');\n".to_vec(),
    ];
    let mut targets = vec![
        target("pipeline", pipelines(), Some("hostile.yaml")),
        target("sweep", pipelines()[2..].to_vec(), None),
        target("quantity", quantities.map(Vec::from).to_vec(), None),
        target("geometry", geometries, Some("hostile.geo")),
        target("meshio", vec![container_bytes()], None),
    ];
    let mesh = postcard::to_stdvec(&extract()).expect("plain data");
    for (kind, bytes) in stored.iter().cloned().chain([(Kind::Mesh, mesh)]) {
        let known = STORED.iter().find(|(_, stored)| *stored == kind);
        targets.push(target(known.expect("a kind").0, vec![bytes], None));
    }
    targets
}

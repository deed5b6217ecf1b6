//! One, two and eight threads, again and again: the same bytes in every file of a fracture run, history,
//! frames, VTU, pictures, animation and report included; what a summary tells of costs is left out. Once per
//! number of threads here; as often as wanted by
//!
//! ```text
//! REPEATS=20 cargo test --release --test same_files -- --nocapture
//! ```

mod workplace;

use workplace::{PLATE, Workplace};

#[test]
fn threads_and_repetition_change_no_byte() {
    let text = std::env::var("REPEATS");
    let repeats: usize = text.map_or(1, |text| text.parse().expect("a number"));
    let output = "output: { every: 29, pictures: true, animation: true, report: true }";
    let text = PLATE.replace("output: { every: 7, pictures: false }", output);
    assert!(text.contains(output));
    let mut first = None;
    for turn in 0..repeats {
        for threads in ["1", "2", "8"] {
            let place = Workplace::with_plate();
            place.write("plate.yaml", &text);
            place
                .call(&["run", "plate.yaml", "--threads", threads])
                .succeeded();
            let found = place.results("results/plate");
            let expected = first.get_or_insert_with(|| found.clone());
            assert!(
                found.keys().eq(expected.keys()),
                "{threads} threads, turn {turn}"
            );
            for (name, bytes) in &found {
                assert!(
                    expected[name] == *bytes,
                    "{name}: {threads} threads, turn {turn}"
                );
            }
        }
    }
    let files = first.expect("there were runs");
    for ending in [
        ".csv", ".bin", ".vtu", ".pvd", ".png", ".gif", ".html", ".json",
    ] {
        assert!(
            files.keys().any(|name| name.ends_with(ending)),
            "{ending}: {:?}",
            files.keys()
        );
    }
    println!("{} files the same in {} runs", files.len(), 3 * repeats);
}

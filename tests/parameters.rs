//! The parameters of a `.geo`: listed by `check`, kept to their range, told in the summary.

mod workplace;

use peristitch::gmsh::{self, Options, Value};
use serde_json::json;
use std::collections::BTreeMap;
use workplace::Workplace;

/// What `check` prints under `parameters`, with blanks squeezed.
fn listed(place: &Workplace, more: &[&str]) -> Vec<String> {
    let ended = place.call(&[&["check", "bar.yaml"], more].concat());
    let ended = ended.succeeded();
    let lines = ended.out.lines();
    let from = lines.skip_while(|line| !line.starts_with("  parameters "));
    let until = from.take_while(|line| !line.starts_with("  finite elements"));
    let squeezed = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    until.map(squeezed).collect()
}

#[test]
fn check_lists_value_origin_default_and_range() {
    let place = Workplace::new();
    let lines = listed(&place, &["--set", "geometry.parameters.band_start=350"]);
    assert_eq!(
        lines,
        [
            "parameters band_end = 600 default",
            "band_start = 350 set by --set; default 400",
            "element = 50 set by the pipeline; default 10",
            "order = 2 set by the pipeline; default 2; 1 or 2",
            "triangles = 0 default; 0 or 1",
        ]
    );
}

/// Values that only Gmsh knows: an expression, a variable that the script asks for, one of an
/// included file. Gmsh 4.8 does not tell them.
#[test]
fn check_evaluates_expressions_and_follows_includes() {
    let place = Workplace::new();
    place.write(
        "geo/more.geo",
        "DefineConstant[ depth = {3, Min 1, Max 9, Name \"P/depth\"} ];\n",
    );
    let sizes = "length = 1000;\nDefineConstant[ twice = 2 * element, label = \"a b\" ];\n\
                 If(!Exists(asked))\n  asked = 7;\nEndIf\nInclude \"more.geo\";\n";
    place.edit("geo/bar.geo", "length = 1000;\n", sizes);
    let lines = listed(&place, &["--set", "geometry.parameters.depth=4"]);
    for expected in [
        "parameters asked = 7 default",
        "depth = 4 set by --set; default 3; from 1 to 9",
        "label = 'a b' default",
        "twice = 100 default",
    ] {
        assert!(
            lines.iter().any(|line| line == expected),
            "{expected}: {lines:?}"
        );
    }
    place.run(&["--set", "geometry.parameters.asked=8"]);
    let expected = json!({
        "asked": 8.0, "band_end": 600.0, "band_start": 400.0, "depth": 3.0, "element": 50.0,
        "label": "a b", "order": 2.0, "triangles": 0.0, "twice": 100.0,
    });
    assert_eq!(place.summary()["parameters"], expected);
}

/// Whatever the version: the values that need no Gmsh are known with each.
#[test]
fn every_version_of_gmsh_tells_what_is_written() {
    let geometry = workplace::repository().join("geo/cantilever.geo");
    for library in gmsh::library::Places::of_this_process().search().found {
        let options = Options {
            worker: Some(workplace::BINARY.into()),
            library: Some(library),
            ..Options::default()
        };
        let given = BTreeMap::from([("element".to_owned(), Value::Number(50.0))]);
        let extract = gmsh::mesh(&geometry, &given, &options).expect("a mesh");
        let numbers = [
            ("band_end", 600.0),
            ("band_start", 400.0),
            ("element", 50.0),
        ];
        let numbers = numbers
            .into_iter()
            .chain([("order", 2.0), ("triangles", 0.0)]);
        let expected = numbers.map(|(name, value)| (name.to_owned(), Value::Number(value)));
        assert_eq!(extract.parameters, expected.collect());
    }
}

#[test]
fn a_value_outside_the_range_is_refused_with_the_range() {
    let place = Workplace::new();
    let sizes = "length = 1000;\nDefineConstant[ a = {2, Min 1, Max 2.5, Name \"P/a\"},\n\
                 b = {\"x\", Choices{\"x\", \"y\"}, Name \"P/b\"},\n\
                 c = {1, Choices{0=\"no\", 1=\"yes\"}, Name \"P/c\"} ];\n";
    place.edit("geo/bar.geo", "length = 1000;\n", sizes);
    let before = place.snapshot();
    for (name, value, message) in [
        (
            "a",
            "2.6",
            "parameter 'a' of geo/bar.geo must be from 1 to 2.5, not 2.6",
        ),
        ("a", "0", "must be from 1 to 2.5, not 0"),
        (
            "b",
            "z",
            "parameter 'b' of geo/bar.geo must be 'x' or 'y', not 'z'",
        ),
        ("c", "2", "must be 0 (no) or 1 (yes), not 2"),
        ("order", "3", "must be 1 or 2, not 3"),
    ] {
        let set = format!("geometry.parameters.{name}={value}");
        let ended = place.call(&["run", "bar.yaml", "--set", &set]);
        assert_eq!(ended.code, Some(2), "{}", ended.err);
        assert!(ended.err.contains(message), "{message}: {}", ended.err);
        assert!(
            ended.err.contains(&format!("by `--set {set}`")),
            "{}",
            ended.err
        );
        assert_eq!(place.snapshot(), before);
    }
    // In the pipeline itself the message points at the line.
    place.edit("bar.yaml", "order: 2", "order: 3");
    let ended = place.call(&["check", "bar.yaml"]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.err.contains("bar.yaml:5:"), "{}", ended.err);
    for sound in ["a=1", "a=2.5", "b=y", "c=0"] {
        let set = format!("geometry.parameters.{sound}");
        let sound = place.call(&[
            "check",
            "bar.yaml",
            "--set",
            &set,
            "--set",
            "geometry.parameters.order=1",
        ]);
        sound.succeeded();
    }
}

//! Parameters, includes and statements of scripts.

use super::*;
use crate::gmsh::Value;
use std::fs;

fn scan(text: &str) -> GeoScript {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("model.geo");
    fs::write(&file, text).unwrap();
    GeoScript::scan(&file).unwrap()
}

fn names(script: &GeoScript) -> Vec<&str> {
    script.parameters.keys().map(String::as_str).collect()
}

#[test]
fn a_name_may_end_with_a_unit() {
    let script = scan(
        "DefineConstant[ a = {25, Name \"Geometry/Crack length [mm]\", Min 1},\n\
         b = {2, Name \"Geometry/Teeth [of the saw] and gaps\"}, c = {1, Label \"mass [kg]\"} ];",
    );
    let unit = |name: &str| script.parameters[name].unit.as_deref();
    assert_eq!(["a", "b", "c"].map(unit), [Some("mm"), None, None]);
}

#[test]
fn constants_and_their_defaults() {
    let script = scan(
        r#"
        DefineConstant[ a = 1.5e-3, b = {2, Min 0, Max 10, Name "Parameters/b, with comma"} ];
        DefineConstant [
          c = "text",
          d = {"in } attributes", Choices{"x", "y"}, Name "d"}, // e = 5
          f,
          g = 2*a,
          /* h = 7, */ i = {-3}
        ];"#,
    );
    let default = |name: &str| script.parameters[name].default.clone();
    assert_eq!(names(&script), ["a", "b", "c", "d", "f", "g", "i"]);
    assert_eq!(default("a"), Default::Number(1.5e-3));
    assert_eq!(default("b"), Default::Number(2.0));
    assert_eq!(default("c"), Default::Text("text".into()));
    assert_eq!(default("d"), Default::Text("in } attributes".into()));
    assert_eq!(default("f"), Default::Absent);
    assert_eq!(default("g"), Default::Expression("2*a".into()));
    assert_eq!(default("i"), Default::Number(-3.0));
    assert_eq!(script.parameters["a"].line, 2);
    assert_eq!(script.parameters["d"].line, 5);
}

#[test]
fn attributes_bind_where_they_are_plain() {
    let script = scan(
        r#"DefineConstant[
          a = {2, Min 0.5, Max 1e1, Step 1, Name "P/Min 3, Max 4"},
          b = {1, Choices {0="no, never", 1="yes"}, Min -1},
          c = {"x", Choices{"x", "y z"}, Name "c"}, d = {1, Max 2*a}, e = {1, Choices{1, 2*a}}
        ];"#,
    );
    let range = |name: &str| script.parameters[name].range.clone();
    assert_eq!(
        (range("a").lowest, range("a").highest),
        (Some(0.5), Some(10.0))
    );
    let labelled = |value: f64, label: &str| (Value::Number(value), label.to_owned());
    assert_eq!(
        range("b").choices,
        [labelled(0.0, "no, never"), labelled(1.0, "yes")]
    );
    assert_eq!(range("b").lowest, Some(-1.0));
    let texts = ["x", "y z"].map(|text| (Value::from(text), String::new()));
    assert_eq!(range("c").choices, texts);
    assert!(range("d").is_open() && range("e").is_open());
}

#[test]
fn comments_and_strings_define_nothing() {
    let script = scan(
        "// DefineConstant[ a = 1 ];\n/* DefineConstant[ b = 1 ]; */\n\
         Printf(\"DefineConstant[ c = 1 ]; // é\"); MyDefineConstant[ d = 1 ];\n\
         DefineConstant[ e = 1 ];",
    );
    assert_eq!(names(&script), ["e"]);
    assert_eq!(script.parameters["e"].line, 4);
}

#[test]
fn tested_variables_are_parameters_and_defined_numbers_are_not() {
    let script = scan(
        "If(!Exists(q)) q = 9; EndIf\nh = DefineNumber[ 3, Name \"Parameters/h\" ];\n\
         s = DefineString[ \"x\", Name \"Parameters/s\" ];",
    );
    assert_eq!(names(&script), ["q"]);
    assert_eq!(script.parameters["q"].default, Default::Absent);
    assert_eq!(
        script.fixed,
        BTreeSet::from(["h".to_owned(), "s".to_owned()])
    );
}

#[test]
fn unfinished_scripts_do_not_panic() {
    let whole = "DefineConstant[ a = {1, Name \"x\\\"\", Min 1, Choices{1=\"é\", 2}}, b = 'y' ]; /* é */ Merge \"z\"; // e";
    for (end, _) in whole.char_indices() {
        scan(&whole[..end]);
    }
    scan("DefineConstant[ = ]; DefineConstant[]; DefineConstant[ a = {} ]; Exists() ]]]");
}

#[test]
fn included_files_are_followed_and_cycles_end() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
        path
    };
    let main = write(
        "main.geo",
        "Include \"parts/common.geo\"; Merge StrCat(CurrentDirectory, \"shape.step\");\n\
         // Include \"unused.geo\";\nMerge \"absent.geo\"; Field[1].FileName = \"size.pos\";\n\
         Save \"out.msh\";",
    );
    let common = write(
        "parts/common.geo",
        "DefineConstant[ depth = 4 ]; Include \"../main.geo\"; Include \"more.geo\";",
    );
    let more = write("parts/more.geo", "DefineConstant[ more = 1 ];");
    let shape = write("shape.step", "DefineConstant[ no = 1 ];");
    let size = write("size.pos", "");
    let options = write("main.geo.opt", "Mesh.ElementOrder = 2;");
    write("unused.geo", "DefineConstant[ unused = 1 ];");
    write("out.msh", "");
    let script = GeoScript::scan(&main).unwrap();
    assert_eq!(names(&script), ["depth", "more"]);
    assert_eq!(script.parameters["depth"].file, common);
    let found: BTreeSet<PathBuf> = script
        .files
        .iter()
        .map(|file| file.canonicalize().unwrap())
        .collect();
    let expected = [main, common, more, shape, size, options];
    let expected: BTreeSet<PathBuf> = expected
        .iter()
        .map(|file| file.canonicalize().unwrap())
        .collect();
    assert_eq!(found, expected);
    assert_eq!(script.files.len(), 6);
}

#[test]
fn nearest_parameter_is_suggested() {
    let script = scan("DefineConstant[ element = 10, band_start = 400, band_end = 600 ];");
    assert_eq!(script.nearest("elment"), Some("element"));
    assert_eq!(script.nearest("band_strat"), Some("band_start"));
    assert_eq!(script.nearest("xyz"), None);
}

#[test]
fn a_script_that_meshes_is_told_from_one_that_sets_options() {
    assert!(scan("Mesh 2;\n").meshes);
    let script = scan("Mesh.ElementOrder = 2; // Mesh 2;\nCreateGeometry;\n");
    assert!(!script.meshes && script.creates_geometry);
}

#[test]
fn silent_traps_are_warned_of() {
    let warnings = |text: &str| scan(text).warnings;
    let lost = warnings("a = 1;\nb = 2; c = 3;");
    assert_eq!(lost.len(), 1);
    assert!(
        lost[0].contains("model.geo:2: the file does not end"),
        "{lost:?}"
    );
    let early = warnings("a = 1;\n Include \"x.geo\"; b = 2;\n");
    assert_eq!(early.len(), 1);
    assert!(
        early[0].contains("model.geo:2: Gmsh runs what follows"),
        "{early:?}"
    );
    for harmless in [
        "a = 1;\nb = 2; c = 3;\n",
        "a = 1;\nb = 2; // c = 3;",
        "Include \"x\"; // y\n",
    ] {
        assert_eq!(warnings(harmless), [""; 0]);
    }
}

#[test]
fn missing_file_is_named() {
    let error = GeoScript::scan(Path::new("nowhere/x.geo")).unwrap_err();
    assert!(error.to_string().contains("nowhere/x.geo"));
}

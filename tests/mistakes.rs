//! The most likely mistakes: each gives one message with file, line, cause and fix, exit code 2, and
//! nothing is written.

mod workplace;

use workplace::Workplace;

const BAR: &str = "bar.yaml";
const PLATE: &str = "plate.yaml";
const GEO: &str = "geo/bar.geo";

struct Mistake {
    what: &'static str,
    /// The file with it, what stood there, and what stands there now.
    file: &'static str,
    old: &'static str,
    new: &'static str,
    /// File and line, as the message has them.
    place: &'static str,
    cause: &'static str,
    fix: &'static str,
}

#[rustfmt::skip]
const MISTAKES: [Mistake; 40] = [
    Mistake {
        what: "a key is misspelt", file: BAR,
        old: "horizon:",
        new: "horizn:",
        place: "bar.yaml:15:5", cause: "unknown key `horizn`",
        fix: "did you mean `horizon`?",
    },
    Mistake {
        what: "a key stands in the wrong place", file: BAR,
        old: "model: fem",
        new: "model: fem, horizon: 3",
        place: "bar.yaml:10:", cause: "`horizon` belongs to",
        fix: "remove `horizon`",
    },
    Mistake {
        what: "a key is written twice", file: BAR,
        old: "plane: stress",
        new: "name: rod",
        place: "bar.yaml:6:1", cause: "the key `name` is written twice",
        fix: "first in line 1",
    },
    Mistake {
        what: "a key is missing", file: BAR,
        old: "materials:\n  solid: { young: 100 GPa, poisson: 1/3 }\n",
        new: "",
        place: "bar.yaml", cause: "the key `materials` is missing",
        fix: "add, say",
    },
    Mistake {
        what: "a tab indents", file: BAR,
        old: "plane: stress",
        new: "	plane: stress",
        place: "bar.yaml:6:", cause: "cannot start any token",
        fix: "indent with spaces",
    },
    Mistake {
        what: "a bracket is not closed", file: BAR,
        old: "order: 2 }",
        new: "order: 2",
        place: "bar.yaml:6:", cause: "did not find expected ',' or '}'",
        fix: "look at indentation, colons, brackets and quotes",
    },
    Mistake {
        what: "a choice is misspelt", file: BAR,
        old: "plane: stress",
        new: "plane: stres",
        place: "bar.yaml:6:8", cause: "`plane` cannot be `stres`",
        fix: "There are: `stress`, `strain`",
    },
    Mistake {
        what: "the .geo's name is misspelt", file: BAR,
        old: "geo/bar.geo",
        new: "geo/bra.geo",
        place: "bar.yaml:3:9", cause: "geo/bra.geo does not exist",
        fix: "did you mean `bar.geo`?",
    },
    Mistake {
        what: "a semicolon is missing in the .geo", file: GEO,
        old: "length = 1000;\n",
        new: "length = 1000\n",
        place: "geo/bar.geo:26:", cause: "syntax error",
        fix: "look at the lines 25 and 26",
    },
    Mistake {
        what: "the .geo includes what is not there", file: GEO,
        old: "length = 1000;\n",
        new: "length = 1000;\nInclude \"nowhere.geo\";\n",
        place: "geo/bar.geo:26", cause: "Unable to open file",
        fix: "files are sought beside the one that names them",
    },
    Mistake {
        what: "the .geo runs a command", file: GEO,
        old: "length = 1000;\n",
        new: "length = 1000;\nSystemCall \"ls\";\n",
        place: "geo/bar.geo:26:", cause: "SystemCall",
        fix: "--trust-geometry",
    },
    Mistake {
        what: "a .geo parameter is misspelt", file: BAR,
        old: "element: 50",
        new: "elment: 50",
        place: "bar.yaml:5:", cause: "no parameter 'elment'",
        fix: "did you mean 'element'?",
    },
    Mistake {
        what: "a .geo parameter is out of its choices", file: BAR,
        old: "order: 2",
        new: "order: 3",
        place: "bar.yaml:5:37", cause: "parameter 'order' of geo/bar.geo",
        fix: "must be 1 or 2, not 3",
    },
    Mistake {
        what: "elements do not divide the length", file: BAR,
        old: "element: 50",
        new: "element: 30",
        place: "bar.yaml:5:26", cause: "element = 30 mm does not divide",
        fix: "the pipeline sets element = 30, order = 2",
    },
    Mistake {
        what: "elements with nine nodes", file: GEO,
        old: "Mesh.SecondOrderIncomplete = 1",
        new: "Mesh.SecondOrderIncomplete = 0",
        place: "bar.yaml:3:9", cause: "Quadrilateral 9",
        fix: "write Mesh.SecondOrderIncomplete = 1;",
    },
    Mistake {
        what: "elements of third order", file: GEO,
        old: "Mesh.ElementOrder = order;",
        new: "Mesh.ElementOrder = 3;",
        place: "bar.yaml:3:9", cause: "the order is at most 2",
        fix: "Mesh.ElementOrder = 2;",
    },
    Mistake {
        what: "a region's group is misspelt", file: BAR,
        old: "right]",
        new: "rigth]",
        place: "bar.yaml:10:21", cause: "`rigth`",
        fix: "did you mean `right`?",
    },
    Mistake {
        what: "a load's group is misspelt", file: BAR,
        old: "group: load",
        new: "group: laod",
        place: "bar.yaml:19:", cause: "`laod`",
        fix: "did you mean `load`?",
    },
    Mistake {
        what: "a load on a surface", file: BAR,
        old: "group: load",
        new: "group: band",
        place: "bar.yaml:19:14", cause: "is a surface",
        fix: "curves and points",
    },
    Mistake {
        what: "a region is a curve", file: BAR,
        old: "group: band",
        new: "group: clamp",
        place: "bar.yaml:11:12", cause: "is no surface",
        fix: "there are: `band`, `left`, `right`",
    },
    Mistake {
        what: "two regions hold the same elements", file: BAR,
        old: "[left, right]",
        new: "[left, band]",
        place: "bar.yaml:11:12", cause: "overlap: 16 cells",
        fix: "every surface belongs to one region",
    },
    Mistake {
        what: "a material is misspelt", file: BAR,
        old: "model: fem, material: solid",
        new: "model: fem, material: sold",
        place: "bar.yaml:10:", cause: "material `sold` is not defined",
        fix: "did you mean `solid`?",
    },
    Mistake {
        what: "a modulus is negative", file: BAR,
        old: "100 GPa",
        new: "-100 GPa",
        place: "bar.yaml:8:19", cause: "not positive",
        fix: "such as `30 GPa`",
    },
    Mistake {
        what: "a quantity has another's unit", file: BAR,
        old: "100 GPa",
        new: "100 mm",
        place: "bar.yaml:8:19", cause: "is a length",
        fix: "must be a pressure",
    },
    Mistake {
        what: "a unit is misspelt", file: BAR,
        old: "100 GPa",
        new: "100 GPaa",
        place: "bar.yaml:8:19", cause: "`GPaa` is not a unit",
        fix: "kN/m",
    },
    Mistake {
        what: "the horizon is shorter than two spacings", file: BAR,
        old: "horizon: 4",
        new: "horizon: 20 mm",
        place: "bar.yaml:15:14", cause: "1.600 spacings",
        fix: "`horizon: 4`",
    },
    Mistake {
        what: "the horizon is huge", file: BAR,
        old: "horizon: 4",
        new: "horizon: 50",
        place: "bar.yaml:15:14", cause: "more than 20",
        fix: "counts spacings: `horizon: 4`",
    },
    Mistake {
        what: "the spacing is in the wrong unit", file: BAR,
        old: "12.5 mm",
        new: "12.5 nm",
        place: "bar.yaml:14:14", cause: "material points",
        fix: "larger `spacing`",
    },
    Mistake {
        what: "the spacing is missing", file: BAR,
        old: "    spacing: 12.5 mm\n",
        new: "",
        place: "bar.yaml:11:", cause: "needs a `spacing`",
        fix: "add `spacing: 0.5 mm`",
    },
    Mistake {
        what: "the coupling does not exist", file: BAR,
        old: "coupling: truss",
        new: "coupling: glue",
        place: "bar.yaml:16:11", cause: "cannot be `glue`",
        fix: "`truss`, `clip`",
    },
    Mistake {
        what: "the coupling was removed", file: BAR,
        old: "coupling: truss",
        new: "coupling: splice",
        place: "bar.yaml:16:11", cause: "`coupling` cannot be `splice`: it was removed",
        fix: "write `coupling: clip`",
    },
    Mistake {
        what: "nothing holds the body", file: BAR,
        old: "  - { group: clamp, displacement: { x: 0, y: 0 } }\n  - { group: load, traction: { x: 1.05 MPa } }\n",
        new: "  - { group: load, traction: { x: 1.05 MPa } }\n",
        place: "bar.yaml:18:", cause: "no displacement is prescribed",
        fix: "add a support",
    },
    Mistake {
        what: "the body can slide", file: BAR,
        old: "displacement: { x: 0, y: 0 }",
        new: "displacement: { x: 0 }",
        place: "bar.yaml:18:", cause: "the body can move in y freely",
        fix: "Displacements are prescribed on `clamp`",
    },
    Mistake {
        what: "two supports contradict each other", file: BAR,
        old: "  - { group: load, traction: { x: 1.05 MPa } }\n",
        new: "  - { group: load, traction: { x: 1.05 MPa } }\n  - { group: corner, displacement: { x: 1 mm } }\n",
        place: "bar.yaml:20:", cause: "`corner` prescribes 0.001 m",
        fix: "`clamp` prescribes 0 m",
    },
    Mistake {
        what: "a probe in millimetres without the unit", file: BAR,
        old: "[1000 mm, 100 mm]",
        new: "[1000, 100]",
        place: "bar.yaml:21:14", cause: "is off the body",
        fix: "a bare number is in metres",
    },
    Mistake {
        what: "a crack's curve is misspelt", file: PLATE,
        old: "cracks: [crack]",
        new: "cracks: [crac]",
        place: "plate.yaml:11:", cause: "no physical curve `crac`",
        fix: "did you mean `crack`?",
    },
    Mistake {
        what: "no strength", file: PLATE,
        old: ", tensile_strength: 2.01 MPa, compressive_strength: 20.1 MPa",
        new: "",
        place: "plate.yaml:15:", cause: "no bond can break",
        fix: "remove `loading`",
    },
    Mistake {
        what: "a strength is negative", file: PLATE,
        old: "tensile_strength: 2.01 MPa, ",
        new: "tensile_strength: -2.01 MPa, ",
        place: "plate.yaml:7:", cause: "not positive",
        fix: "greater than zero",
    },
    Mistake {
        what: "strength and energy release rate at once", file: PLATE,
        old: ", tensile_strength: 2.01 MPa, compressive_strength: 20.1 MPa",
        new: ", tensile_strength: 2 MPa, energy_release_rate: 1 J/m^2",
        place: "plate.yaml:7:", cause: "energy_release_rate",
        fix: "remove one of",
    },
    Mistake {
        what: "no steps", file: PLATE,
        old: "steps: 200",
        new: "steps: 0",
        place: "plate.yaml:15:", cause: "must not be zero",
        fix: "from 1 on",
    },
];

#[test]
fn the_forty_most_likely_mistakes_are_told_with_place_cause_and_fix() {
    for Mistake {
        what,
        file,
        old,
        new,
        place,
        cause,
        fix,
    } in MISTAKES
    {
        println!("{what}");
        let folder = Workplace::with_plate();
        folder.edit(file, old, new);
        let pipeline = if file == PLATE { PLATE } else { BAR };
        folder.assert_refused(&["run", pipeline], 2, &[place, cause, fix]);
    }
}

//! Which pictures there are, and what they show: numbers and units as they stand in the SVG, the film, the
//! steps that it goes through.

mod workplace;

use serde_json::Value;
use std::collections::BTreeSet;
use std::io::Read as _;
use workplace::Workplace;

/// The small plate with all that is drawn.
fn plate(output: &str) -> Workplace {
    let place = Workplace::with_plate();
    place.edit(
        "plate.yaml",
        "output: { every: 7, pictures: false }",
        output,
    );
    place
}

fn files(place: &Workplace, name: &str) -> BTreeSet<String> {
    let summary = place.read(&format!("results/{name}/summary.json"));
    let summary: Value = serde_json::from_slice(&summary).expect("JSON");
    let files = summary["files"].as_array().expect("files").iter();
    files
        .map(|file| file.as_str().expect("a name").to_owned())
        .collect()
}

fn pictures(place: &Workplace, name: &str) -> Vec<String> {
    let is_picture = |file: &String| {
        [".png", ".svg", ".pdf", ".gif"]
            .iter()
            .any(|e| file.ends_with(e))
    };
    files(place, name).into_iter().filter(is_picture).collect()
}

fn text(place: &Workplace, file: &str) -> String {
    String::from_utf8(place.read(file)).expect("UTF-8")
}

#[test]
fn a_fracture_run_has_the_usual_pictures_once_and_a_second_run_none() {
    let place = plate("output: { every: 7 }");
    place.call(&["run", "plate.yaml"]).succeeded();
    let expected = [
        "crack.gif",
        "damage.png",
        "displacement_x.png",
        "displacement_y.png",
        "energies.png",
        "load_displacement.png",
        "mesh.png",
        "principal_stress.png",
        "stress_xx.png",
        "stress_xy.png",
        "stress_yy.png",
    ];
    assert_eq!(pictures(&place, "plate"), expected);
    for more in ["report.html", "view.py"] {
        assert!(files(&place, "plate").contains(more), "{more}");
    }
    assert!(
        place
            .call(&["run", "plate.yaml"])
            .succeeded()
            .stages()
            .is_empty()
    );
    // What is not wanted any more goes; the solve stays.
    let fewer = "output.pictures=[von-mises, damage]";
    let ended = place
        .call(&["run", "plate.yaml", "--set", fewer])
        .succeeded();
    assert_eq!(ended.stages(), ["output"]);
    assert_eq!(
        pictures(&place, "plate"),
        ["crack.gif", "damage.png", "von_mises.png"]
    );
    let none = ["run", "plate.yaml", "--set", "output.pictures=false"];
    place.call(&none).succeeded();
    assert!(pictures(&place, "plate").is_empty());
    assert!(!files(&place, "plate").contains("report.html"));
    let only = [
        "output.pictures=false",
        "output.animation=true",
        "output.report=true",
    ];
    let only = only.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<&str> = ["run", "plate.yaml"].into_iter().chain(only).collect();
    place.call(&arguments).succeeded();
    assert_eq!(pictures(&place, "plate"), ["crack.gif"]);
    assert!(files(&place, "plate").contains("report.html"));
}

#[test]
fn a_picture_that_there_is_none_of_is_told() {
    let place = plate("output: { pictures: [mesh, stres-xx] }");
    let ended = place.call(&["run", "plate.yaml"]);
    assert_eq!(ended.code, Some(2));
    for wanted in ["stres-xx", "stress-xx", "plate.yaml"] {
        assert!(ended.err.contains(wanted), "{}", ended.err);
    }
    let place = plate("output: { pictures: 3 }");
    let ended = place.call(&["run", "plate.yaml"]);
    assert_eq!(ended.code, Some(2));
    assert!(
        ended.err.contains("must be `true` or `false` or a list"),
        "{}",
        ended.err
    );
}

/// A bar of finite elements on rollers: σ_xx is the traction everywhere, σ_yy nothing, and u_x grows to
/// σL/E = 1.05 MPa · 1 m / 100 GPa = 10.5 µm.
#[test]
fn maps_tell_the_numbers_of_uniform_tension() {
    let place = Workplace::new();
    let pd = "  - group: band\n    model: peridynamics\n    material: solid\n    spacing: 12.5 mm\n    horizon: 4\n";
    place.edit("bar.yaml", pd, "");
    place.edit(
        "bar.yaml",
        "group: [left, right]",
        "group: [left, band, right]",
    );
    place.edit(
        "bar.yaml",
        "- { group: clamp, displacement: { x: 0, y: 0 } }",
        "- { group: clamp, displacement: { x: 0 } }\n  - { group: corner, displacement: { y: 0 } }",
    );
    let all = "output.pictures=[stress-xx, stress-yy, principal-stress, von-mises, displacement-x]";
    let set = [
        "run",
        "bar.yaml",
        "--set",
        all,
        "--set",
        "output.formats=[svg, png]",
    ];
    place.call(&set).succeeded();
    for (name, symbol) in [
        (
            "stress_xx",
            "σ<tspan font-size=\"25.7\" dy=\"5.7\">xx</tspan><tspan dy=\"-5.7\"> [MPa]</tspan>",
        ),
        ("principal_stress", ">1</tspan>"),
        ("von_mises", ">vM</tspan>"),
    ] {
        let svg = text(&place, &format!("results/bar/{name}.svg"));
        assert!(svg.contains(">constant 1.050 MPa,  u × 1<"), "{name}");
        assert!(svg.contains(symbol), "{name}: {symbol}");
        assert!(svg.contains("data:image/png;base64,"));
    }
    let displacement = text(&place, "results/bar/displacement_x.svg");
    for wanted in [">min 0 µm,  max 10.50 µm,  u × 1<", "[µm]", ">x [mm]<"] {
        assert!(displacement.contains(wanted), "{wanted}");
    }
    // A paper's column: 85 mm for 1200 pixels.
    let size = |svg: &str, key: &str| -> f64 {
        let rest = svg
            .split(&format!(" {key}=\""))
            .nth(1)
            .expect("an attribute");
        let number: String = rest.chars().take_while(|c| !"m\"".contains(*c)).collect();
        number.parse().expect("a number")
    };
    assert_eq!(size(&displacement, "width"), 85.0);
    // Texts of 7 points, titles of 8, on that column.
    let points = |pixels: f64| pixels * 85.0 / 1200.0 * 72.0 / 25.4;
    let sizes = displacement.split("font-size=\"").skip(1).map(|rest| {
        let number = rest.split('"').next().expect("a value");
        points(number.parse().expect("a number"))
    });
    let sizes: Vec<f64> = sizes.collect();
    let whole = sizes
        .iter()
        .filter(|&&size| (7.0..8.2).contains(&size))
        .count();
    // The quantity's subscript is smaller.
    assert_eq!(whole + 1, sizes.len(), "{sizes:?}");
    // The frame is one closed line, which loses no side at another size.
    assert_eq!(
        displacement
            .matches("fill=\"none\" stroke=\"#26282c\"")
            .count(),
        2
    );
    // A constant field has the middle of the map.
    let png = place.read("results/bar/stress_xx.png");
    let mut reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .expect("PNG");
    let mut rgb = vec![0; reader.output_buffer_size().expect("it fits")];
    let info = reader.next_frame(&mut rgb).expect("PNG");
    assert_eq!(info.width, 1200);
    let [x, y] = [info.width as usize / 2, info.height as usize / 2];
    let start = 3 * (y * info.width as usize + x);
    let expected = peristitch::output::colour::viridis(0.5);
    let apart = (0..3).map(|k| rgb[start + k].abs_diff(expected[k])).max();
    assert!(
        apart <= Some(1),
        "{:?} for {expected:?}",
        &rgb[start..start + 3]
    );
}

/// The film goes from the last frame before the first break to the end, in one size, and holds the end.
#[test]
fn the_film_shows_the_frames_from_the_first_break_on() {
    let place = plate("output: { every: 7 }");
    place.call(&["run", "plate.yaml"]).succeeded();
    let summary: Value =
        serde_json::from_slice(&place.read("results/plate/summary.json")).expect("JSON");
    let fracture = &summary["fracture"];
    let first = fracture["first_break"]["step"].as_u64().expect("a step");
    let frames: Vec<u64> = fracture["frames"]
        .as_array()
        .expect("frames")
        .iter()
        .filter_map(Value::as_u64)
        .collect();
    let shown = 1 + frames.iter().filter(|&&step| step >= first).count();
    assert!((10..=40).contains(&shown), "{shown}");
    let gif = place.read("results/plate/crack.gif");
    assert!(gif.len() < 2_000_000);
    let mut decoder = gif::DecodeOptions::new()
        .read_info(gif.as_slice())
        .expect("a GIF");
    let size = [decoder.width(), decoder.height()];
    let mut delays = Vec::new();
    while let Some(frame) = decoder.read_next_frame().expect("readable") {
        assert_eq!([frame.width, frame.height], size);
        delays.push(frame.delay);
    }
    assert_eq!(delays.len(), shown);
    assert_eq!(delays.last(), Some(&250));
    assert!(
        delays[..shown - 1]
            .iter()
            .all(|delay| (8..=40).contains(delay))
    );
}

/// Reaction and energies as vectors, with the events named.
#[test]
fn charts_name_the_events() {
    let place =
        plate("output: { every: 1000, formats: [svg], pictures: [load-displacement, energies] }");
    place.call(&["run", "plate.yaml"]).succeeded();
    assert_eq!(
        pictures(&place, "plate"),
        ["crack.gif", "energies.svg", "load_displacement.svg"]
    );
    let summary: Value =
        serde_json::from_slice(&place.read("results/plate/summary.json")).expect("JSON");
    let chart = text(&place, "results/plate/load_displacement.svg");
    for (event, words) in [
        ("first_break", "first bond"),
        ("peak", "peak"),
        ("end", "separated"),
    ] {
        let step = &summary["fracture"][event]["step"];
        assert!(
            chart.contains(&format!(">{words}, step {step}</text>")),
            "{words}"
        );
    }
    for words in ["reaction [kN]", "grip displacement ["] {
        assert!(chart.contains(words), "{words}");
    }
    assert!(!chart.contains("<image"));
    // A dot for each step that breaks bonds, and three marks with their rims.
    let history = text(&place, "results/plate/history.csv");
    let breaking = history
        .lines()
        .skip(1)
        .filter(|line| line.split(',').nth(10) != Some("0"));
    assert_eq!(chart.matches("<circle").count(), breaking.count() + 6);
    let energies = text(&place, "results/plate/energies.svg");
    for words in [
        "elastic energy",
        "dissipated energy",
        "work of the loads",
        ">load factor<",
        "J]",
    ] {
        assert!(energies.contains(words), "{words}");
    }
}

/// A board of 8 × 8 squares, each of its own material or with four that repeat: one line of the legend for
/// each material, a dozen at most, and no two squares side by side in one colour.
#[test]
fn the_legend_of_many_regions_is_short() {
    let place = Workplace::new();
    let mut geo = String::from("SetFactory(\"OpenCASCADE\");\n");
    for k in 0..64 {
        let [i, j] = [k % 8, k / 8];
        geo += &format!("Rectangle({}) = {{{i}, {j}, 0, 1, 1}};\n", k + 1);
    }
    geo += "BooleanFragments{ Surface{1:64}; Delete; }{}\n";
    for k in 1..=64 {
        geo += &format!("Physical Surface(\"grain {k}\") = {{{k}}};\n");
    }
    geo += "Physical Curve(\"low\") = Curve In BoundingBox{-0.1, -0.1, -1, 8.1, 0.1, 1};\n\
            Physical Curve(\"high\") = Curve In BoundingBox{-0.1, 7.9, -1, 8.1, 8.1, 1};\n";
    place.write("geo/board.geo", geo);
    let board = |material: &dyn Fn(usize) -> usize| {
        let mut yaml = String::from(
            "name: board\ngeometry: { file: geo/board.geo, unit: mm }\nthickness: 1 mm\nmaterials:\n",
        );
        let materials: BTreeSet<usize> = (0..64).map(material).collect();
        for m in materials {
            yaml += &format!("  m{m}: {{ young: 30 GPa, poisson: 1/3 }}\n");
        }
        yaml += "regions:\n";
        for k in 0..64 {
            yaml += &format!(
                "  - {{ group: grain {}, model: peridynamics, material: m{}, spacing: 0.2 mm, horizon: 3 }}\n",
                k + 1,
                material(k)
            );
        }
        yaml += "boundary:\n  - { group: low, displacement: { x: 0, y: 0 } }\n\
                 \x20 - { group: high, displacement: { y: 1 µm } }\n\
                 output: { pictures: [mesh], formats: [png, svg], report: false }\n";
        place.write("board.yaml", yaml);
        place.call(&["run", "board.yaml"]).succeeded();
        let svg = text(&place, "results/board/mesh.svg");
        svg.split("<text ")
            .filter_map(|text| text.split_once('>')?.1.split('<').next())
            .filter(|text| text.contains(" points") || text.contains(" more"))
            .map(str::to_owned)
            .collect::<Vec<String>>()
    };
    let own = board(&|k| k);
    assert_eq!(own.len(), 12, "{own:?}");
    assert_eq!(own[0], "grain 1 (m0): peridynamics, 25 points");
    assert_eq!(own[11], "and 53 more");
    // Where each square is drawn: light between its dots.
    let png = place.read("results/board/mesh.png");
    let mut reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .expect("PNG");
    let mut rgb = vec![0; reader.output_buffer_size().expect("it fits")];
    let width = reader.next_frame(&mut rgb).expect("PNG").width as usize;
    let box_of = |svg: &str| -> [f64; 4] {
        let inner = svg.split("<svg x=\"").nth(1).expect("the plot");
        let number = |key: &str| -> f64 {
            let rest = if key.is_empty() {
                inner
            } else {
                inner.split(key).nth(1).expect("an attribute")
            };
            rest.split('"')
                .next()
                .expect("a value")
                .parse()
                .expect("a number")
        };
        [
            number(""),
            number("y=\""),
            number("width=\""),
            number("height=\""),
        ]
    };
    let [left, top, wide, high] = box_of(&text(&place, "results/board/mesh.svg"));
    let scale = (wide / 8.24).min(high / 8.24);
    let at = |i: usize, j: usize| {
        // The middle of the gap between four dots, in the square's middle row.
        let x = left + wide / 2.0 + scale * (i as f64 + 0.4 - 4.0);
        let y = top + high / 2.0 - scale * (j as f64 + 0.4 - 4.0);
        let start = 3 * (y as usize * width + x as usize);
        [rgb[start], rgb[start + 1], rgb[start + 2]]
    };
    for i in 0..8 {
        for j in 0..8 {
            assert_ne!(at(i, j), [255; 3]);
            if i > 0 {
                assert_ne!(at(i, j), at(i - 1, j), "{i} {j}");
            }
            if j > 0 {
                assert_ne!(at(i, j), at(i, j - 1), "{i} {j}");
            }
        }
    }
    let four = board(&|k| k % 2 + 2 * (k / 8 % 2));
    assert_eq!(four.len(), 4, "{four:?}");
    assert_eq!(four[0], "grain 1 + 15 more (m0): peridynamics, 400 points");
}

/// A pipeline chooses how much displacements are exaggerated, the ends of the colours, and titles; each
/// choice draws again and computes nothing.
#[test]
fn a_pipeline_chooses_exaggeration_colours_and_titles() {
    let place = Workplace::new();
    let run = |more: &[&str]| {
        let sets = more.iter().flat_map(|set| ["--set", set]);
        let common = [
            "run",
            "bar.yaml",
            "--set",
            "output.pictures=[stress-xx]",
            "--set",
            "output.formats=[svg]",
        ];
        let arguments: Vec<&str> = common.into_iter().chain(sets).collect();
        let ended = place.call(&arguments).succeeded();
        (text(&place, "results/bar/stress_xx.svg"), ended)
    };
    let (plain, _) = run(&[]);
    assert!(plain.contains(",  u × 1<") && plain.contains(">bar: stress σ_xx<"));
    let (chosen, ended) = run(&["output.exaggeration=500", "output.titles=false"]);
    assert_eq!(ended.stages(), ["output"]);
    assert!(chosen.contains(",  u × 500<"));
    assert!(!chosen.contains(">bar: stress σ_xx<"));
    let height = |svg: &str| -> f64 {
        let rest = svg.split("viewBox=\"0 0 ").nth(1).expect("a box");
        let number = rest
            .split('"')
            .next()
            .expect("two numbers")
            .split(' ')
            .nth(1);
        number.expect("a height").parse().expect("a number")
    };
    assert!(height(&chosen) < height(&plain) - 30.0);
    let (ranged, _) = run(&["output.colour_ranges={ stress-xx: [0 MPa, 40 MPa] }"]);
    assert!(ranged.contains(">40<") && !plain.contains(">40<"));
    for (set, message) in [
        ("output.exaggeration=-1", "exaggeration"),
        ("output.percentiles=[99, 1]", "percentiles"),
        ("output.colour_ranges={ stres-xx: [0, 1] }", "stress-xx"),
        (
            "output.colour_ranges={ stress-xx: [1 mm, 2 mm] }",
            "a length",
        ),
    ] {
        let ended = place.call(&["check", "bar.yaml", "--set", set]);
        assert_eq!(ended.code, Some(2), "{set}: {}", ended.err);
        assert!(ended.err.contains(message), "{set}: {}", ended.err);
    }
}

/// A lattice turned by 30° in a square hole of elements: no hair of white between the two, and no square
/// over the elements.
#[test]
fn a_turned_lattice_meets_its_interface_without_holes_and_teeth() {
    let place = Workplace::new();
    place.write(
        "geo/inlay.geo",
        "SetFactory(\"OpenCASCADE\"); Rectangle(1) = {0, 0, 0, 40, 40}; Rectangle(2) = {10, 10, 0, 20, 20};\n\
         BooleanFragments{ Surface{1, 2}; Delete; }{}\n\
         Physical Surface(\"inlay\") = {2}; Physical Surface(\"frame\") = {3};\n\
         Physical Curve(\"low\") = Curve In BoundingBox{-1, -0.1, -1, 41, 0.1, 1};\n\
         Physical Curve(\"high\") = Curve In BoundingBox{-1, 39.9, -1, 41, 40.1, 1};\n\
         Mesh.MeshSizeMax = 4;\n",
    );
    place.write(
        "inlay.yaml",
        "name: inlay\ngeometry: { file: geo/inlay.geo, unit: mm }\nthickness: 1 mm\n\
         materials: { m: { young: 30 GPa, poisson: 1/3 } }\n\
         regions:\n  - { group: frame, model: fem, material: m }\n\
         \x20 - { group: inlay, model: peridynamics, material: m, spacing: 1 mm, horizon: 3, angle: 30 deg }\n\
         coupling: clip\n\
         boundary:\n  - { group: low, displacement: { x: 0, y: 0 } }\n\
         \x20 - { group: high, displacement: { y: 1 µm } }\n\
         output: { pictures: [displacement-y, mesh], formats: [png], titles: false, report: false }\n",
    );
    place.call(&["run", "inlay.yaml"]).succeeded();
    let png = place.read("results/inlay/displacement_y.png");
    let mut reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .expect("PNG");
    let mut rgb = vec![0; reader.output_buffer_size().expect("it fits")];
    let info = reader.next_frame(&mut rgb).expect("PNG");
    let width = info.width as usize;
    let pixels: Vec<[u8; 3]> = rgb.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    let is_white = |p: &[u8; 3]| *p == [255; 3];
    // The body is the widest run of colour in the middle row, but for the colour bar.
    let middle = info.height as usize / 2;
    let row = &pixels[middle * width..(middle + 1) * width];
    let runs = row.split(is_white).map(<[_]>::len);
    let side = runs.max().expect("a body");
    assert!(side > 500, "{side}");
    let start = (0..width - side)
        .find(|&x| row[x..x + side].iter().all(|p| !is_white(p)))
        .expect("it was found");
    let half = side / 2;
    let mut holes = 0;
    for y in middle - half + 60..middle + half - 60 {
        holes += pixels[y * width + start + 5..y * width + start + side - 5]
            .iter()
            .filter(|p| is_white(p))
            .count();
    }
    assert_eq!(holes, 0);
}

/// The map's colours are those of the PNG to the byte, on a page as wide as a column.
#[test]
fn a_pdf_holds_the_pixels_of_the_png_on_a_column() {
    let place = Workplace::new();
    let set = [
        "output.pictures=[displacement-x]",
        "output.formats=[png, pdf]",
        "output.titles=false",
    ];
    let set = set.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<&str> = ["run", "bar.yaml"].into_iter().chain(set).collect();
    place.call(&arguments).succeeded();
    assert_eq!(
        pictures(&place, "bar"),
        ["displacement_x.pdf", "displacement_x.png"]
    );
    let pdf = place.read("results/bar/displacement_x.pdf");
    let number = |key: &str| -> f64 {
        let text = String::from_utf8_lossy(&pdf);
        let rest = text.split_once(key).expect("the key").1;
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.');
        rest[..end.expect("more follows")]
            .parse()
            .expect("a number")
    };
    // 85 mm in points.
    assert!((number("/MediaBox [0 0 ") - 85.0 / 25.4 * 72.0).abs() < 1e-3);
    let [width, height] = ["/Width ", "/Height "].map(|key| number(key) as usize);
    let marker = b"stream\n";
    let starts = (0..pdf.len() - marker.len())
        .filter(|&at| pdf[at..].starts_with(marker) && !pdf[..at].ends_with(b"end"));
    let streams: Vec<Vec<u8>> = starts
        .map(|at| {
            let mut bytes = Vec::new();
            flate2::read::ZlibDecoder::new(&pdf[at + marker.len()..])
                .read_to_end(&mut bytes)
                .expect("a deflated stream");
            bytes
        })
        .collect();
    let [content, image] = streams.as_slice() else {
        panic!("{} streams", streams.len());
    };
    assert_eq!(image.len(), 3 * width * height);
    // The place of the plot on the page [pixels].
    let content = String::from_utf8_lossy(content);
    let place_of_plot = content.lines().filter(|line| line.ends_with(" cm")).nth(1);
    let numbers = place_of_plot.expect("a place").split(' ').rev().skip(1);
    let [top, left] = numbers
        .take(2)
        .map(|number| number.parse::<usize>().expect("whole pixels"))
        .collect::<Vec<_>>()[..]
    else {
        panic!("{place_of_plot:?}");
    };
    let png = place.read("results/bar/displacement_x.png");
    let mut reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .expect("PNG");
    let mut rgb = vec![0; reader.output_buffer_size().expect("it fits")];
    let page = reader.next_frame(&mut rgb).expect("PNG").width as usize;
    // A row through the body, away from its interfaces, which are lines in the PDF.
    let row = height / 2;
    let of_png = &rgb[3 * ((top + row) * page + left)..][..3 * width];
    let of_pdf = &image[3 * row * width..][..3 * width];
    let differ = of_png.iter().zip(of_pdf).filter(|(a, b)| a != b).count();
    assert!(differ < 3 * 12, "{differ} of {}", 3 * width);
}

//! `report.html`: one file that stands alone, its texts safe, its script sound; looked at by headless Chromium
//! where there is one (`make setup` installs it, as root).

mod workplace;

use serde_json::Value;
use std::path::Path;
use std::process::Command;
use workplace::Workplace;

/// The small plate, with a comment that would be markup.
fn plate() -> Workplace {
    let place = Workplace::with_plate();
    place.edit(
        "plate.yaml",
        "output: { every: 7, pictures: false }",
        "output: { every: 7 }  # a < b & c > d, </script><script>alert(1)</script>",
    );
    let set = [
        "--set",
        "loading.until=separated",
        "--set",
        "thickness=0.5 m",
    ];
    place
        .call(&[&["run", "plate.yaml"], &set[..]].concat())
        .succeeded();
    place
}

fn html(place: &Workplace) -> String {
    String::from_utf8(place.read("results/plate/report.html")).expect("UTF-8")
}

#[test]
fn the_page_stands_alone_and_tells_what_was_run() {
    let place = plate();
    let html = html(&place);
    assert!(html.len() < 5_000_000, "{}", html.len());
    // Nothing is fetched: the one address is a name, of SVG.
    let elsewhere = html.replace("http://www.w3.org/2000/svg", "");
    for scheme in ["http:", "https:", "src=\"/", "@import", "url("] {
        assert!(!elsewhere.contains(scheme), "{scheme}");
    }
    let comment = "# a &lt; b &amp; c &gt; d, &lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;";
    assert!(html.contains(comment));
    assert!(!html.contains("<script>alert"));
    for override_ in ["loading.until=separated", "thickness=0.5 m"] {
        assert!(html.contains(override_), "{override_}");
    }
    // The geometry's text.
    assert!(html.contains("plate.geo") && html.contains("DefineConstant"));
    let summary: Value =
        serde_json::from_slice(&place.read("results/plate/summary.json")).expect("JSON");
    let fracture = &summary["fracture"];
    let cell = |name: &str, value: &str| {
        let row = format!("<th scope=\"row\">{name}</th><td class=\"number\">{value}");
        assert!(html.contains(&row), "{row}");
    };
    for (event, name) in [
        ("first_break", "first bond broken"),
        ("peak", "largest reaction"),
        ("end", "separated"),
    ] {
        cell(
            name,
            &format!("step {}: load factor ", fracture[event]["step"]),
        );
    }
    cell("bonds broken", &fracture["bonds_broken"].to_string());
    cell("thickness", "");
    cell(
        "material rock",
        "young 30 GPa, poisson 1/3, tensile strength 2.01 MPa",
    );
    cell("lattice band", "dx 1.0000e-3 m, δ 3.0000e-3 m = 3.0000 dx");
    // On a phone a name stands above its value, and no word is broken.
    assert!(html.contains("overflow-wrap: break-word") && html.contains("max-width: 40rem"));
    assert!(html.contains("prefers-color-scheme: dark"));
    cell("sizes.dofs", &summary["sizes"]["dofs"].to_string());
    for figure in [
        "Mesh and regions",
        "Stress σ_yy",
        "Largest principal stress",
        "Energies",
    ] {
        assert!(
            html.contains(&format!("<figcaption>{figure}</figcaption>")),
            "{figure}"
        );
    }
}

#[test]
fn the_same_run_gives_the_same_page() {
    let [a, b] = [plate(), plate()];
    assert!(html(&a) == html(&b));
    for file in ["crack.gif", "view.py", "energies.png", "stress_xy.png"] {
        let [a, b] = [&a, &b].map(|place| place.read(&format!("results/plate/{file}")));
        assert!(a == b, "{file}");
    }
}

/// Without a course there is no slider and no chart, and still a page.
#[test]
fn an_elastic_run_has_a_page_too() {
    let place = Workplace::new();
    place.run(&[]);
    let html = String::from_utf8(place.read("results/bar/report.html")).expect("UTF-8");
    assert!(html.contains("probe tip") && html.contains("; reference 1.05000e-5 m, error "));
    assert!(!html.contains("id=\"step\"") && !html.contains("<h2>Course</h2>"));
}

/// The page after its script has run, with what a reader would have done.
fn loaded(page: &Path) -> Option<String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let dumped = Command::new("chromium")
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--virtual-time-budget=5000",
        ])
        .arg(format!("--user-data-dir={}", folder.path().display()))
        .arg("--dump-dom")
        .arg(format!("file://{}", page.display()))
        .output();
    match dumped {
        Ok(output) => Some(String::from_utf8(output.stdout).expect("UTF-8")),
        Err(_) => {
            eprintln!("NOT CHECKED: there is no chromium; `make setup` as root installs it");
            None
        }
    }
}

/// What an element with this id holds, up to its first child.
fn told<'a>(dom: &'a str, id: &str) -> &'a str {
    let rest = dom.split(&format!("id=\"{id}\">")).nth(1);
    rest.and_then(|rest| rest.split('<').next())
        .unwrap_or_else(|| panic!("no {id}"))
}

#[test]
fn the_script_runs_and_the_slider_changes_picture_text_and_mark() {
    let place = plate();
    let page = place.path("results/plate/report.html");
    let Some(dom) = loaded(&page) else {
        return;
    };
    assert!(
        dom.contains("data-ready=\"yes\""),
        "the script did not come to its end"
    );
    let summary: Value =
        serde_json::from_slice(&place.read("results/plate/summary.json")).expect("JSON");
    let end = &summary["fracture"]["end"]["step"];
    assert!(told(&dom, "frame-text").starts_with(&format!("step {end}: load factor ")));
    assert!(told(&dom, "told").starts_with(&format!("step {end}: grip displacement = ")));
    let picture = |dom: &str| dom.split("id=\"frame\"").nth(1).expect("a frame")[..4000].to_owned();
    let mark = |dom: &str| dom.split("<circle r=\"12\"").nth(1).expect("a mark")[..160].to_owned();

    // The same page, and a hand on the slider.
    let hand = "<script>const s = document.getElementById('step'); s.value = 0; \
                s.dispatchEvent(new Event('input'));</script></body>";
    let moved = place.path("results/moved.html");
    std::fs::write(&moved, html(&place).replace("</body>", hand)).expect("writable");
    let at_begin = loaded(&moved).expect("a browser");
    let frames = summary["fracture"]["frames"].as_array().expect("frames");
    let first = summary["fracture"]["first_break"]["step"]
        .as_u64()
        .expect("a step");
    let mut before = frames
        .iter()
        .filter_map(Value::as_u64)
        .filter(|&step| step < first);
    let before = before.next_back().expect("a frame before the first break");
    assert!(told(&at_begin, "frame-text").starts_with(&format!("step {before}: ")));
    assert!(picture(&dom) != picture(&at_begin));
    assert!(mark(&dom) != mark(&at_begin));
}

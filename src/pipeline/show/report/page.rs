//! A run on one HTML page that stands alone: pictures as data URIs, a slider through the frames, the
//! history as an SVG chart, the inputs as they were. It asks nothing of the network, and follows the
//! reader's light or dark scheme.

use crate::output::markup::escape;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use std::fmt::Write as _;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The content of the page; texts as a person reads them, not escaped.
#[derive(Clone, Debug, Default)]
pub struct Report {
    pub title: String,
    /// Ending of the run, in a line.
    pub outcome: String,
    /// Name, value.
    pub numbers: Vec<[String; 2]>,
    pub frames: Vec<FramePicture>,
    /// The history's chart, and its points on the chart.
    pub chart: Option<(String, Vec<HistoryPoint>)>,
    pub pictures: Vec<Figure>,
    /// The input files of the run.
    pub inputs: Vec<Input>,
    /// Key, value: everything, for those who look for it.
    pub table: Vec<[String; 2]>,
}

/// One position of the slider.
#[derive(Clone, Debug)]
pub struct FramePicture {
    pub step: usize,
    pub text: String,
    pub png: Vec<u8>,
}

/// A step on the chart.
#[derive(Clone, Debug)]
pub struct HistoryPoint {
    pub step: usize,
    /// [pixels of the chart]
    pub at: [f64; 2],
    pub text: String,
}

#[derive(Clone, Debug)]
pub struct Figure {
    pub caption: String,
    /// `image/png` or `image/svg+xml`.
    pub kind: &'static str,
    pub bytes: Vec<u8>,
}

/// A text that was read.
#[derive(Clone, Debug)]
pub struct Input {
    pub name: String,
    pub text: String,
}

impl Report {
    /// The file's content.
    pub fn to_html(&self) -> String {
        let mut html = String::from("<!doctype html>\n<html lang=\"en\">\n<head>\n");
        html.push_str("<meta charset=\"utf-8\">\n");
        html.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
        let _ = writeln!(html, "<title>{}</title>", escape(&self.title));
        let _ = writeln!(html, "<style>\n{STYLE}</style>\n</head>\n<body>");
        let _ = writeln!(html, "<h1>{}</h1>", escape(&self.title));
        let _ = writeln!(html, "<p class=\"soft\">{}</p>", escape(&self.outcome));
        html.push_str("<h2>Key numbers</h2>\n");
        write_table(&mut html, &self.numbers);
        self.write_course(&mut html);
        self.write_pictures(&mut html);
        self.write_inputs(&mut html);
        html.push_str("<h2>Summary</h2>\n<details><summary>All numbers</summary>\n");
        write_table(&mut html, &self.table);
        html.push_str("</details>\n");
        self.write_script(&mut html);
        html.push_str("</body>\n</html>\n");
        html
    }

    /// Slider and chart, side by side.
    fn write_course(&self, html: &mut String) {
        if self.frames.is_empty() && self.chart.is_none() {
            return;
        }
        html.push_str("<h2>Fracture</h2>\n<div class=\"columns\">\n");
        if !self.frames.is_empty() {
            let _ = writeln!(
                html,
                "<figure>\n<img id=\"frame\" alt=\"damage\">\n\
                 <div class=\"slider\"><button id=\"play\" type=\"button\">Play</button>\n\
                 <input id=\"step\" type=\"range\" min=\"0\" max=\"{}\" step=\"1\" \
                 aria-label=\"frame\"></div>\n\
                 <figcaption><output id=\"frame-text\"></output></figcaption>\n</figure>",
                self.frames.len() - 1
            );
        }
        if let Some((svg, _)) = &self.chart {
            let _ = writeln!(
                html,
                "<figure class=\"chart\">\n{svg}<figcaption><output id=\"told\">Point at the curve.\
                 </output></figcaption>\n</figure>"
            );
        }
        html.push_str("</div>\n");
    }

    fn write_pictures(&self, html: &mut String) {
        if self.pictures.is_empty() {
            return;
        }
        html.push_str("<h2>Pictures</h2>\n<div class=\"columns\">\n");
        for Figure {
            caption,
            kind,
            bytes,
        } in &self.pictures
        {
            let caption = escape(caption);
            let data = STANDARD.encode(bytes);
            let _ = writeln!(
                html,
                "<figure><img alt=\"{caption}\" src=\"data:{kind};base64,{data}\">\
                 <figcaption>{caption}</figcaption></figure>"
            );
        }
        html.push_str("</div>\n");
    }

    fn write_inputs(&self, html: &mut String) {
        html.push_str("<h2>Inputs</h2>\n");
        for Input { name, text } in &self.inputs {
            let _ = writeln!(
                html,
                "<details open><summary>{}</summary>\n<pre>{}</pre></details>",
                escape(name),
                escape(text)
            );
        }
    }

    fn write_script(&self, html: &mut String) {
        let frames = self.frames.iter().map(|frame| {
            json!({ "step": frame.step, "text": frame.text, "png": STANDARD.encode(&frame.png) })
        });
        let points = self.chart.iter().flat_map(|(_, points)| points);
        let points = points.map(|point| {
            let [x, y] = point.at.map(|p| (10.0 * p).round() / 10.0);
            json!({ "step": point.step, "x": x, "y": y, "text": point.text })
        });
        let data = json!({
            "frames": frames.collect::<Vec<_>>(),
            "history": points.collect::<Vec<_>>(),
        });
        // A text that holds `</script>` must not end the element.
        let data = data.to_string().replace('<', "\\u003c");
        let _ = writeln!(
            html,
            "<script type=\"application/json\" id=\"data\">{data}</script>\n<script>\n{SCRIPT}</script>"
        );
    }
}

fn write_table(html: &mut String, rows: &[[String; 2]]) {
    html.push_str("<table>\n");
    for [name, value] in rows {
        let _ = writeln!(
            html,
            "<tr><th scope=\"row\">{}</th><td class=\"number\">{}</td></tr>",
            escape(name),
            escape(value)
        );
    }
    html.push_str("</table>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_no_markup_wherever_they_stand() {
        let evil = "<b>&\"x\"</script>".to_owned();
        let report = Report {
            title: evil.clone(),
            outcome: evil.clone(),
            numbers: vec![[evil.clone(), evil.clone()]],
            frames: vec![FramePicture {
                step: 1,
                text: evil.clone(),
                png: vec![1, 2, 3],
            }],
            pictures: vec![Figure {
                caption: evil.clone(),
                kind: "image/png",
                bytes: vec![0; 3],
            }],
            inputs: vec![Input {
                name: evil.clone(),
                text: evil.clone(),
            }],
            table: vec![[evil.clone(), evil]],
            chart: None,
        };
        let html = report.to_html();
        assert!(!html.contains("<b>"));
        assert_eq!(html.matches("</script>").count(), 2);
        assert!(html.contains("&lt;b&gt;&amp;&quot;x&quot;&lt;/script&gt;"));
        assert!(html.contains("\\u003cb>&\\\"x\\\"\\u003c/script>"));
        // The one address is SVG's name.
        let elsewhere = html.replace("http://www.w3.org/2000/svg", "");
        assert!(!elsewhere.contains("http:") && !elsewhere.contains("https:"));
    }
}

//! `peristitch verify`: the cases one after the other, and their table.

use crate::verification::{self, Check, Reference, table};
use serde_json::{Value, json};
use std::process::ExitCode;
use std::time::Instant;

/// A line per case as it is measured, then the table; fails if a check falls short.
pub(super) fn verify(quick: bool, json: bool, markdown: bool) -> ExitCode {
    let cases = verification::ladder().into_iter();
    let cases: Vec<_> = cases.filter(|case| case.is_quick || !quick).collect();
    let mut checks = Vec::new();
    let mut failed = false;
    for (number, case) in cases.iter().enumerate() {
        let start = Instant::now();
        eprint!("[{:>2}/{}] {} ... ", number + 1, cases.len(), case.name);
        match case.run() {
            Ok(measured) => {
                let short = measured.iter().filter(|check| !check.holds()).count();
                let verdict = match short {
                    0 => "holds".to_owned(),
                    short => format!("{short} of {} fall short", measured.len()),
                };
                eprintln!("{verdict} ({:.1} s)", start.elapsed().as_secs_f64());
                checks.extend(measured);
            }
            Err(error) => {
                eprintln!("failed: {error}");
                failed = true;
            }
        }
    }
    if json {
        let list: Vec<Value> = checks.iter().map(check_as_json).collect();
        println!("{:#}", Value::Array(list));
    } else if markdown {
        print!("{}", table::markdown(&checks));
    } else {
        print!("{}", table::aligned(&checks));
    }
    match failed || !checks.iter().all(Check::holds) {
        true => ExitCode::from(1),
        false => ExitCode::SUCCESS,
    }
}

fn check_as_json(check: &Check) -> Value {
    let reference = match check.reference {
        Reference::Value { value, within } => {
            json!({ "value": value, "within_relative": within })
        }
        Reference::Zero { within } => json!({ "value": 0.0, "within": within }),
        Reference::Between { low, high } => json!({ "low": low, "high": high }),
    };
    json!({
        "case": check.case,
        "quantity": check.quantity,
        "reference": reference,
        "source": check.source,
        "measured": check.measured,
        "error": check.error(),
        "holds": check.holds(),
    })
}

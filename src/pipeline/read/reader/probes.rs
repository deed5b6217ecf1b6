//! `probes`: displacements to report.

use super::Reader;
use crate::pipeline::read::plan::Probe;
use crate::pipeline::read::quantity::Dimension;
use crate::pipeline::read::source::InputError;
use crate::pipeline::read::spec;

impl Reader<'_> {
    pub(crate) fn probes(&self) -> Result<Vec<Probe>, InputError> {
        let read = |(name, probe): (&String, &spec::Probe)| self.probe(name, probe);
        self.spec.probes.iter().map(read).collect()
    }

    fn probe(&self, name: &str, probe: &spec::Probe) -> Result<Probe, InputError> {
        let key = |field: &str| format!("probes/{name}/{field}");
        let point = |field: &str, [x, y]: &[spec::Scalar; 2]| {
            let read = |k: usize, written| {
                self.quantity(&key(&format!("{field}/{k}")), written, Dimension::LENGTH)
            };
            Ok([read(0, x)?, read(1, y)?])
        };
        let points = match (&probe.at, &probe.between) {
            (Some(at), None) => vec![point("at", at)?],
            (None, Some([a, b])) => vec![point("between/0", a)?, point("between/1", b)?],
            _ => {
                let message = "a probe reads one point, `at`, or two points, `between`";
                let help = "write `at: [1 m, 0]`, or `between: [[0, 19 mm], [0, 21 mm]]` for the \
                            displacement of the second point less that of the first one";
                let place = format!("probes/{name}");
                return Err(self.source.error(&place, message, Some(help.to_owned())));
            }
        };
        let reference = probe.reference.as_ref();
        let reference = reference.map(|u| self.quantity(&key("reference"), u, Dimension::LENGTH));
        Ok(Probe {
            name: name.to_owned(),
            points,
            axis: match probe.component {
                spec::Component::X => 0,
                spec::Component::Y => 1,
            },
            reference: reference.transpose()?,
        })
    }
}

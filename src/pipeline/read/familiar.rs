//! Words of the field, or of other programs, that are no keys of a pipeline, and what to write in their
//! place.

/// Words as they are in lower case and without `_` and `-`, the key that each corresponds to, and the advice.
const FAMILIAR: [(&[&str], &str, &str); 12] = [
    (
        &[
            "criticalstretch",
            "criticalbondstretch",
            "s0",
            "sc",
            "scrit",
        ],
        "tensile_strength",
        "a critical stretch s0 follows from a strength or from an energy: write `tensile_strength: f_t` \
         with f_t = E s0, or `energy_release_rate: G0` with G0 = c0 s0² M3 (docs/method.md, sections 1 and 9)",
    ),
    (
        &[
            "kic",
            "k1c",
            "kc",
            "toughness",
            "criticalstressintensityfactor",
        ],
        "fracture_toughness",
        "write `fracture_toughness: 1 MPa m^0.5`",
    ),
    (
        &[
            "gc",
            "g0",
            "gf",
            "gic",
            "g1c",
            "fractureenergy",
            "surfaceenergy",
            "criticalenergyreleaserate",
        ],
        "energy_release_rate",
        "write `energy_release_rate: 100 J/m^2`",
    ),
    (
        &[
            "ft",
            "strength",
            "sigmat",
            "sigmac",
            "yieldstress",
            "criticalstress",
        ],
        "tensile_strength",
        "write `tensile_strength: 3 MPa`; `compressive_strength` may stand beside it",
    ),
    (
        &[
            "e",
            "youngsmodulus",
            "youngmodulus",
            "elasticmodulus",
            "modulus",
        ],
        "young",
        "write `young: 30 GPa`",
    ),
    (
        &["nu", "poissonratio", "poissonsratio"],
        "poisson",
        "write `poisson: 1/3`",
    ),
    (
        &["bulkmodulus", "shearmodulus", "lame", "lambda", "mu"],
        "young",
        "write `young` and `poisson`: E = 9 K μ/(3 K + μ), ν = E/(2 μ) − 1",
    ),
    (
        &["rho", "massdensity"],
        "density",
        "write `density: 2400 kg/m^3`",
    ),
    (
        &[
            "dx",
            "gridspacing",
            "pointspacing",
            "deltax",
            "meshsize",
            "h",
        ],
        "spacing",
        "write `spacing: 0.5 mm`, the distance between material points",
    ),
    (
        &["delta", "m", "horizonratio", "horizonradius"],
        "horizon",
        "write `horizon: 4`, in spacings, or a length, `horizon: 2 mm`",
    ),
    (
        &["influencefunction", "weightfunction", "micropotential"],
        "kernel",
        "write `kernel: quartic`, or another one of docs/method.md, section 1",
    ),
    (
        &["timestep", "dt", "damping", "velocity", "timesteps"],
        "increment",
        "the analysis is quasi-static: the load grows by `loading.increment`, or from event to event",
    ),
];

/// Advice for a word that is no key, where one of the `valid` keys corresponds to it.
pub(super) fn advice(word: &str, valid: &[&str]) -> Option<&'static str> {
    let plain = word.to_lowercase().replace(['_', '-', ' ', '\''], "");
    let fits = |(words, key, _): &&(&[&str], &str, &str)| {
        words.contains(&plain.as_str()) && (valid.contains(key) || *key == "increment")
    };
    FAMILIAR.iter().find(fits).map(|(.., advice)| *advice)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_however_they_are_spelled() {
        for word in ["K_IC", "KIC", "k_ic", "k-ic"] {
            let valid = ["young", "fracture_toughness"];
            assert_eq!(
                advice(word, &valid),
                Some("write `fracture_toughness: 1 MPa m^0.5`")
            );
            assert_eq!(advice(word, &["spacing"]), None);
        }
        assert_eq!(
            advice("Young's modulus", &["young"]),
            Some("write `young: 30 GPa`")
        );
        assert_eq!(advice("horizn", &["horizon"]), None);
    }
}

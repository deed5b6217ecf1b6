//! Scalar measures of a stress, given as xx, yy, zz, xy [Pa].

/// Largest principal stress, that out of the plane included [Pa].
pub fn largest_principal([xx, yy, zz, xy]: [f64; 4]) -> f64 {
    let radius = ((xx - yy) / 2.0).hypot(xy);
    ((xx + yy) / 2.0 + radius).max(zz)
}

/// Von Mises stress [Pa].
pub fn von_mises([xx, yy, zz, xy]: [f64; 4]) -> f64 {
    let squares = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
    (squares / 2.0 + 3.0 * xy * xy).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_of_known_states() {
        let both = |stress| [largest_principal(stress), von_mises(stress)];
        let uniaxial = [0.0, 5.0, 0.0, 0.0];
        assert_eq!(both(uniaxial), [5.0, 5.0]);
        let [principal, mises] = both([0.0, 0.0, 0.0, 2.0]);
        assert_eq!(principal, 2.0);
        // In pure shear √3 τ, one rounding each for the product and the root.
        assert!((mises - 2.0 * 3_f64.sqrt()).abs() < 1e-15);
        let hydrostatic = [-3.0, -3.0, -3.0, 0.0];
        assert_eq!(both(hydrostatic), [-3.0, 0.0]);
        // Out of the plane the stress may be the largest one.
        assert_eq!(largest_principal([-3.0, -2.0, 1.0, 0.0]), 1.0);
    }
}

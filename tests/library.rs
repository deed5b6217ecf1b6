//! The example for users of the library computes what it says.

#[allow(dead_code)]
#[path = "../examples/plate.rs"]
mod plate;

#[test]
fn the_plate_of_the_example_is_as_long_as_it_should_be() {
    let [elongation, exact] = plate::elongation().expect("a sound model");
    // Uniform strain passes the interface; the band's free edges, corrected by force, leave −0.05 % at half this
    // spacing (`cantilever_clip_q8_rollers`), twice as much here.
    let error = elongation / exact - 1.0;
    assert!((error + 1e-3).abs() < 5e-5, "{error}");
}

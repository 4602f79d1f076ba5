//! Useless lights, judged by variance × rays, which are the same on every machine; the example
//! measures time and goes farther.

use crate::variance::{self, Effort, Price};

/// The scene of a row whose pushed quantity has a value; of all its families.
fn check(row: &str, value: f64) {
    let effort = Effort { images: 6, samples_per_pixel: 16, price: Price::Rays };
    let entries = variance::all();
    let mut comparisons = 0;
    for entry in entries.iter().filter(|entry| entry.row == row && entry.value == value) {
        for comparison in variance::judge(entry, effort, 1) {
            println!("{comparison:?}");
            assert!(comparison.is_good, "{comparison:?}");
            comparisons += 1;
        }
    }
    assert!(comparisons > 0, "no scene of {row}, {value:e}");
}

macro_rules! rows {
    ($($name:ident, $row:literal, $value:literal;)*) => {$(
        #[test]
        fn $name() {
            check($row, $value);
        }
    )*};
}

rows! {
    stress_s31_variance_beside_a_useless_light, "S31", 1e4;
    stress_s76_variance_beside_a_far_pebble, "S76", 1e4;
    stress_s77_variance_of_a_hidden_light, "S77", 1.0;
    stress_s77_variance_of_ten_hidden_lights, "S77", 10.0;
    stress_s77_variance_of_hidden_lights, "S77", 1e3;
    stress_s78_variance_of_lamps_of_many_powers, "S78", 24.0;
    stress_s79_variance_of_rooms_with_a_lamp, "S79", 100.0;
    stress_s81_variance_within_a_cluster, "S81", 1e3;
    stress_s82_variance_of_clusters_far_apart, "S82", 1e6;
}

//! Tables, and numbers in them.

use crate::report::stats::Interval;
use maud::{Markup, Render, html};

/// A table with the headings of its columns; rows are [`row`]s.
pub(super) fn table(
    corner: &str,
    columns: impl IntoIterator<Item = impl Render>,
    rows: impl IntoIterator<Item = Markup>,
) -> Markup {
    html! {
        div.scroll { table {
            thead { tr {
                th { (corner) }
                @for name in columns { th scope="col" { (name) } }
            } }
            @for row in rows { (row) }
        } }
    }
}

/// A row with its heading.
pub(super) fn row(name: impl Render, cells: impl IntoIterator<Item = impl Render>) -> Markup {
    html! { tr { th scope="row" { (name) } @for cell in cells { td { (cell) } } } }
}

/// Three significant digits, in scientific notation where it is shorter.
pub(super) fn number(x: f64) -> String {
    let size = x.abs();
    match size {
        _ if x.is_nan() => "–".to_owned(),
        _ if x.is_infinite() => if x > 0.0 { "∞" } else { "−∞" }.to_owned(),
        _ if size == 0.0 => "0".to_owned(),
        _ if !(0.001..100_000.0).contains(&size) => scientific(x, 2),
        _ => {
            let digits = (2 - size.log10().floor() as i32).clamp(0, 6) as usize;
            format!("{x:.digits$}")
        }
    }
}

/// A number in scientific notation, with a minus sign in the exponent, at which a line is not
/// broken.
pub(super) fn scientific(x: f64, digits: usize) -> String {
    format!("{x:.digits$e}").replace("e-", "e−")
}

/// A share in per cent.
pub(super) fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}

/// The value, and below it the interval.
pub(super) fn interval(i: &Interval) -> Markup {
    html! {
        (number(i.value))
        @if i.low != i.high && !i.high.is_nan() {
            br; small { (number(i.low)) " … " (number(i.high)) }
        }
    }
}

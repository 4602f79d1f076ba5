//! Tables, and intervals in them.

use crate::report::stats::Interval;
use crate::report::text::number;
use maud::{Markup, Render, html};

/// A table with the headings of its columns, which scrolls by itself if it is wide; rows are
/// [`row`]s. Its label is for those who hear the page.
pub(super) fn table(
    label: &str,
    corner: &str,
    columns: impl IntoIterator<Item = impl Render>,
    rows: impl IntoIterator<Item = Markup>,
) -> Markup {
    html! {
        div.scroll role="region" aria-label=(label) tabindex="0" { table {
            thead { tr {
                th scope="col" { (corner) }
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

/// The value, and below it the interval.
pub(super) fn interval(i: &Interval) -> Markup {
    html! {
        (number(i.value))
        @if i.low != i.high && !i.high.is_nan() {
            br; small { (number(i.low)) " … " (number(i.high)) }
        }
    }
}

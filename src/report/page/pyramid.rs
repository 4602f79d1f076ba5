//! The techniques of bidirectional path tracing, as images and as a table.

use super::picture::{data_uri, exposure, shrunk};
use super::table::{number, percent, row, table};
use crate::report::result::{Layer, Pyramid};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// Images of techniques are at most so wide.
const LAYER_WIDTH: u32 = 128;

pub(super) fn pyramid(pyramid: &Pyramid, gain: f64) -> Markup {
    let bounces = |layer: &Layer| layer.technique.s + layer.technique.t - 2;
    let lengths: BTreeSet<u16> = pyramid.layers.iter().map(bounces).collect();
    html! {
        h2 { "Techniques of bidirectional path tracing" }
        p {
            "Each way (s, t) to draw a path, s vertices from the light and t from the camera. \
             Above its image as if it were alone (exposed for itself), below what multiple \
             importance sampling keeps of it (all of these together are the image). From "
            (pyramid.passes) " samples per pixel; " (number(pyramid.rays)) " rays per sample."
        }
        @for length in lengths {
            h3 { (length) " scattering event" @if length != 1 { "s" } }
            div.layer {
                @for layer in pyramid.layers.iter().filter(|layer| bounces(layer) == length) {
                    (figure(layer, gain))
                }
            }
        }
        p {
            "Energy: share of the mean luminance. Variance: of its weighted contributions over \
             that of all; techniques are correlated, so shares need not add up to 1. Rays: what \
             is saved without it. Efficiency without it: 1 / (variance × rays) of the rest, with \
             the rest's weights, over that of all; above 1 the technique does not pay. Longer \
             paths are drawn but not shown."
        }
        (shares(pyramid))
    }
}

fn figure(layer: &Layer, gain: f64) -> Markup {
    let [unweighted, weighted] =
        [&layer.unweighted, &layer.weighted].map(|image| shrunk(image, LAYER_WIDTH));
    let name = format!("({}, {})", layer.technique.s, layer.technique.t);
    let [energy, variance] = [layer.share.energy, layer.share.variance].map(|x| 100.0 * x);
    html! {
        figure {
            img src=(data_uri(&unweighted, exposure(&unweighted))) alt={ (name) " alone" };
            img src=(data_uri(&weighted, gain)) alt={ (name) " weighted" };
            figcaption {
                b { (name) }
                br; (format!("energy {energy:.1} %"))
                br; (format!("variance {variance:.1} %"))
            }
        }
    }
}

fn shares(pyramid: &Pyramid) -> Markup {
    let columns = ["scattering events", "energy", "variance", "rays", "efficiency without it"];
    let rows = pyramid.layers.iter().map(|layer| {
        let share = &layer.share;
        let without = match share.efficiency_without {
            needed if needed.is_nan() => "needed".to_owned(),
            factor => format!("× {factor:.3}"),
        };
        let [energy, variance, cost] = [share.energy, share.variance, share.cost].map(percent);
        let bounces = (share.s + share.t - 2).to_string();
        row(format!("({}, {})", share.s, share.t), [bounces, energy, variance, cost, without])
    });
    table("(s, t)", columns, rows)
}

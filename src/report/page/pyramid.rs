//! The techniques of bidirectional path tracing, as images and as a table.

use super::images::view;
use super::picture::{exposure, shrunk};
use super::table::{row, table};
use crate::report::result::{Layer, Pyramid};
use crate::report::text::{number, percent};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// Images of techniques are at most so wide.
const LAYER_WIDTH: u32 = 128;

pub(super) fn pyramid(pyramid: &Pyramid, gain: f64) -> Markup {
    let connect = |layer: &&Layer| !layer.technique.merged;
    let (connecting, merging): (Vec<_>, Vec<_>) = pyramid.layers.iter().partition(connect);
    html! {
        p {
            "Each way (s, t) to draw a path, s vertices from the light and t from the camera. \
             Above its image as if it were alone (exposed for itself), below what multiple \
             importance sampling keeps of it (all of these together are the image). From "
            (pyramid.passes) " samples per pixel; " (number(pyramid.rays)) " rays per sample."
        }
        (panel(&connecting, gain))
        @if !merging.is_empty() {
            p {
                "Techniques that merge the ends of both subpaths: the last vertex from the camera \
                 takes the light of those from the lights that lie near it."
            }
            (panel(&merging, gain))
        }
        p {
            "Energy: share of the mean luminance. Variance: of its weighted contributions over \
             that of all; techniques are correlated, so shares need not add up to 1. Rays: what \
             is saved without it. Efficiency without it: 1 / (variance × rays) of the rest, with \
             the rest's weights, over that of all; above 1 the technique does not pay. Both are \
             measured for bidirectional path tracing only. Longer paths are drawn but not shown."
        }
        (shares(pyramid))
    }
}

/// Layers of one kind, a row for each path length.
fn panel(layers: &[&Layer], gain: f64) -> Markup {
    let lengths: BTreeSet<u16> = layers.iter().map(|layer| layer.technique.bounces()).collect();
    html! {
        @for length in lengths {
            h3 { (length) " scattering event" @if length != 1 { "s" } }
            div.layer {
                @for layer in layers.iter().filter(|layer| layer.technique.bounces() == length) {
                    (figure(layer, gain))
                }
            }
        }
    }
}

fn figure(layer: &Layer, gain: f64) -> Markup {
    let [unweighted, weighted] =
        [&layer.unweighted, &layer.weighted].map(|image| shrunk(image, LAYER_WIDTH));
    let name = layer.technique.to_string();
    let [energy, variance] = [layer.share.energy, layer.share.variance].map(percent);
    html! {
        figure {
            (view(&unweighted, exposure(&unweighted), &format!("{name} alone")))
            (view(&weighted, gain, &format!("{name} weighted")))
            figcaption {
                b { (name) }
                br; "energy " (energy)
                br; "variance " (variance)
            }
        }
    }
}

fn shares(pyramid: &Pyramid) -> Markup {
    let columns = ["scattering events", "energy", "variance", "rays", "efficiency without it"];
    let rows = pyramid.layers.iter().map(|layer| {
        let share = &layer.share;
        let [cost, without] = match (share.cost, share.efficiency_without) {
            (cost, _) if cost.is_nan() => ["–"; 2].map(str::to_owned),
            (cost, needed) if needed.is_nan() => [percent(cost), "needed".to_owned()],
            (cost, factor) => [percent(cost), format!("× {}", number(factor))],
        };
        let [energy, variance] = [share.energy, share.variance].map(percent);
        let bounces = layer.technique.bounces().to_string();
        row(layer.technique.to_string(), [bounces, energy, variance, cost, without])
    });
    table("shares of the techniques", "(s, t)", columns, rows)
}

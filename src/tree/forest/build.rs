//! Puts the trees together, from the whole scene's inwards.

use super::clusters::{part, reaches};
use super::from_afar::Slabs;
use super::{Forest, Region};
use crate::geometry::{Bounds, Shape};
use crate::tree::build::cube;
use crate::tree::bvh::Bvh;
use crate::tree::rounding::{PADDING, blur};
use glam::DVec3;
use std::sync::Arc;
use web_time::Instant;

/// The most regions in a region; more are grouped.
const CHILDREN: usize = 8;

/// By how much of half its largest side the box of a region is wider than its cluster. Its tree is
/// for one that is wider by the same once more.
const MARGIN: f64 = 1.0 / 64.0;

/// A region to be made.
struct Plan {
    around: Slabs,
    /// The box that the tree is for.
    bounds: Bounds,
    parent: usize,
    alone: bool,
    contents: Contents,
    /// Primitives of regions around this one that reach into it, in order.
    intruders: Vec<u32>,
}

/// What is in a region, all in order.
enum Contents {
    Primitives(Vec<u32>),
    Clusters(Vec<Vec<u32>>),
}

impl Forest {
    /// Builds the trees; primitives are numbered in the given order.
    pub fn new(shapes: Vec<Shape>, bounds: &Bounds) -> Self {
        let start = Instant::now();
        let shapes: Arc<[Shape]> = shapes.into();
        let mut plans = vec![Plan {
            around: Slabs::around(bounds, f64::from(PADDING) * cube(bounds).1),
            bounds: *bounds,
            parent: 0,
            alone: true,
            contents: Contents::Primitives((0..shapes.len() as u32).collect()),
            intruders: Vec::new(),
        }];
        let mut regions: Vec<Region> = Vec::new();
        while let Some(plan) = plans.get_mut(regions.len()) {
            let contents = std::mem::replace(&mut plan.contents, Contents::Clusters(Vec::new()));
            let (primitives, own, clusters) = match contents {
                Contents::Primitives(primitives) => {
                    let count = primitives.len();
                    let (own, clusters) = part(&shapes, primitives, &plan.bounds);
                    (count, own, clusters)
                }
                Contents::Clusters(clusters) => {
                    (clusters.iter().map(Vec::len).sum(), Vec::new(), clusters)
                }
            };
            let intruders = std::mem::take(&mut plan.intruders);
            let Plan { around, bounds, parent, alone, .. } = *plan;
            let tree = Bvh::new(&shapes, &own, &intruders, &bounds);
            let mut outer = [own, intruders].concat();
            outer.sort_unstable();
            let inside = bounds_of(&shapes, &outer);
            let inside =
                Bounds { min: inside.min.max(bounds.min), max: inside.max.min(bounds.max) };
            let filled = Slabs::around(&inside, MARGIN * cube(&inside).1);
            let (at, first) = (regions.len(), plans.len());
            plans.extend(grouped(&shapes, clusters).into_iter().map(|contents| Plan {
                parent: at,
                alone,
                ..Plan::new(&shapes, contents, &outer)
            }));
            let children = first..plans.len();
            for i in children.clone() {
                plans[i].alone &= children.clone().all(|j| i == j || !plans[i].overlaps(&plans[j]));
            }
            let region = Region { tree, around, filled, parent, children, alone, primitives };
            regions.push(region);
        }
        Self { regions, center: cube(bounds).0, build_time: start.elapsed() }
    }
}

impl Plan {
    fn new(shapes: &[Shape], contents: Contents, outer: &[u32]) -> Self {
        let around = |cluster: &[u32]| bounds_of(shapes, cluster);
        let cluster = match &contents {
            Contents::Primitives(primitives) => around(primitives),
            Contents::Clusters(clusters) => {
                clusters.iter().fold(Bounds::EMPTY, |bounds, cluster| bounds.union(around(cluster)))
            }
        };
        let margin = MARGIN * cube(&cluster).1;
        let wide = Slabs::around(&cluster, 2.0 * margin);
        let reaches_in = |&p: &u32| reaches(&shapes[p as usize], wide.center, wide.half);
        Self {
            around: Slabs::around(&cluster, margin),
            bounds: wide.bounds(),
            parent: 0,
            alone: true,
            contents,
            intruders: outer.iter().copied().filter(reaches_in).collect(),
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        let apart = (self.around.center - other.around.center).abs();
        let reach = self.around.half + other.around.half + blur(apart.max_element());
        apart.cmple(reach).all()
    }
}

fn bounds_of(shapes: &[Shape], primitives: &[u32]) -> Bounds {
    primitives.iter().fold(Bounds::EMPTY, |b, &p| b.union(shapes[p as usize].bounds()))
}

/// Few regions to put clusters in: one each, or groups of what is side by side.
fn grouped(shapes: &[Shape], clusters: Vec<Vec<u32>>) -> Vec<Contents> {
    if clusters.len() <= CHILDREN {
        return clusters.into_iter().map(Contents::Primitives).collect();
    }
    let mut clusters: Vec<(DVec3, Vec<u32>)> = clusters
        .into_iter()
        .map(|cluster| (bounds_of(shapes, &cluster).center(), cluster))
        .collect();
    let spread = Bounds::of_points(clusters.iter().map(|(center, _)| *center));
    let axis = (spread.max - spread.min).max_position();
    clusters.sort_by(|(a, _), (b, _)| a[axis].total_cmp(&b[axis]));
    let mut groups = Vec::new();
    let size = clusters.len().div_ceil(CHILDREN);
    let mut clusters = clusters.into_iter().map(|(_, cluster)| cluster).peekable();
    while clusters.peek().is_some() {
        let mut group: Vec<Vec<u32>> = clusters.by_ref().take(size).collect();
        groups.push(match group.pop() {
            Some(only) if group.is_empty() => Contents::Primitives(only),
            last => Contents::Clusters(group.into_iter().chain(last).collect()),
        });
    }
    groups
}

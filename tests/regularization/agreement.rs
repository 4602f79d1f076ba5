//! All integrators agree in a regularised scene.

use crate::compare::{Comparison, Measured, Named, assert_measurements_agree, measure};
use crate::worlds::{self, Placement, Result, TestScene};
use pathspace::integrator::{
    Bidirectional, Depth, LightTracer, Merging, PathTracer, PhotonMapping, Regularization,
    VertexConnectionMerging,
};
use pathspace::render::{Budget, Render, Settings, render};
use pathspace::scene::Regularized;

const DEPTH: Depth = Depth { min_bounces: 1, max_bounces: Some(5) };

fn path_tracer() -> PathTracer {
    PathTracer { depth: DEPTH, ..PathTracer::default() }
}

fn assert_agree(scene: &TestScene, epsilon: f64, comparison: &Comparison) -> Result {
    let TestScene { name, world, camera } = scene;
    let mollified = Regularized::new(world, epsilon)?;
    let bidirectional = Bidirectional { depth: DEPTH, ..Bidirectional::default() };
    let light_tracer = LightTracer { depth: DEPTH, ..LightTracer::default() };
    let merging = Merging::fixed(0.02);
    let photon_mapping = PhotonMapping { depth: DEPTH, merging, ..PhotonMapping::default() };
    let vcm = VertexConnectionMerging { bidirectional, merging, ..Default::default() };
    let in_view: [Named<'_, Regularized<'_, _>>; 4] = [
        ("path tracing", &path_tracer()),
        ("bidirectional", &bidirectional),
        ("merging", &vcm),
        ("photon mapping", &photon_mapping),
    ];
    let by_itself = Regularization::fixed(light_tracer, epsilon);
    let mut measured: Vec<Measured> =
        in_view.iter().map(|named| measure(&mollified, &**camera, *named, comparison)).collect();
    measured.push(measure(world, &**camera, ("light tracing", &by_itself), comparison));
    assert_measurements_agree(name, &measured, comparison);
    Ok(())
}

#[test]
fn integrators_agree_among_mollified_lobes() -> Result {
    let comparison = Comparison { blocks: false, ..Comparison::default() };
    assert_agree(&worlds::mixtures(Placement::UNIT)?, 0.3, &comparison)?;
    assert_agree(&worlds::glass(Placement::UNIT)?, 0.3, &comparison)?;
    assert_agree(&worlds::smooth_normals(Placement::UNIT)?, 0.3, &comparison)
}

//! All integrators agree in a regularised scene.

use crate::compare::{Comparison, Measured, Named, assert_measurements_agree, measure};
use crate::worlds::{self, Placement, Result, TestScene};
use pathspace::integrator::{
    Bidirectional, Depth, LightTracer, Merging, PathTracer, PhotonMapping, Regularization,
    VertexConnectionMerging,
};
use pathspace::scene::Regularized;

/// Photon mapping and light tracing meet what comes out of the first lobe that the camera sees, which
/// is rare where it is narrow.
fn assert_agree(scene: &TestScene, epsilon: f64, bounces: u32, is_wide: bool) -> Result {
    let TestScene { name, world, camera } = scene;
    let depth = Depth { min_bounces: 1, max_bounces: Some(bounces) };
    let mollified = Regularized::new(world, epsilon)?;
    let path_tracer = PathTracer { depth, ..PathTracer::default() };
    let bidirectional = Bidirectional { depth, ..Bidirectional::default() };
    let light_tracer =
        Regularization::fixed(LightTracer { depth, ..LightTracer::default() }, epsilon);
    let merging = Merging::fixed(0.02);
    let photon_mapping = PhotonMapping { depth, merging, ..PhotonMapping::default() };
    let vcm = VertexConnectionMerging { bidirectional, merging, ..Default::default() };
    let in_view: [Named<'_, Regularized<'_, _>>; 4] = [
        ("path tracing", &path_tracer),
        ("bidirectional", &bidirectional),
        ("merging", &vcm),
        ("photon mapping", &photon_mapping),
    ];
    let in_view = &in_view[..if is_wide { 4 } else { 3 }];
    let comparison = Comparison { blocks: false, ..Comparison::default() };
    let mut measured: Vec<Measured> =
        in_view.iter().map(|named| measure(&mollified, &**camera, *named, &comparison)).collect();
    if is_wide {
        measured.push(measure(world, &**camera, ("light tracing", &light_tracer), &comparison));
    }
    assert_measurements_agree(name, &measured, &comparison);
    Ok(())
}

#[test]
fn integrators_agree_among_narrow_lobes() -> Result {
    assert_agree(&worlds::mixtures(Placement::UNIT)?, 0.2, 5, false)?;
    assert_agree(&worlds::smooth_normals(Placement::UNIT)?, 0.2, 5, false)?;
    assert_agree(&worlds::glass(Placement::UNIT)?, 0.2, 5, false)
}

#[test]
fn photons_agree_among_wide_lobes() -> Result {
    assert_agree(&worlds::mixtures(Placement::UNIT)?, 1.0, 2, true)
}

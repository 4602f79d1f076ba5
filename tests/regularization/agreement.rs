//! All integrators agree in a regularised scene.

use crate::compare::{Comparison, Measured, Named, assert_measurements_agree, measure};
use crate::scenes::{Stage, camera, lambert};
use crate::worlds::{self, Placement, Result, TestScene};
use pathspace::glam::{DAffine3, DVec3};
use pathspace::integrator::{
    Bidirectional, Depth, LightTracer, Merging, PathTracer, PhotonMapping, Regularization,
    VertexConnectionMerging,
};
use pathspace::scene::{Material, Mesh, Regularized};

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
    // Three times as many photons would take a minute.
    let target = if is_wide { 0.0035 } else { 0.0025 };
    let comparison = Comparison { blocks: false, target, ..Comparison::default() };
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
    assert_agree(&worlds::mixtures(Placement::UNIT)?, 0.2, 3, false)?;
    assert_agree(&worlds::smooth_normals(Placement::UNIT)?, 0.2, 3, false)?;
    assert_agree(&worlds::glass(Placement::UNIT)?, 0.5, 3, false)
}

#[test]
fn photons_agree_among_wide_lobes() -> Result {
    assert_agree(&worlds::mixtures(Placement::UNIT)?, 1.0, 2, true)
}

/// Waves with smooth normals over a floor under a wide lamp.
fn waves() -> TestScene {
    let mut stage = Stage::default();
    stage.square(0.0, 1.0, true, lambert(0.5));
    let mut mesh = Mesh { normals: Some(Vec::new()), ..Mesh::default() };
    let cells = 12;
    for (row, column) in (0..=cells).flat_map(|row| (0..=cells).map(move |column| (row, column))) {
        let at = |i: u32| 2.4 * f64::from(i) / f64::from(cells) - 1.2;
        let (x, y) = (at(column), at(row));
        let (height, slope) = (0.05 * (6.0 * x).sin(), 0.3 * (6.0 * x).cos());
        mesh.positions.push(DVec3::new(x, y, 1.0 + height));
        mesh.normals.get_or_insert_default().push(DVec3::new(-slope, 0.0, 1.0));
        if row < cells && column < cells {
            let (here, above) = (row * (cells + 1) + column, (row + 1) * (cells + 1) + column);
            mesh.indices.extend([[here, here + 1, above + 1], [here, above + 1, above]]);
        }
    }
    stage.mesh(&mesh, DAffine3::IDENTITY, Material::Dielectric { relative_ior: 1.33 });
    let lamp = stage.square(3.5, 2.0, false, Material::Black);
    stage.glow(lamp, 1.0);
    let eye = camera(DVec3::new(0.0, -2.0, 3.0), DVec3::ZERO, 20.0);
    TestScene { name: "waves".into(), world: stage.build(), camera: Box::new(eye) }
}

/// A radius that changes nothing within the error: shading normals, refraction, mixtures.
#[test]
fn a_small_radius_is_the_scene_without() -> Result {
    for scene in
        [waves(), worlds::mixtures(Placement::UNIT)?, worlds::smooth_normals(Placement::UNIT)?]
    {
        let TestScene { name, world, camera } = &scene;
        let plain = PathTracer::up_to(5);
        let regularized = Regularization::fixed(plain, 0.02);
        let most = if name == "waves" { 1 << 15 } else { 1 << 10 };
        let comparison = Comparison { blocks: false, most, ..Comparison::default() };
        let named: [Named<'_>; 2] = [("plain", &plain), ("regularized", &regularized)];
        let measured = named.map(|named| measure(world, &**camera, named, &comparison));
        assert_measurements_agree(name, &measured, &comparison);
    }
    Ok(())
}

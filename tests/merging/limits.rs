//! The limits of radius and of what is merged.

use crate::common::Random;
use crate::worlds::{self, Result};
use pathspace::film::{Contribution, Sample};
use pathspace::integrator::{
    Bidirectional, Caller, Integrator, Merging, Run, Stage, VertexConnectionMerging, WithNeeds,
};
use pathspace::path::Scratch;

/// With a radius of 0, or one whose square underflows, every contribution is that of bidirectional
/// path tracing to the bit.
#[test]
fn nothing_merged_is_bidirectional_path_tracing() -> Result {
    for scene in worlds::all()? {
        let bidirectional = WithNeeds::all(Bidirectional::up_to(7));
        let stage = Stage::new(&scene.world, &*scene.camera);
        let expected = contributions(&bidirectional.start(stage, &Caller)?, &*scene.camera);
        for radius in [0.0, 1e-300, 1e-170] {
            let integrator = WithNeeds::all(VertexConnectionMerging {
                bidirectional: bidirectional.integrator,
                merging: Merging { light_walks: Some(100), ..Merging::from_radius(radius) },
                correlation_aware: false,
            });
            let mut run = integrator.start(stage, &Caller)?;
            run.begin_pass(0, &Caller)?;
            let found = contributions(&run, &*scene.camera);
            assert!(found.len() > 500, "{}", scene.name);
            assert_eq!(found, expected, "{} r = {radius}", scene.name);
        }
    }
    Ok(())
}

fn contributions<'a, R: Run<'a, pathspace::scene::World>>(
    run: &R,
    camera: &dyn pathspace::endpoint::Camera,
) -> Vec<Contribution> {
    let (mut random, mut scratch, mut found) =
        (Random::new(4), Scratch::default(), Vec::<Contribution>::new());
    for _ in 0..1500 {
        let film = worlds::film_sample(camera, &mut random);
        let sample = &mut [Sample { film, sampler: &mut random }];
        run.draw(sample, &mut found, &mut Default::default(), &mut scratch);
    }
    found
}

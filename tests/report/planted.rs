//! Mistakes that are planted are found, and no others.

use super::{against, contestants, cornell_box, go_on};
use pathspace::film::{Contribution, Sample, Sink};
use pathspace::glam::UVec2;
use pathspace::integrator::{
    Bidirectional, Crew, Integrator, LightTracer, PathTracer, Run, Stage, Started, UniformArea,
};
use pathspace::math::Rgb;
use pathspace::path::{Scratch, TechniqueSet};
use pathspace::render::{Budget, Settings};
use pathspace::report::{Method, Plan, Reference, ReferencePlan, SceneInfo, study};
use pathspace::sampler::Sampler;
use pathspace::scene::{Scene, World};

/// Scales or spoils what another integrator contributes.
#[derive(Debug)]
struct Planted<I> {
    inner: I,
    factor: f64,
    /// A pixel whose contributions are not numbers.
    spoiled: Option<UVec2>,
}

/// A rendering by the inner integrator, with the mistakes.
struct PlantedRun<'a, I, R>(&'a Planted<I>, R);

impl<S: Scene + ?Sized, I: Integrator<S>> Integrator<S> for Planted<I> {
    type Run<'a>
        = PlantedRun<'a, I, I::Run<'a>>
    where
        Self: 'a,
        S: 'a;

    fn name(&self) -> &'static str {
        "planted"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, crew: &dyn Crew) -> Started<Self::Run<'a>> {
        Ok(PlantedRun(self, self.inner.start(stage, crew)?))
    }
}

impl<'a, S: Scene + ?Sized + 'a, I: Sync, R: Run<'a, S>> Run<'a, S> for PlantedRun<'a, I, R> {
    type Chunk = R::Chunk;

    fn techniques(&self) -> TechniqueSet {
        self.1.techniques()
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        chunk: &mut R::Chunk,
        scratch: &mut Scratch<'a, S>,
    ) {
        let Self(Planted { factor, spoiled, .. }, inner) = self;
        let pixels: Vec<_> = samples.iter().map(|s| s.film.raster.floor().as_uvec2()).collect();
        let mut spoil = |number: usize, contribution: &Contribution| {
            let mut contribution = *contribution;
            contribution.value *= *factor;
            if *spoiled == Some(pixels[number]) {
                contribution.value = Rgb::new(f64::NAN, 1.0, 1.0);
            }
            sink.add(number, &contribution);
        };
        inner.draw(samples, &mut spoil, chunk, scratch);
    }
}

/// A study with all that `compare` has by default but its budget: 8 runs of the four integrators,
/// to the scene's own depth, and a reference of twice 16 runs. Its 10 s for an integrator are at
/// least half a million samples of bidirectional path tracing, and its 20 s a reference of three
/// million; here are a quarter and one million. Uniform-area sampling is too noisy to tell, as its
/// standard error says.
#[test]
fn a_bias_of_half_a_percent_is_flagged_and_none_is_not() {
    let scene = cornell_box(64);
    assert_eq!(scene.max_bounces, None);
    let (paths, light, both) =
        (PathTracer::default(), LightTracer::default(), Bidirectional::default());
    let uniform = UniformArea::default();
    let bright_light = Planted { inner: light, factor: 1.005, spoiled: None };
    let bright_both = Planted { inner: both, factor: 1.005, spoiled: None };
    let settings = Settings { seed: 1, ..Plan::default().settings };
    let halves = contestants::<World>(&[("bidirectional", &both), ("path-tracing", &paths)]);
    let plan = ReferencePlan { budget: Budget::Samples(256), runs: 16, settings };
    let reference = Reference::render(
        &scene.world,
        &*scene.camera,
        [&halves[0], &halves[1]],
        &plan,
        &mut go_on,
    )
    .unwrap();
    let plan = Plan { budget: Budget::Samples(64), settings, ..Plan::default() };
    assert_eq!(plan.seeds, 8);
    let planted: [(&str, &dyn Method<World>, &dyn Method<World>); 2] =
        [("light-tracing", &bright_light, &both), ("bidirectional", &light, &bright_both)];
    for (name, light, both) in planted {
        let all = contestants(&[
            ("path-tracing", &paths),
            ("light-tracing", light),
            ("uniform-area", &uniform),
            ("bidirectional", both),
        ]);
        let info = SceneInfo::default();
        let report =
            study(&scene.world, &*scene.camera, &info, &all, reference.clone(), &plan, &mut go_on)
                .unwrap()
                .report;
        report.methods.iter().for_each(|m| println!("{name} planted, {}: {:?}", m.name, m.bias));
        let flagged: Vec<&str> =
            report.methods.iter().filter(|m| m.bias.flagged).map(|m| m.name.as_str()).collect();
        assert_eq!(flagged, [name]);
        let bias = report.methods.iter().find(|m| m.name == name).unwrap().bias;
        assert!((bias.relative - 0.005).abs() < 4.0 * bias.relative_standard_error, "{bias:?}");
        assert!(
            !report.is_clean()
                && report.verdicts().iter().any(|v| v.starts_with(&format!("BIAS: {name}")))
        );
    }
}

#[test]
fn a_pixel_that_is_not_a_number_is_counted() {
    let scene = cornell_box(16);
    let planted =
        Planted { inner: PathTracer::up_to(2), factor: 1.0, spoiled: Some(UVec2::new(3, 9)) };
    let honest = PathTracer::up_to(2);
    let report = against::<World>(
        &scene.world,
        &*scene.camera,
        &[("honest", &honest), ("planted", &planted)],
        0.2,
        16,
        2,
    );
    assert_eq!(report.methods[0].non_finite_contributions, 0);
    let planted = &report.methods[1];
    assert!(planted.non_finite_contributions > 0 && !report.is_clean());
    assert!(
        report.verdicts().iter().any(|v| v.starts_with("NOT FINITE: ") && v.contains("(3, 9)")),
        "{:?}",
        report.verdicts()
    );
    assert!(planted.first_non_finite.as_ref().unwrap().contains("(3, 9)"), "{planted:?}");
}

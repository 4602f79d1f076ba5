//! A lens that is a point needs no numbers, and everything else is the same as if they had been
//! drawn.

use super::{DEPTH, contributions_with, rooms};
use glam::{DVec2, UVec2};
use pathspace::gallery;
use pathspace::integrator::{Bidirectional, LightTracer, PathTracer};
use pathspace::path::Roulette;
use pathspace::sampler::{AnySource, SampleSource, Sampler, SamplerKind, Stream};
use std::sync::atomic::{AtomicU32, Ordering};

/// Draws what may be skipped.
struct Drawing(AnySource);
struct DrawingSampler<P>(P);

impl SampleSource for Drawing {
    type Sampler = DrawingSampler<<AnySource as SampleSource>::Sampler>;
    fn sampler(&self, pixel: u32, pass: u32) -> Self::Sampler {
        DrawingSampler(self.0.sampler(pixel, pass))
    }
}

impl<P: Sampler> Sampler for DrawingSampler<P> {
    fn next_1d(&mut self) -> f64 {
        self.0.next_1d()
    }
    fn next_2d(&mut self) -> DVec2 {
        self.0.next_2d()
    }
    fn stream(&mut self, stream: Stream) {
        self.0.stream(stream);
    }
}

/// Counts numbers and points that are drawn for the lens.
struct Counting<'a>(AnySource, &'a AtomicU32);
struct CountingSampler<'a, P>(P, &'a AtomicU32, bool);

impl<'a> SampleSource for Counting<'a> {
    type Sampler = CountingSampler<'a, <AnySource as SampleSource>::Sampler>;
    fn sampler(&self, pixel: u32, pass: u32) -> Self::Sampler {
        CountingSampler(self.0.sampler(pixel, pass), self.1, false)
    }
}

impl<P: Sampler> CountingSampler<'_, P> {
    fn count(&self) {
        self.1.fetch_add(u32::from(self.2), Ordering::Relaxed);
    }
}

impl<P: Sampler> Sampler for CountingSampler<'_, P> {
    fn next_1d(&mut self) -> f64 {
        self.count();
        self.0.next_1d()
    }
    fn next_2d(&mut self) -> DVec2 {
        self.count();
        self.0.next_2d()
    }
    fn skip_1d(&mut self) {
        self.0.skip_1d();
    }
    fn skip_2d(&mut self) {
        self.0.skip_2d();
    }
    fn stream(&mut self, stream: Stream) {
        self.2 = matches!(stream, Stream::Lens | Stream::LensSampling(_));
        self.0.stream(stream);
    }
}

#[test]
fn a_pinhole_draws_no_numbers_and_changes_none() {
    let scene = gallery::build("cornell-box", UVec2::splat(8)).expect("a scene");
    // Roulette draws a number after those of the lens.
    let roulette = Roulette { start: 0, ..Roulette::default() };
    let samples = 100;
    macro_rules! compare {
        ($integrator:expr) => {
            for kind in [SamplerKind::Independent, SamplerKind::Stratified, SamplerKind::Sobol] {
                let source = kind.source(3, samples);
                let (skipping, _) = contributions_with(
                    &source,
                    &scene.world,
                    &*scene.camera,
                    &$integrator,
                    samples,
                );
                let (drawing, _) = contributions_with(
                    &Drawing(source),
                    &scene.world,
                    &*scene.camera,
                    &$integrator,
                    samples,
                );
                assert!(!skipping.is_empty() && skipping == drawing, "{kind:?}");
            }
        };
    }
    compare!(PathTracer { depth: DEPTH, roulette, ..PathTracer::default() });
    compare!(LightTracer { depth: DEPTH, roulette });
    compare!(Bidirectional { depth: DEPTH, roulette, ..Bidirectional::default() });

    let drawn = |camera: &(dyn pathspace::endpoint::Camera + Send)| {
        let count = AtomicU32::new(0);
        let source = Counting(SamplerKind::Sobol.source(3, samples), &count);
        contributions_with(
            &source,
            &scene.world,
            camera,
            &Bidirectional { depth: DEPTH, ..Bidirectional::default() },
            samples,
        );
        count.into_inner()
    };
    assert_eq!(drawn(&rooms::camera()), 0);
    assert!(drawn(&rooms::lens_camera()) > 2 * samples);
}

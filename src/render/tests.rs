//! The driver with a scene, a camera and integrators that are nothing but arithmetic.

use super::*;
use crate::bsdf::{Bsdf, BsdfSample, Lobes, TransportMode};
use crate::endpoint::{DirectionSample, Endpoint, Light, LightId, PointSample};
use crate::film::{
    Contribution, FilmError, FilmRegion, FilmSample, Filter, Sample, Sink, Technique,
};
use crate::geometry::SurfacePoint;
use crate::integrator::{Crew, IntegratorError, Run, Stage, Started};
use crate::math::{PerArea, PerProjected, Rgb};
use crate::path::Scratch;
use crate::sampler::{Independent, Sampler, SamplerKind, Stream};
use crate::scene::Needs;
use glam::{DVec2, DVec3, UVec2};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::ThreadId;

struct Nothing;

impl Bsdf for Nothing {
    fn lobes(&self) -> Lobes {
        Lobes::NONE
    }
    fn eval(&self, _: DVec3, _: DVec3) -> Rgb {
        Rgb::BLACK
    }
    fn pdf(&self, _: DVec3, _: DVec3, _: TransportMode) -> PerProjected {
        PerProjected(0.0)
    }
    fn sample(&self, _: DVec3, _: TransportMode, _: f64, _: DVec2) -> Option<BsdfSample> {
        None
    }
}

impl Scene for Nothing {
    type Bsdf<'a> = Nothing;
    type Light = dyn Light;
    fn intersect(&self, _: &SurfacePoint, _: DVec3) -> Option<SurfacePoint> {
        None
    }
    fn visible(&self, _: &SurfacePoint, _: &SurfacePoint) -> bool {
        true
    }
    fn bsdf(&self, _: &SurfacePoint) -> Nothing {
        Nothing
    }
    fn light_at(&self, _: &SurfacePoint) -> Option<LightId> {
        None
    }
    fn light(&self, _: LightId) -> &Self::Light {
        unreachable!("no light has an id")
    }
    fn pick_light(&self, _: f64) -> Option<(LightId, f64)> {
        None
    }
    fn pick_pmf(&self, _: LightId) -> f64 {
        0.0
    }
    fn needs(&self) -> Needs {
        Needs::NONE
    }
}

struct FilmOnly(FilmRegion);

impl Endpoint for FilmOnly {
    fn sample_point(&self, _: f64, _: DVec2) -> Option<PointSample> {
        None
    }
    fn point_pdf(&self, _: &SurfacePoint) -> PerArea {
        PerArea(0.0)
    }
    fn sample_direction(&self, _: &SurfacePoint, _: DVec2) -> Option<DirectionSample> {
        None
    }
    fn direction_pdf(&self, _: &SurfacePoint, _: DVec3) -> PerProjected {
        PerProjected(0.0)
    }
    fn emit(&self, _: &SurfacePoint, _: DVec3) -> Rgb {
        Rgb::BLACK
    }
}

impl Camera for FilmOnly {
    fn film(&self) -> FilmRegion {
        self.0
    }
    fn raster(&self, _: &SurfacePoint, _: DVec3) -> Option<DVec2> {
        None
    }
}

/// The contribution of an [`Arithmetic`] integrator to a sample.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Radiance 0.7 everywhere, by camera walks.
    Constant,
    /// The same as splats: points uniform on the film and a margin around it, recorded at `p -
    /// offset`.
    ConstantSplat { margin: f64 },
    /// A function of the position by camera walks, and splats elsewhere.
    Mixed,
    /// Uniform in [0, 2), independent in all samples: mean 1, variance 1/3.
    Noise,
    /// `Constant`, but not a number in pixel (3, 2) of the film.
    Invalid,
    /// Panics on all threads but this one, which waits for that.
    Panic(ThreadId),
    /// `Constant`, by work that threads take from each other.
    #[cfg(feature = "parallel")]
    Nested,
}

static HAS_PANICKED: AtomicBool = AtomicBool::new(false);

#[derive(Debug)]
struct Arithmetic(Kind);

impl<S: Scene + ?Sized> Integrator<S> for Arithmetic {
    type Run<'a>
        = (Kind, FilmRegion)
    where
        S: 'a;

    fn name(&self) -> &'static str {
        "arithmetic"
    }

    fn start<'a>(&'a self, stage: Stage<'a, S>, _: &dyn Crew) -> Started<(Kind, FilmRegion)> {
        Ok((self.0, stage.film))
    }
}

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for (Kind, FilmRegion) {
    type Chunk = ();

    fn techniques(&self) -> TechniqueSet {
        TechniqueSet::NONE
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        _: &mut (),
        scratch: &mut Scratch<'a, S>,
    ) {
        scratch.counters.samples += samples.len() as u64;
        for (number, Sample { film, sampler }) in samples.iter_mut().enumerate() {
            let mut add = |raster, value, s, t| {
                let technique = Technique::new(s, t);
                sink.add(number, &Contribution { raster, value, weight: 1.0, technique });
            };
            self.0.draw(self.1, *film, sampler, &mut add, &mut scratch.counters);
        }
    }
}

impl Kind {
    fn draw<P: Sampler>(
        self,
        region: FilmRegion,
        film: FilmSample,
        sampler: &mut P,
        add: &mut dyn FnMut(DVec2, Rgb, u16, u16),
        counters: &mut Counters,
    ) {
        sampler.stream(Stream::Emission);
        match self {
            Kind::Constant => add(film.raster, Rgb::splat(0.7), 0, 2),
            Kind::ConstantSplat { margin } => {
                let size = region.window_size().as_dvec2();
                let p = region.window_min.as_dvec2() - margin
                    + sampler.next_2d() * (size + 2.0 * margin);
                let area = (size + 2.0 * margin).element_product() / size.element_product();
                add(p - film.offset, Rgb::splat(0.7 * area), 1, 1);
            }
            Kind::Mixed => {
                let seen = film.raster + film.offset;
                add(
                    film.raster,
                    Rgb::new(seen.x.sin() + 1.1, seen.y.cos() + 1.1, sampler.next_1d()),
                    0,
                    2,
                );
                for vertex in 0..3 {
                    sampler.stream(Stream::LightVertex(vertex));
                    let u = sampler.next_2d();
                    add(
                        u * region.resolution.as_dvec2() - film.offset,
                        Rgb::splat(sampler.next_1d() / 3.0),
                        1,
                        1,
                    );
                }
                counters.ledger.emitted += Rgb::splat(sampler.next_1d());
            }
            Kind::Noise => add(film.raster, Rgb::splat(2.0 * sampler.next_1d()), 0, 2),
            Kind::Invalid => {
                let value =
                    if film.raster.floor() == DVec2::new(3.0, 2.0) { f64::NAN } else { 0.7 };
                add(film.raster, Rgb::splat(value), 0, 2);
            }
            Kind::Panic(thread) if thread == std::thread::current().id() => {
                while !HAS_PANICKED.load(Ordering::Relaxed) {
                    std::thread::yield_now();
                }
            }
            Kind::Panic(_) => {
                HAS_PANICKED.store(true, Ordering::Relaxed);
                panic!("as it should");
            }
            #[cfg(feature = "parallel")]
            Kind::Nested => {
                let (a, b) = rayon::join(|| 0.3, || 0.4);
                add(film.raster, Rgb::splat(a + b), 0, 2);
            }
        }
    }
}

fn window() -> FilmRegion {
    FilmRegion {
        resolution: UVec2::new(80, 60),
        window_min: UVec2::new(3, 2),
        window_max: UVec2::new(70, 57),
    }
}

fn gaussian() -> Filter {
    Filter::Gaussian { standard_deviation: 0.5 }
}

fn run(kind: Kind, region: FilmRegion, settings: &Settings) -> Rendering {
    render(&Nothing, &FilmOnly(region), &Arithmetic(kind), settings).unwrap()
}

#[test]
fn the_image_is_the_same_to_the_bit_for_any_number_of_threads() {
    let bits = |r: &Rendering| {
        r.image.pixels().iter().flat_map(|p| p.0.map(f64::to_bits)).collect::<Vec<_>>()
    };
    for sampler in [SamplerKind::Independent, SamplerKind::Stratified, SamplerKind::Sobol] {
        for filter in [Filter::Box, Filter::Tent, gaussian()] {
            let settings = Settings {
                budget: Budget::Samples(3),
                seed: 5,
                threads: Some(1),
                filter,
                sampler,
                ..Settings::default()
            };
            let reference = run(Kind::Mixed, window(), &settings);
            assert_eq!(
                (reference.samples_per_pixel, reference.stopped, reference.integrator),
                (3, false, "arithmetic")
            );
            assert_eq!(reference.counters.samples, 3 * 67 * 55);
            for threads in [Some(2), Some(7), None] {
                let other = run(Kind::Mixed, window(), &Settings { threads, ..settings });
                assert_eq!(bits(&other), bits(&reference), "{sampler:?} {filter:?} {threads:?}");
                assert_eq!(other.counters, reference.counters);
            }
            assert_ne!(
                bits(&run(Kind::Mixed, window(), &Settings { seed: 6, ..settings })),
                bits(&reference)
            );
        }
    }
}

#[test]
fn a_constant_image_is_constant_up_to_the_border() {
    // At large coordinates raster = pixel + u rounds most.
    let far = FilmRegion {
        resolution: UVec2::splat(u32::MAX),
        window_min: UVec2::splat(u32::MAX - 40),
        window_max: UVec2::splat(u32::MAX),
    };
    for region in [FilmRegion::full(UVec2::new(17, 5)), window(), far, FilmRegion::full(UVec2::ONE)]
    {
        for filter in [Filter::Box, Filter::Tent, gaussian()] {
            for sampler in [SamplerKind::Independent, SamplerKind::Sobol, SamplerKind::Stratified] {
                let image = run(
                    Kind::Constant,
                    region,
                    &Settings {
                        budget: Budget::Samples(7),
                        filter,
                        sampler,
                        ..Settings::default()
                    },
                )
                .image;
                for p in image.pixels() {
                    assert!(
                        (0..3).all(|c| (p[c] - 0.7).abs() < 1e-15),
                        "{region:?} {filter:?} {p:?}"
                    );
                }
            }
        }
    }
}

/// Light walks that land around the film too fill its border like its middle: mean over the window,
/// over its outermost pixels, and of a film without margin and box filter. Per pixel and sample the
/// value is Poisson-like with mean and variance about 0.7 · 0.7 · area ratio.
#[test]
fn splats_conserve_energy_and_keep_the_border_bright() {
    let n = 256;
    for filter in
        [Filter::Box, Filter::Tent, gaussian(), Filter::Gaussian { standard_deviation: 1.5 }]
    {
        let region = FilmRegion {
            resolution: UVec2::new(40, 30),
            window_min: UVec2::new(5, 5),
            window_max: UVec2::new(25, 21),
        };
        let margin = filter.kernel().unwrap().reach();
        let settings = Settings { budget: Budget::Samples(n), filter, ..Settings::default() };
        let image = run(Kind::ConstantSplat { margin }, region, &settings).image;
        let (w, h) = (image.width(), image.height());
        let border: Vec<f64> = (0..w * h)
            .filter(|i| [0, w - 1].contains(&(i % w)) || [0, h - 1].contains(&(i / w)))
            .map(|i| image.pixels()[i as usize].g())
            .collect();
        let area = (20.0 + 2.0 * margin) * (16.0 + 2.0 * margin) / 320.0;
        let error = |pixels: f64| 5.0 * 0.7 * (area / (f64::from(n) * pixels)).sqrt();
        assert!(
            (image.mean().g() - 0.7).abs() < error(f64::from(w * h)).max(1e-12),
            "{filter:?} {:?}",
            image.mean()
        );
        let mean = border.iter().sum::<f64>() / border.len() as f64;
        assert!((mean - 0.7).abs() < error(border.len() as f64), "{filter:?} border {mean}");
    }
}

#[test]
fn progress_can_stop_and_sees_the_image() {
    let mut fractions = Vec::new();
    let settings = Settings { budget: Budget::Samples(8), ..Settings::default() };
    let stopped = render_with_progress(
        &Nothing,
        &FilmOnly(window()),
        &Arithmetic(Kind::Constant),
        &settings,
        &mut |p: &Progress<'_>| {
            assert!((p.image().mean().r() - 0.7).abs() < 1e-12);
            assert_eq!(
                p.counters.samples,
                u64::from(p.passes) * u64::from(p.film.region().pixels())
            );
            fractions.push(p.fraction);
            if p.passes == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        },
    )
    .unwrap();
    assert_eq!(fractions, [0.125, 0.25, 0.375]);
    assert_eq!((stopped.stopped, stopped.samples_per_pixel), (true, 3));
    assert!((stopped.image.mean().r() - 0.7).abs() < 1e-12);
    // A prefix of a longer rendering is that shorter rendering.
    let shorter =
        run(Kind::Constant, window(), &Settings { budget: Budget::Samples(3), ..settings });
    assert_eq!(shorter.image, stopped.image);
}

/// Although threads begin with the next pass before.
#[test]
fn what_progress_sees_is_the_same_to_the_bit_for_any_number_of_threads() {
    let passes = |threads| {
        let settings = Settings { budget: Budget::Samples(6), threads, ..Settings::default() };
        let mut seen = Vec::new();
        let mut look = |p: &Progress<'_>| {
            seen.push((p.passes, p.film.sums().collect::<Vec<_>>(), *p.counters));
            if p.passes == 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let rendering = render_with_progress(
            &Nothing,
            &FilmOnly(window()),
            &Arithmetic(Kind::Mixed),
            &settings,
            &mut look,
        )
        .unwrap();
        let sums: Vec<_> = rendering.film.sums().collect();
        assert_eq!((sums, rendering.counters), (seen[4].1.clone(), seen[4].2));
        seen
    };
    let reference = passes(Some(1));
    assert!(reference.iter().map(|(pass, ..)| *pass).eq(1..=5));
    for threads in [Some(2), Some(7), None] {
        assert_eq!(passes(threads), reference, "{threads:?}");
    }
}

#[cfg(feature = "parallel")]
#[test]
fn a_panic_of_another_thread_ends_the_rendering() {
    let settings = Settings { budget: Budget::Samples(3), threads: Some(3), ..Settings::default() };
    let kind = Kind::Panic(std::thread::current().id());
    let ended = catch_unwind(AssertUnwindSafe(|| run(kind, window(), &settings)));
    assert_eq!(ended.unwrap_err().downcast_ref(), Some(&"as it should"));
}

/// A thread that waits for a part of its own work takes up other work meanwhile, of this rendering
/// too.
#[cfg(feature = "parallel")]
#[test]
fn integrators_may_share_their_work_out() {
    let settings = Settings { budget: Budget::Samples(3), ..Settings::default() };
    let image = run(Kind::Constant, window(), &settings).image;
    for threads in [None, Some(1), Some(2), Some(5)] {
        assert_eq!(run(Kind::Nested, window(), &Settings { threads, ..settings }).image, image);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(pool.install(|| run(Kind::Nested, window(), &settings)).image, image);
}

#[test]
fn a_time_budget_is_kept_and_gives_at_least_one_pass() {
    let one = run(
        Kind::Mixed,
        window(),
        &Settings { budget: Budget::Time(Duration::ZERO), ..Settings::default() },
    );
    assert_eq!(one.samples_per_pixel, 1);
    let limit = Duration::from_millis(200);
    let timed = run(
        Kind::Mixed,
        window(),
        &Settings { budget: Budget::Time(limit), ..Settings::default() },
    );
    let average = timed.wall / timed.samples_per_pixel;
    // The end is a pass's end; a busy machine may make the last pass long, so only gross violations
    // fail.
    assert!(
        timed.wall + 2 * average >= limit && timed.wall < 10 * limit,
        "{:?} {:?}",
        timed.wall,
        average
    );
    assert!(timed.samples_per_pixel > 1 && timed.thread_time > Duration::ZERO);
    // The sum does not depend on why it ended.
    let counted = run(
        Kind::Mixed,
        window(),
        &Settings { budget: Budget::Samples(timed.samples_per_pixel), ..Settings::default() },
    );
    assert_eq!(counted.image, timed.image);
    // Deciding: 3 s after 3 passes; a fourth would end at 4 s.
    let spent = |limit| {
        Budget::Time(Duration::from_secs_f64(limit)).is_spent(
            3,
            Duration::from_secs(3),
            Duration::ZERO,
        )
    };
    assert!(spent(3.4) && !spent(3.6));
    assert!(Budget::Time(Duration::MAX).is_spent(u32::MAX, Duration::ZERO, Duration::ZERO));
}

#[test]
fn a_target_error_is_reached_with_the_samples_that_it_takes() {
    // relMSE = 1/3 / N / 1.01, which is 0.01 for N = 33.003.
    let settings = Settings {
        budget: Budget::Samples(1000),
        target_error: Some(0.01),
        sampler: SamplerKind::Independent,
        ..Settings::default()
    };
    let rendering = run(Kind::Noise, window(), &settings);
    let samples = rendering.samples_per_pixel;
    assert!((32..=35).contains(&samples) && !rendering.stopped, "{samples}");
    let squares: f64 = rendering.image.pixels().iter().map(|p| (p.r() - 1.0).powi(2)).sum();
    let error = squares / rendering.image.pixels().len() as f64 / 1.01;
    // 3685 pixels know it to 2.3 %.
    assert!(
        (rendering.estimated_error.unwrap() / error - 1.0).abs() < 0.1,
        "{error} {:?}",
        rendering.estimated_error
    );
    // The budget is the limit, an image without noise ends as soon as it is believed, and the
    // callback sees how near the end is.
    let short = run(Kind::Noise, window(), &Settings { budget: Budget::Samples(20), ..settings });
    assert!(short.samples_per_pixel == 20 && short.estimated_error.unwrap() > 0.01);
    assert_eq!(run(Kind::Constant, window(), &settings).samples_per_pixel, 8);
    let mut fractions = Vec::new();
    let watch = &mut |p: &Progress<'_>| {
        fractions.push(p.fraction);
        ControlFlow::Continue(())
    };
    render_with_progress(&Nothing, &FilmOnly(window()), &Arithmetic(Kind::Noise), &settings, watch)
        .unwrap();
    assert!(
        fractions.is_sorted()
            && fractions[6] == 0.007
            && fractions[15] > 0.4
            && fractions.last() == Some(&1.0),
        "{fractions:?}"
    );
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let settings = Settings { target_error: Some(bad), ..Settings::default() };
        let error =
            render(&Nothing, &FilmOnly(window()), &Arithmetic(Kind::Noise), &settings).unwrap_err();
        assert!(error.to_string().contains("target error"), "{error}");
    }
}

#[test]
fn non_finite_contributions_are_reported_with_their_sample() {
    for threads in [1, 2] {
        let settings =
            Settings { budget: Budget::Samples(4), threads: Some(threads), ..Settings::default() };
        let rendering = run(Kind::Invalid, window(), &settings);
        assert_eq!(rendering.counters.non_finite, 4);
        assert_eq!(rendering.non_finite().by_technique(), [(Technique::new(0, 2), 4)]);
        let first = rendering.non_finite().first().unwrap();
        assert_eq!((first.pixel, first.pixel_index, first.pass), (UVec2::new(3, 2), 0, 0));
        assert_eq!(rendering.image.get(0, 0), Some(Rgb::BLACK));
        assert!(rendering.image.pixels()[1..].iter().all(|p| (p.r() - 0.7).abs() < 1e-15));
    }
}

#[test]
fn invalid_settings_are_errors() {
    let render_film = |region, settings: Settings| {
        render(&Nothing, &FilmOnly(region), &Arithmetic(Kind::Constant), &settings).unwrap_err()
    };
    let base = Settings::default();
    assert_eq!(
        render_film(window(), Settings { budget: Budget::Samples(0), ..base }),
        RenderError::NoSamples
    );
    assert_eq!(
        render_film(window(), Settings { threads: Some(0), ..base }),
        RenderError::NoThreads
    );
    let filter = Filter::Gaussian { standard_deviation: 0.1 };
    assert!(matches!(render_film(window(), Settings { filter, ..base }), RenderError::Filter(_)));
    let empty = FilmRegion::full(UVec2::ZERO);
    let error = render_film(empty, base);
    assert_eq!(error, RenderError::Film(FilmError::Window(empty)));
    assert!(error.to_string().contains("window") && std::error::Error::source(&error).is_some());
}

#[test]
fn integrators_are_comparable_as_objects() {
    let integrators: [&dyn Render<Nothing>; 2] =
        [&Arithmetic(Kind::Constant), &Arithmetic(Kind::ConstantSplat { margin: 0.0 })];
    let settings = Settings { budget: Budget::Samples(16), ..Settings::default() };
    let means: Vec<f64> = integrators
        .iter()
        .map(|i| i.render(&Nothing, &FilmOnly(window()), &settings).unwrap().image.mean().r())
        .collect();
    // Without margin and filter every splat lands in the window, so even the random mean is exact.
    assert!(means.iter().all(|m| (m - 0.7).abs() < 1e-12), "{means:?}");
}

#[test]
fn a_source_of_the_users_own_renders() {
    let sampler = SamplerKind::Independent;
    let settings = Settings { budget: Budget::Samples(2), sampler, ..Settings::default() };
    let (source, camera, integrator) =
        (Independent { seed: 0 }, FilmOnly(window()), Arithmetic(Kind::Mixed));
    let own = render_with_source(&source, &Nothing, &camera, &integrator, &settings, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(own.image, run(Kind::Mixed, window(), &settings).image);
}

#[cfg(feature = "image")]
#[test]
fn a_rendering_becomes_a_file_with_its_metadata() {
    let file = run(
        Kind::Constant,
        window(),
        &Settings { budget: Budget::Samples(2), ..Settings::default() },
    )
    .to_file();
    assert_eq!((file.region, file.metadata["samples_per_pixel"].as_str()), (Some(window()), "2"));
    assert_eq!((file.metadata["seed"].as_str(), file.metadata["sampler"].as_str()), ("0", "Sobol"));
}

/// An integrator that learns: each chunk counts its samples, a pass adds the number of samples that
/// all chunks counted before it, and chunks are collected in their order.
#[derive(Debug)]
struct Learning {
    /// The pass that there is not enough memory for.
    fails_at: u32,
}

#[derive(Default)]
struct Lessons {
    fails_at: u32,
    /// Samples in earlier passes.
    known: u64,
    passes: u32,
    /// Passes prepared since that was asked for.
    prepared: u32,
    /// Samples of each chunk, pass after pass.
    collected: Vec<u64>,
}

impl<S: Scene + ?Sized> Integrator<S> for Learning {
    type Run<'a>
        = Lessons
    where
        S: 'a;

    fn name(&self) -> &'static str {
        "learning"
    }

    fn start<'a>(&'a self, _: Stage<'a, S>, _: &dyn Crew) -> Started<Lessons> {
        Ok(Lessons { fails_at: self.fails_at, ..Lessons::default() })
    }
}

impl<'a, S: Scene + ?Sized + 'a> Run<'a, S> for Lessons {
    /// Samples in this pass and in all passes.
    type Chunk = [u64; 2];

    fn techniques(&self) -> TechniqueSet {
        TechniqueSet::NONE
    }

    fn learns(&self) -> bool {
        true
    }

    fn begin_pass(&mut self, pass: u32, crew: &dyn Crew) -> Result<(), IntegratorError> {
        assert_eq!(self.passes, pass);
        assert_eq!(crew.collect(5, |i| i * i), [0, 1, 4, 9, 16]);
        self.passes += 1;
        self.prepared += 1;
        self.known = self.collected.iter().sum();
        if pass == self.fails_at {
            let reason = "not enough memory".to_owned();
            return Err(IntegratorError { integrator: "learning", reason });
        }
        Ok(())
    }

    fn draw<P: Sampler>(
        &self,
        samples: &mut [Sample<P>],
        sink: &mut dyn Sink,
        [now, ever]: &mut [u64; 2],
        scratch: &mut Scratch<'a, S>,
    ) {
        scratch.counters.samples += samples.len() as u64;
        for (number, Sample { film, sampler }) in samples.iter_mut().enumerate() {
            *now += 1;
            *ever += 1;
            let value = Rgb::new(self.known as f64, *ever as f64, sampler.next_1d());
            let technique = Technique::new(0, 2);
            let raster = film.raster;
            sink.add(number, &Contribution { raster, value, weight: 1.0, technique });
        }
    }

    fn collect(&mut self, [now, _]: &mut [u64; 2]) {
        self.collected.push(std::mem::take(now));
    }

    fn take_preparation(&mut self) -> Counters {
        let closest_rays = u64::from(std::mem::take(&mut self.prepared));
        Counters { samples: 1000, closest_rays, ..Counters::default() }
    }
}

#[test]
fn a_run_that_learns_knows_all_of_the_passes_before() {
    let render = |threads| {
        let settings =
            Settings { budget: Budget::Samples(4), threads: Some(threads), ..Settings::default() };
        let integrator = Learning { fails_at: u32::MAX };
        render(&Nothing, &FilmOnly(window()), &integrator, &settings).unwrap()
    };
    let one = render(1);
    let pixels = u64::from(window().pixels());
    // 0 + 1 + 2 + 3 times the pixels in each.
    assert!(one.film.sums().all(|sum| sum.r() == (6 * pixels) as f64));
    assert_eq!((one.counters.samples, one.counters.closest_rays), (4 * pixels, 4));
    for threads in [2, 7, 64] {
        assert!(render(threads).film.sums().eq(one.film.sums()), "{threads} threads");
    }
}

#[test]
fn a_pass_that_cannot_be_prepared_is_an_error() {
    let settings = Settings { budget: Budget::Samples(4), ..Settings::default() };
    let integrator = Learning { fails_at: 2 };
    let result = render(&Nothing, &FilmOnly(window()), &integrator, &settings);
    let error = result.unwrap_err();
    assert_eq!(error.to_string(), "learning: not enough memory");
    assert!(std::error::Error::source(&error).is_some());
}

/// Even if passes depend on those before them, and more than once.
#[test]
fn what_is_resumed_is_the_same_to_the_bit() {
    fn check<I: Integrator<Nothing>>(integrator: &I, target_error: Option<f64>) {
        let settings = Settings {
            budget: Budget::Samples(40),
            target_error,
            keeps_checkpoint: true,
            ..Settings::default()
        };
        let camera = FilmOnly(window());
        let whole = render(&Nothing, &camera, integrator, &settings).unwrap();
        for breaks in [&[1][..], &[5, 6, 17], &[39]] {
            let (mut breaks, mut from) = (breaks.iter(), None::<Checkpoint>);
            let resumed = loop {
                let end = breaks.next().copied().unwrap_or(u32::MAX);
                let mut stop = |progress: &Progress<'_>| match progress.passes >= end {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                };
                let rendering = match from.take() {
                    Some(from) => resume(from, &Nothing, &camera, integrator, &settings, &mut stop),
                    None => {
                        render_with_progress(&Nothing, &camera, integrator, &settings, &mut stop)
                    }
                }
                .unwrap();
                if !rendering.stopped {
                    break rendering;
                }
                from = rendering.checkpoint;
            };
            assert_eq!(resumed.samples_per_pixel, whole.samples_per_pixel);
            assert!(resumed.film.sums().eq(whole.film.sums()));
            assert_eq!(resumed.estimated_error, whole.estimated_error);
            assert_eq!(resumed.counters, whole.counters);
        }
    }
    check(&Learning { fails_at: u32::MAX }, None);
    check(&Arithmetic(Kind::Mixed), None);
    // Reached after 34 of 40 passes or so.
    check(&Arithmetic(Kind::Noise), Some(0.01));
}

#[test]
fn a_shard_of_what_learns_is_refused() {
    let shard = Shard::new(1, 2).unwrap();
    let settings = Settings { shard, ..Settings::default() };
    let learning = Learning { fails_at: u32::MAX };
    let error = render(&Nothing, &FilmOnly(window()), &learning, &settings).unwrap_err();
    assert_eq!(error, RenderError::ShardOfLearner { integrator: "learning", shard });
    let settings = Settings { target_error: Some(0.1), ..settings };
    let error = render(&Nothing, &FilmOnly(window()), &learning, &settings).unwrap_err();
    assert_eq!(error, RenderError::ShardOfTarget(shard));
}

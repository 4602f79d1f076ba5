//! Light transport as one integral over paths, and interchangeable ways to sample it.
//!
//! # A first image
//!
//! With the feature `image`, which writes files:
//!
#![cfg_attr(feature = "image", doc = "```")]
#![cfg_attr(not(feature = "image"), doc = "```ignore")]
//! use pathspace::endpoint::PinholeCamera;
//! use pathspace::geometry::{Disk, Sphere};
//! use pathspace::glam::{DVec3, UVec2};
//! use pathspace::integrator::PathTracer;
//! use pathspace::math::Rgb;
//! use pathspace::render::{Settings, render};
//! use pathspace::scene::{Emission, Material, WorldBuilder};
//!
//! let mut scene = WorldBuilder::new();
//! let clay =
//!     scene.add_material("clay", Material::Lambert { albedo: Rgb::new(0.7, 0.35, 0.2) })?;
//! let ground = Disk { center: DVec3::ZERO, normal: DVec3::Y, radius: 1000.0 };
//! scene.add_disk("ground", ground, clay)?;
//! scene.add_sphere("ball", Sphere::new(DVec3::Y, 1.0), clay)?;
//! let lamp = scene.add_sphere("lamp", Sphere::new(DVec3::new(2.0, 4.0, 2.0), 0.5), clay)?;
//! scene.set_emission(lamp, Emission { radiance: Rgb::splat(30.0), two_sided: false })?;
//! let world = scene.build()?;
//!
//! let (eye, target, film) = (DVec3::new(0.0, 2.0, 7.0), DVec3::Y, UVec2::new(320, 240));
//! # let film = film / 10;
//! let camera = PinholeCamera::new(eye, target, DVec3::Y, 40.0, film)?;
//! let rendering = render(&world, &camera, &PathTracer::default(), &Settings::default())?;
//! # std::env::set_current_dir(std::env::temp_dir())?;
//! rendering.to_file().save("first_image.png")?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
#![doc = include_str!("../docs/first_image.html")]
//!
//! Another integrator fits in the place of [`PathTracer`], which is the point of what follows.
//! [`gallery`] has scenes to start from, `import` reads those of other programs, and a renderer
//! with geometry of its own implements [`Scene`](scene::Scene).
//!
//! # One integral
//!
//! A pixel is an integral over paths `x_0 x_1 … x_k` from the lens to a light,
//!
//! ```text
//! I = ∫ We(x_0 → x_1) G(x_0, x_1) T(x_1 … x_k) Le(x_k → x_{k-1}) dμ(x̄),
//! T = Π_{i=1}^{k-1} f(x_{i+1} → x_i → x_{i-1}) G(x_i, x_{i+1})
//! ```
//!
//! (Kajiya 1986; Veach 1997, section 8.2).
//!
//! A *technique* (s, t), s + t = k + 1, is one way to draw such a path: s vertices from the light
//! and t from the camera, connected by an edge; or s + t = k + 2 of them, whose last ones *merge*
//! into one vertex if they are near enough. Every integrator is a set of techniques, each
//! contribution is `w f/p`, and the crate has one definition of f, of p and of w. So integrators
//! are interchangeable, can be audited against the definitions, and a new one is made of the same
//! bricks.
//!
//! An [`Integrator`](integrator::Integrator) is settings. Started on a [`Stage`](path::Stage) it
//! becomes a [`Run`](integrator::Run), which draws samples; [`render`](render::render()) starts it
//! and makes an image. What its walks do is written for one path ([`Steps`](path::Steps)); one loop
//! lets many of them [`advance`](path::advance) together.
//!
//! # The map
//!
//! | what | equation | item |
//! |---|---|---|
//! | radiance from a point | `Lo = Le + ∫ f Li \|cos θ\| dω` | [`Bsdf::eval`], [`Endpoint::emit`] |
//! | geometry term | `G = V \|cos θ cos θ'\| / r²` | [`Edge`], V by [`Scene::visible`] |
//! | throughput of a path | `T = Π f G` | [`PathRecord::throughput`] |
//! | densities and their measures | `p_A = p_ω \|cos θ'\| / r² = p⊥ G` | [`math::measure`] |
//! | density of a technique | `p_{s,t} = Π p_A` | [`PathRecord::density`] |
//! | density of a merge at x_m | `π r² b_{m+1} G_m p(t = m+1)` | [`PathDensities::sweep`] |
//! | weight of a technique | `w_i = p_i^β / Σ p_j^β` | [`Heuristic`], [`Path::weight`], [`Weighting`] |
//! | Russian roulette | `F' = (F - q c)/(1 - q)` or `c` | [`Roulette`] |
//! | incremental construction | `T_k = T_{k-1} f \|cos θ\| / p_ω` | [`RandomWalk`] |
//! | uniform-area sampling | `p_A = 1 / Σ A_j` | [`UniformArea`] |
//! | path tracing | s = 0 and s = 1 | [`PathTracer`] |
//! | light tracing | t = 1 | [`LightTracer`] |
//! | bidirectional path tracing | all (s, t) | [`Bidirectional`] |
//! | irradiance at a point | `E = ∫ L \|cos θ\| dω` | [`IrradianceMeter`], [`measure`] |
//! | the set of least variance × cost | `min V[F] C[F]` | [`Adaptive`] |
//! | radiance from photons | `L ≈ 1/N Σ f Φ / (π r²)` | [`PhotonMap`], [`PhotonMapping`] |
//! | the radius of a pass | `r_i² = r_1² i^(α-1)` | [`Merging`] |
//! | virtual lights | `L ≈ 1/N Σ min(G, g) f f Φ`, rest by going on | [`InstantRadiosity`] |
//! | regularisation | `δ⊥ ≈ κ` on a disc of slopes, `ε_i² = ε_1² i^(α-1)` | [`Regularization`] |
//! | connections and merges | all (s, t), all merges | [`VertexConnectionMerging`] |
//!
//! # The modules
//!
//! A module imports those below it alone.
//!
//! | module | contents |
//! |---|---|
//! | `report` | error against run time: studies, metrics, plots, the page (feature `report`) |
//! | `import` | scenes from files, one module per format (features `mitsuba`, …) |
//! | [`render`] | the driver: passes, budget, threads, progress; measurements |
//! | [`integrator`] | the integrators, a page each |
//! | [`path`] | the core: vertices, the random walk, connections, techniques, weights |
//! | [`guiding`] | a view of a scene whose camera walks go where light was found before |
//! | [`photon_map`] | photons and the search for those near a point |
//! | [`gallery`] | the shipped scenes |
//! | [`scene`] | the trait that a host renderer implements; the ready-made [`World`] |
//! | `tree` | the ray kernel, with the proofs that it misses nothing |
//! | [`endpoint`] | lights and cameras |
//! | [`light_tree`] | the choice among many lights |
//! | [`material`] | descriptions of surfaces; colours that vary over them |
//! | [`bsdf`] | scattering models |
//! | [`film`] | contributions, filters, images |
//! | [`sampler`] | random numbers and quasi-random ones |
//! | [`geometry`] | shapes and robust intersection |
//! | [`math`] | densities with their measure, colour, distributions, statistics |
//!
//! Positions, directions, densities and sums are `f64` throughout; lengths are in the scene's own
//! unit, radiance in W/(m² sr) of that unit, colour is linear RGB with the primaries of sRGB.
//!
//! [`Bsdf::eval`]: bsdf::Bsdf::eval
//! [`Endpoint::emit`]: endpoint::Endpoint::emit
//! [`Scene::visible`]: scene::Scene::visible
//! [`PathRecord::throughput`]: path::PathRecord::throughput
//! [`PathRecord::density`]: path::PathRecord::density
//! [`PathDensities::sweep`]: path::PathDensities::sweep
//! [`Path::weight`]: path::Path::weight
//! [`World`]: scene::World
//! [`IrradianceMeter`]: endpoint::IrradianceMeter
//! [`measure`]: render::measure()
//! [`Edge`]: path::Edge
//! [`Heuristic`]: path::Heuristic
//! [`Roulette`]: path::Roulette
//! [`RandomWalk`]: path::RandomWalk
//! [`Weighting`]: path::Weighting
//! [`PhotonMap`]: photon_map::PhotonMap
//! [`UniformArea`]: integrator::UniformArea
//! [`PathTracer`]: integrator::PathTracer
//! [`LightTracer`]: integrator::LightTracer
//! [`Bidirectional`]: integrator::Bidirectional
//! [`Adaptive`]: integrator::Adaptive
//! [`PhotonMapping`]: integrator::PhotonMapping
//! [`Merging`]: integrator::Merging
//! [`InstantRadiosity`]: integrator::InstantRadiosity
//! [`Regularization`]: integrator::Regularization
//! [`VertexConnectionMerging`]: integrator::VertexConnectionMerging

pub mod bsdf;
pub mod endpoint;
pub mod film;
pub mod gallery;
pub mod geometry;
pub mod guiding;
#[cfg(feature = "import")]
#[cfg_attr(
    not(all(feature = "gltf", feature = "mitsuba", feature = "pbrt")),
    allow(dead_code, reason = "each format uses a part of what they share")
)]
pub mod import;
pub mod integrator;
mod lanes;
pub mod light_tree;
pub mod material;
pub mod math;
pub mod path;
pub mod photon_map;
pub mod render;
#[cfg(feature = "report")]
pub mod report;
pub mod sampler;
pub mod scene;
mod tree;

pub use glam;

/// The README's code must compile.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

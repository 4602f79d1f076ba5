//! Uniform-area path sampling, the lecture's estimator: behind the first surface that the camera
//! sees, every vertex is drawn uniformly on the total area A of the scene's surfaces, and
//! visibility is tested edge by edge,
//!
//! ```text
//! Le(x_k → x_{k-1}) · Π_{i=1}^{k-1} f(x_i) G(x_i, x_{i+1}) / p_A,       p_A = 1/A.
//! ```
//!
//! All path lengths share one chain of vertices. It knows neither where the light is nor how
//! surfaces scatter, and 1/r² is in no density: the variance is infinite wherever surfaces meet in
//! a corner. It is here because it is the definition, sampled. It cannot see Dirac lobes, Dirac
//! lights or anything at infinity behind the first vertex.

use super::{Depth, Integrator};
use crate::bsdf::Walk;
use crate::endpoint::{Camera, Endpoint};
use crate::film::{Contribution, FilmSample, Sink, Technique};
use crate::math::Rgb;
use crate::path::{Edge, RandomWalk, Roulette, Scratch, TechniqueSet, Termination};
use crate::sampler::{Sampler, Stream};
use crate::scene::{Needs, SurfaceArea};

/// Uniform-area path sampling.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UniformArea {
    /// Which path lengths count.
    pub depth: Depth,
    /// Termination.
    pub roulette: Roulette,
}

impl UniformArea {
    /// Uniform-area path sampling up to a number of scattering events.
    #[must_use]
    pub fn up_to(max_bounces: u32) -> Self {
        Self { depth: Depth::up_to(max_bounces), ..Self::default() }
    }
}

impl<S: SurfaceArea + ?Sized> Integrator<S> for UniformArea {
    fn name(&self) -> &'static str {
        "uniform-area"
    }

    fn techniques(&self, needs: &Needs) -> TechniqueSet {
        TechniqueSet { uniform_area: true, ..TechniqueSet::NONE }.pruned(needs)
    }

    fn sample<'s, C: Camera + ?Sized, P: Sampler, K: Sink>(
        &self,
        scene: &'s S,
        camera: &C,
        film: FilmSample,
        sampler: &mut P,
        sink: &mut K,
        scratch: &mut Scratch<'s, S>,
    ) {
        let counters = &mut scratch.counters;
        counters.samples += 1;
        let needs = scene.needs();
        if !Integrator::<S>::techniques(self, &needs).uniform_area {
            return;
        }
        let depth = self.depth.within(&needs);
        let mut add = |bounces: u32, value: Rgb| {
            let technique = Technique { s: 0, t: bounces as u16 + 2 };
            sink.add(&Contribution { raster: film.raster, value, weight: 1.0, technique });
        };
        let u = camera.film().to_window(film.raster + film.offset);
        let Some((mut walk, _)) = RandomWalk::from_camera(scene, camera, u, sampler) else {
            return;
        };
        let Some(first) = walk.arrive(counters) else { return };
        if let Some(light) = first.light
            && depth.contains(0)
        {
            let radiance = scene.light(light).emit(&first.point, first.to_previous);
            if !radiance.is_black() {
                add(0, first.throughput * radiance);
            }
        }
        let (mut point, mut to_camera, mut throughput) =
            (first.point, first.to_previous, first.throughput);
        let Some(mut bsdf) = first.bsdf else { return };
        let reference = throughput.max_component();
        let area = scene.total_area();
        for bounces in 1..=depth.limit() {
            sampler.stream(Stream::CameraVertex(bounces));
            let next = scene.sample_surface(sampler.next_1d(), sampler.next_2d());
            counters.scattered += 1;
            let Some(edge) = Edge::between(&point, &next) else { break };
            counters.connections += 1;
            throughput *= bsdf.eval(edge.direction, to_camera) * (edge.geometry * area);
            if throughput.is_black() {
                break;
            }
            counters.shadow_rays += 1;
            if !scene.visible(&point, &next) {
                break;
            }
            if let Some(light) = scene.light_at(&next)
                && depth.contains(bounces)
            {
                let radiance = scene.light(light).emit(&next, -edge.direction);
                if !radiance.is_black() {
                    add(bounces, throughput * radiance);
                }
            }
            let constant = self.roulette.constant(Walk::Camera) * throughput;
            let relative = throughput.max_component() / reference;
            match self.roulette.decide(bounces, relative, || sampler.next_1d()) {
                Termination::Continue => {}
                Termination::Survived { q } => {
                    throughput = throughput / (1.0 - q);
                    if !constant.is_black() {
                        add(bounces + 1, constant * (-q / (1.0 - q)));
                    }
                }
                Termination::Terminated => {
                    if !constant.is_black() {
                        add(bounces + 1, constant);
                    }
                    break;
                }
            }
            (point, to_camera) = (next, -edge.direction);
            bsdf = crate::bsdf::shading::ShadedBsdf::new(scene.bsdf(&point), &point);
        }
    }
}

//! The needs of a world, from its materials, lights and shapes.

use crate::bsdf::Lobes;
use crate::endpoint::LightId;
use crate::geometry::{Bounds, Shape};
use crate::material::Finish;
use crate::scene::Needs;
use crate::scene::lights::BoxedLight;
use crate::scene::surface::Surface;
use crate::tree::Forest;

/// The features that rendering a world takes.
pub(super) fn needs(
    materials: &[Finish],
    surfaces: &[Surface],
    lights: &[(String, BoxedLight)],
    environment: Option<LightId>,
    shapes: &Forest,
    bounds: &Bounds,
) -> Needs {
    let when = |condition: bool, need: Needs| if condition { need } else { Needs::NONE };
    let any_light = |is: &dyn Fn(&BoxedLight) -> bool| {
        lights.iter().any(|(_, light)| !light.is_black() && is(light))
    };
    let lobes = surfaces
        .iter()
        .fold(Lobes::NONE, |lobes, s| lobes | materials[s.material.0 as usize].lobes());
    let is_flat = |shape: &Shape| !matches!(shape, Shape::Sphere(_));
    let is_ball = |shape: &Shape| match shape {
        Shape::Sphere(sphere) => sphere.is_whole() && !sphere.inward,
        _ => false,
    };
    let single = match surfaces {
        [surface] if surface.primitives == 1 => shapes.shape(0).map(|shape| (surface, shape)),
        _ => None,
    };
    // Nothing on a flat surface sees anything else of it; nor on a ball from outside, where light
    // of the sky and its own stays.
    let convex = single.is_some_and(|(surface, shape)| {
        let outside = lights.len()
            == usize::from(environment.is_some()) + usize::from(surface.light.is_some());
        let own = surface.emission.as_ref().is_none_or(|(_, two_sided)| !two_sided);
        is_flat(shape)
            || (is_ball(shape) && outside && own && !lobes.intersects(Lobes::TRANSMISSION))
    });
    when(any_light(&|light| light.can_be_hit()), Needs::HITTABLE_LIGHTS)
        | when(any_light(&|light| !light.can_be_hit()), Needs::DIRAC_LIGHTS)
        | when(any_light(&|light| light.can_be_connected()), Needs::CONNECTIBLE_LIGHTS)
        | when(any_light(&|light| !light.can_be_connected()), Needs::UNCONNECTIBLE_LIGHTS)
        | when(any_light(&|light| light.can_illuminate(bounds)), Needs::ILLUMINATION)
        | when(!convex, Needs::INTERREFLECTION)
        | when(lobes.intersects(Lobes::FINITE), Needs::FINITE_LOBES)
        | when(lobes.intersects(Lobes::GLOSSY), Needs::GLOSSY_LOBES)
        | when(lobes.intersects(Lobes::DIRAC), Needs::DIRAC_LOBES)
        | when(environment.is_some(), Needs::ENVIRONMENT)
}

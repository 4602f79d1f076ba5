//! An integrator that leaves nothing out, to be measured beside the one that does.

use super::method::Method;
use crate::endpoint::Camera;
use crate::integrator::Integrator;
use crate::path::{LeftOut, TechniqueSet};
use crate::render::{Progress, Render, RenderError, Rendering, Settings};
use crate::scene::{Needs, WithNeeds, World};
use std::ops::ControlFlow;

/// An integrator on a [`World`] that claims to need everything: see [`WithNeeds`]. For a scene type
/// of one's own, [`Render`] and [`Method`] are implemented like this.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Everything<I>(pub I);

impl<I> Render<World> for Everything<I>
where
    I: for<'a> Integrator<WithNeeds<'a, World>>,
{
    fn techniques(&self, _: &World) -> TechniqueSet {
        self.0.techniques(&Needs::ALL)
    }

    fn left_out(&self, _: &World) -> LeftOut {
        self.0.left_out(&Needs::ALL)
    }

    fn render(
        &self,
        scene: &World,
        camera: &dyn Camera,
        settings: &Settings,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Rendering, RenderError> {
        crate::render::render(&WithNeeds::all(scene), camera, &self.0, settings, progress)
    }
}

impl<I> Method<World> for Everything<I> where I: for<'a> Integrator<WithNeeds<'a, World>> {}

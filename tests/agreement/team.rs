//! The integrators that take part in a comparison.

use crate::compare::{Comparison, Named, assert_agree};
use crate::rooms::{Room, camera, lambert, v};
use glam::DVec2;
use pathspace::endpoint::{EnvironmentMap, Lookup};
use pathspace::integrator::{
    Bidirectional, Depth, LightTracer, PathTracer, PathTracing, UniformArea,
};
use pathspace::math::Rgb;
use pathspace::path::{Heuristic, TechniqueSet};
use pathspace::render::Render;
use pathspace::scene::{Material, World};

/// The integrators of a test, with the depth that they share.
pub struct Team {
    depth: Depth,
    members: Vec<(&'static str, Box<dyn Render<World>>)>,
}

impl Team {
    pub fn new(depth: Depth) -> Self {
        Self { depth, members: Vec::new() }
    }

    pub fn with(mut self, name: &'static str, integrator: impl Render<World> + 'static) -> Self {
        self.members.push((name, Box::new(integrator)));
        self
    }

    /// Path tracing and bidirectional path tracing, which see everything but Dirac lights through
    /// Dirac lobes.
    pub fn standard(depth: Depth) -> Self {
        Self::new(depth).path().bidirectional()
    }

    /// And light tracing.
    pub fn with_light(depth: Depth) -> Self {
        Self::standard(depth).light()
    }

    pub fn path(self) -> Self {
        let depth = self.depth;
        self.with("path", PathTracer { depth, ..PathTracer::default() })
    }

    pub fn emission_only(self) -> Self {
        let depth = self.depth;
        self.with(
            "path, emission only",
            PathTracer { mode: PathTracing::EmissionOnly, depth, ..PathTracer::default() },
        )
    }

    pub fn next_event_only(self) -> Self {
        let depth = self.depth;
        self.with(
            "path, next event only",
            PathTracer { mode: PathTracing::NextEventOnly, depth, ..PathTracer::default() },
        )
    }

    pub fn light(self) -> Self {
        let depth = self.depth;
        self.with("light", LightTracer { depth, ..LightTracer::default() })
    }

    pub fn uniform(self) -> Self {
        let depth = self.depth;
        self.with("uniform area", UniformArea { depth, ..UniformArea::default() })
    }

    pub fn bidirectional(self) -> Self {
        let depth = self.depth;
        self.with("bidirectional, power", Bidirectional { depth, ..Bidirectional::default() })
    }

    pub fn balance(self) -> Self {
        let depth = self.depth;
        self.with(
            "bidirectional, balance",
            Bidirectional { depth, heuristic: Heuristic::Balance, ..Bidirectional::default() },
        )
    }

    /// The general kernel with the techniques of the path tracer, and with those of the light
    /// tracer.
    pub fn general(self) -> Self {
        let depth = self.depth;
        let path = TechniqueSet { bsdf_sampling: true, next_event: true, ..TechniqueSet::NONE };
        let light = TechniqueSet { lens_sampling: true, ..TechniqueSet::NONE };
        self.with(
            "general, s < 2",
            Bidirectional { techniques: path, depth, ..Bidirectional::default() },
        )
        .with(
            "general, t = 1",
            Bidirectional { techniques: light, depth, ..Bidirectional::default() },
        )
    }

    pub fn named(&self) -> Vec<Named<'_>> {
        self.members.iter().map(|(name, integrator)| (*name, integrator.as_ref())).collect()
    }

    pub fn agree(&self, case: &str, room: Room) {
        self.agree_within(0.0025, case, room);
    }

    pub fn agree_within(&self, target: f64, case: &str, room: Room) {
        assert_agree(
            case,
            &room.build(),
            &camera(),
            &self.named(),
            &Comparison { target, ..Comparison::default() },
        );
    }
}

pub const THREE: Depth = Depth::up_to(3);

pub fn grey() -> Material {
    lambert(0.5, 0.5, 0.5)
}

pub fn black() -> Material {
    Material::Black
}

pub fn metal(x: f64, y: f64) -> Material {
    Material::RoughConductor {
        eta: Rgb::new(0.2, 0.9, 1.2),
        k: Rgb::new(3.9, 2.5, 2.2),
        alpha: DVec2::new(x, y),
    }
}

pub fn sky(lookup: Lookup) -> EnvironmentMap {
    // A dim sky with a colour gradient, black ground, and a hot spot.
    let pixel = |i: u32| match (i % 16, i / 16) {
        (7, 1) => Rgb::new(15.0, 12.0, 8.0),
        (x, y) if y < 5 => Rgb::new(0.2 + 0.05 * f64::from(x), 0.5, 0.1 * f64::from(y)),
        _ => Rgb::BLACK,
    };
    EnvironmentMap::new(16, 8, (0..128).map(pixel).collect(), EnvironmentMap::Z_UP)
        .expect("valid")
        .with_lookup(lookup)
}

pub fn lit_room() -> World {
    let mut room = Room::closed_above(grey());
    room.lamp(0.5, 4.0);
    room.build()
}

/// Two faces and a lamp that do not touch, so that 1/r² of a connection has a finite variance.
pub fn apart(floor: Material) -> World {
    let mut room = Room::default();
    room.quad(v(-1.0, -1.0, 0.0), v(2.0, 0.0, 0.0), v(0.0, 2.0, 0.0), floor.clone());
    room.quad(v(-0.8, 1.2, 0.4), v(1.6, 0.0, 0.0), v(0.1, 0.2, 1.2), floor);
    room.lamp(0.9, 2.0);
    room.build()
}

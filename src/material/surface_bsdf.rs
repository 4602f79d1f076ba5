//! Materials as integrators meet them: at a point, with textures looked up there and with the side
//! that is seen.

use super::finish::{Finish, Layers, product};
use super::{CustomBsdf, VertexSite, VertexValues};
use crate::bsdf::{
    Bsdf, BsdfSample, Culled, DiracValue, Lambert, LaneForm, Lobes, Mixture, Model, TransportMode,
};
use crate::math::{PerProjected, Rgb};
use glam::{DVec2, DVec3};

/// The BSDF of one point of a [`World`](crate::scene::World): references to what is the same
/// everywhere, and the colour that a texture has at the point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceBsdf<'a>(Seen<'a>);

/// Pairs are what the front shows and what the back shows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen<'a> {
    /// Lambertian reflection on the sides that are not black.
    Lambert {
        lambert: Lambert,
        sides: [bool; 2],
    },
    Models {
        sides: &'a [Model; 2],
        lobes: Lobes,
    },
    /// The models of both sides, in a colour.
    Tinted {
        sides: &'a [Model; 2],
        tint: Rgb,
        lobes: Lobes,
    },
    Mixtures {
        sides: &'a [Mixture<Model, 2>; 2],
        lobes: Lobes,
    },
    /// Layers with the colour of the only texture.
    Coloured {
        layers: &'a Layers,
        colour: Rgb,
        lobes: Lobes,
    },
    /// Layers of several textures, which are looked up at each question.
    Layered {
        layers: &'a Layers,
        uv: DVec2,
        lobes: Lobes,
    },
    /// The same of textures that ask for what a mesh has at its vertices. Not with a site as a
    /// whole, whose padding would make every vertex of a path larger.
    OnMesh {
        layers: &'a Layers,
        values: &'a VertexValues,
        index: u32,
        barycentric: DVec2,
    },
    Custom(&'a CustomBsdf),
    Culled {
        front: &'a Finish,
        uv: DVec2,
    },
    CulledOnMesh {
        front: &'a Finish,
        values: &'a VertexValues,
        index: u32,
        barycentric: DVec2,
    },
}

impl<'a> SurfaceBsdf<'a> {
    /// The BSDF that absorbs everything.
    pub(crate) const BLACK: Self =
        Self(Seen::Models { sides: &[Model::Black; 2], lobes: Lobes::NONE });

    /// The BSDF at a point with these texture coordinates; `site` finds its place on a mesh with
    /// more of them, or with colours.
    #[inline]
    pub(crate) fn new(
        finish: &'a Finish,
        uv: DVec2,
        site: impl Fn() -> Option<VertexSite<'a>>,
    ) -> Self {
        Self(match finish {
            Finish::Lambert { lambert, sides } => {
                Seen::Lambert { lambert: *lambert, sides: *sides }
            }
            Finish::Models { sides, lobes } => Seen::Models { sides, lobes: *lobes },
            Finish::TexturedLambert { albedo, sides } => {
                let albedo = product(albedo, |texture| texture.seen(uv, &site));
                Seen::Lambert { lambert: Lambert::of_valid(albedo), sides: *sides }
            }
            Finish::Tinted { sides, tints, lobes } => {
                let tint = product(tints, |texture| texture.seen(uv, &site));
                Seen::Tinted { sides, tint, lobes: *lobes }
            }
            Finish::Mixtures { sides, lobes } => Seen::Mixtures { sides, lobes: *lobes },
            Finish::Layers(layers) => match &layers.only {
                Some(texture) => {
                    let colour = texture.seen(uv, &site);
                    Seen::Coloured { layers, colour, lobes: layers.lobes }
                }
                None => match if layers.asks_vertices { site() } else { None } {
                    Some(VertexSite { values, index, barycentric }) => {
                        Seen::OnMesh { layers, values, index, barycentric }
                    }
                    None => Seen::Layered { layers, uv, lobes: layers.lobes },
                },
            },
            Finish::Custom(bsdf) => Seen::Custom(bsdf),
            Finish::Culled(front) => match site() {
                Some(VertexSite { values, index, barycentric }) => {
                    Seen::CulledOnMesh { front, values, index, barycentric }
                }
                None => Seen::Culled { front, uv },
            },
        })
    }

    fn on_mesh(finish: &'a Finish, site: VertexSite<'a>) -> Self {
        Self::new(finish, site.uv(false), || Some(site))
    }

    /// The models at this point, seen from the front or from the back, and how they are mixed (one
    /// alone has the weight 1); `None` for a BSDF of a user's own. Of what is culled, the models
    /// that it would have.
    #[must_use]
    pub fn mixture(&self, front: bool) -> Option<Mixture<Model, 2>> {
        let side = usize::from(!front);
        let alone =
            |model, tint| Mixture::of_valid([model, Model::Black], [tint, Rgb::BLACK], [1.0, 0.0]);
        match self.0 {
            Seen::Lambert { lambert, sides } => {
                let model = if sides[side] { lambert.into() } else { Model::Black };
                Some(alone(model, Rgb::WHITE))
            }
            Seen::Models { sides, .. } => Some(alone(sides[side], Rgb::WHITE)),
            Seen::Tinted { sides, tint, .. } => Some(alone(sides[side], tint)),
            Seen::Mixtures { sides, .. } => Some(sides[side]),
            Seen::Coloured { layers, colour, .. } => Some(layers.coloured(side, colour)),
            Seen::Layered { layers, uv, .. } => {
                Some(layers.mixture(side, |texture| texture.at(uv)))
            }
            Seen::OnMesh { layers, values, index, barycentric } => {
                let site = VertexSite { values, index, barycentric };
                Some(layers.mixture(side, |texture| texture.on_mesh(&site)))
            }
            Seen::Custom(_) => None,
            Seen::Culled { front: finish, uv } => Self::new(finish, uv, || None).mixture(front),
            Seen::CulledOnMesh { front: finish, values, index, barycentric } => {
                let site = VertexSite { values, index, barycentric };
                Self::on_mesh(finish, site).mixture(front)
            }
        }
    }
}

/// A model in a colour.
struct Tinted<'a> {
    model: &'a Model,
    tint: Rgb,
}

impl Tinted<'_> {
    fn coloured(&self, sample: BsdfSample) -> BsdfSample {
        BsdfSample { weight: sample.weight * self.tint, ..sample }
    }
}

impl Bsdf for Tinted<'_> {
    fn lobes(&self) -> Lobes {
        self.model.lobes()
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        self.model.eval(to_light, to_camera) * self.tint
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        self.model.pdf(fixed, next, mode)
    }

    #[inline]
    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        let (value, pdf) = self.model.eval_and_pdf(to_light, to_camera);
        (value * self.tint, pdf)
    }

    #[inline]
    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        self.model.sample(fixed, mode, u1, u2).map(|sample| self.coloured(sample))
    }

    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        self.model.dirac_images(fixed, mode, &mut |sample| image(self.coloured(sample)));
    }
}

/// What is on the side of a direction. Chosen without an index, which would need it in memory.
#[inline]
fn of_side<T>([front, back]: [T; 2], direction: DVec3) -> T {
    if direction.z < 0.0 { back } else { front }
}

/// Asks what there is on a direction's side; black sides get the other expression.
macro_rules! ask {
    ($self:ident, $direction:ident, $bsdf:ident => $question:expr, black => $absorbed:expr) => {
        match &$self.0 {
            Seen::Lambert { lambert: $bsdf, sides } if of_side(*sides, $direction) => $question,
            Seen::Lambert { .. } => $absorbed,
            Seen::Models { sides, .. } => {
                let $bsdf = of_side(sides.each_ref(), $direction);
                $question
            }
            Seen::Tinted { sides, tint, .. } => {
                let model = of_side(sides.each_ref(), $direction);
                let $bsdf = Tinted { model, tint: *tint };
                $question
            }
            Seen::Mixtures { sides, .. } => {
                let $bsdf = of_side(sides.each_ref(), $direction);
                $question
            }
            Seen::Custom($bsdf) => $question,
            Seen::Culled { front, uv } => {
                let $bsdf = Culled(SurfaceBsdf::new(front, *uv, || None));
                $question
            }
            &Seen::CulledOnMesh { front, values, index, barycentric } => {
                let site = VertexSite { values, index, barycentric };
                let $bsdf = Culled(SurfaceBsdf::on_mesh(front, site));
                $question
            }
            Seen::Coloured { .. } | Seen::Layered { .. } | Seen::OnMesh { .. } => {
                match $self.mixture(of_side([true, false], $direction)) {
                    Some($bsdf) => $question,
                    None => $absorbed,
                }
            }
        }
    };
}

impl Bsdf for SurfaceBsdf<'_> {
    #[inline]
    fn lobes(&self) -> Lobes {
        match self.0 {
            Seen::Lambert { .. } => Lobes::DIFFUSE_REFLECTION,
            Seen::Models { lobes, .. }
            | Seen::Tinted { lobes, .. }
            | Seen::Mixtures { lobes, .. }
            | Seen::Coloured { lobes, .. }
            | Seen::Layered { lobes, .. } => lobes,
            Seen::OnMesh { layers, .. } => layers.lobes,
            Seen::Custom(bsdf) => bsdf.lobes(),
            Seen::Culled { front, .. } | Seen::CulledOnMesh { front, .. } => {
                front.lobes() | Lobes::DIRAC_TRANSMISSION
            }
        }
    }

    #[inline]
    fn eval(&self, to_light: DVec3, to_camera: DVec3) -> Rgb {
        ask!(self, to_camera, bsdf => bsdf.eval(to_light, to_camera), black => Rgb::BLACK)
    }

    #[inline]
    fn pdf(&self, fixed: DVec3, next: DVec3, mode: TransportMode) -> PerProjected {
        ask!(self, fixed, bsdf => bsdf.pdf(fixed, next, mode), black => PerProjected::ZERO)
    }

    #[inline]
    fn eval_and_pdf(&self, to_light: DVec3, to_camera: DVec3) -> (Rgb, PerProjected) {
        let nothing = (Rgb::BLACK, PerProjected::ZERO);
        ask!(self, to_camera, b => b.eval_and_pdf(to_light, to_camera), black => nothing)
    }

    #[inline]
    fn sample(&self, fixed: DVec3, mode: TransportMode, u1: f64, u2: DVec2) -> Option<BsdfSample> {
        ask!(self, fixed, bsdf => bsdf.sample(fixed, mode, u1, u2), black => None)
    }

    fn dirac_images(&self, fixed: DVec3, mode: TransportMode, image: &mut dyn FnMut(BsdfSample)) {
        ask!(self, fixed, bsdf => bsdf.dirac_images(fixed, mode, image), black => {});
    }

    fn eval_dirac(&self, to_light: DVec3, to_camera: DVec3) -> DiracValue {
        let nothing = DiracValue::default();
        ask!(self, to_camera, bsdf => bsdf.eval_dirac(to_light, to_camera), black => nothing)
    }

    #[inline]
    fn is_anisotropic(&self) -> bool {
        match self.0 {
            Seen::Custom(bsdf) => bsdf.is_anisotropic(),
            Seen::Culled { front, uv } => Self::new(front, uv, || None).is_anisotropic(),
            Seen::CulledOnMesh { front, .. } => front.lobes().intersects(Lobes::GLOSSY),
            _ => self.lobes().intersects(Lobes::GLOSSY),
        }
    }

    #[inline]
    fn lane_form(&self, front: bool) -> Option<LaneForm> {
        let side = usize::from(!front);
        match self.0 {
            Seen::Lambert { lambert, sides } if sides[side] => Some(LaneForm::Lambert(lambert)),
            Seen::Lambert { .. } => Some(LaneForm::Black),
            Seen::Models { sides, .. } => sides[side].lane_form(front),
            Seen::Custom(bsdf) => bsdf.lane_form(front),
            Seen::Tinted { sides, .. } if sides[side] == Model::Black => Some(LaneForm::Black),
            Seen::Tinted { .. } => None,
            Seen::Mixtures { .. }
            | Seen::Coloured { .. }
            | Seen::Layered { .. }
            | Seen::OnMesh { .. }
            | Seen::Culled { .. }
            | Seen::CulledOnMesh { .. } => None,
        }
    }
}

//! Lambertian emission from surfaces.

use super::solid_angle::Subtended;
use super::{
    AnyLight, DirectionSample, Endpoint, EndpointError, FlatLight, Light, PointSample, check,
};
use crate::geometry::{Bounds, Disk, Frame, Shape, Sphere, SurfacePoint, interpolated};
use crate::light_tree::{LightBounds, LightTree};
use crate::material::Texture;
use crate::math::{PerArea, PerProjected, Rgb, unit, warp::square_to_cosine_hemisphere};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, PI};

const OBJECT: &str = "area light";

/// Shapes that emit the same radiance into every direction of their front side, or of both sides. A
/// texture may vary it from point to point.
///
/// Points are uniform on the total area. A receiver chooses a shape by what it could send, if there
/// are more than four, and near a triangle or a rectangle, or outside of a whole sphere, a point
/// uniform in the solid angle under which it sees the shape; on a sphere that has uv and tangent
/// only if there is a texture. The front side is that of the *geometric* normal.
#[derive(Clone, Debug)]
pub struct AreaLight {
    shapes: Vec<Shape>,
    /// The choice of a shape: by area, or by a receiver.
    choice: LightTree,
    area: f64,
    first_primitive: u32,
    surface: u32,
    radiance: Texture,
    /// The radiance, if it is the same everywhere.
    constant: Option<Rgb>,
    flat: Option<FlatLight>,
    /// Texture coordinates of the corners of shapes that are triangles of a mesh.
    uvs: Option<Vec<[DVec2; 3]>>,
    /// `∫ L dA`.
    radiance_integral: Rgb,
    two_sided: bool,
    bounds: LightBounds,
}

/// Up to as many shapes are chosen by their area alone, which costs nothing.
const FEW: usize = 4;
/// Points at which a texture is looked up, all shapes together, to find the power.
const POWER_LOOKUPS: usize = 1 << 18;

impl AreaLight {
    /// A light of the given radiance (W/(m² sr)).
    ///
    /// `shapes` are consecutive primitives of the scene, the first having the number
    /// `first_primitive`; `surface` is their surface id. Shapes without area are never sampled.
    ///
    /// # Errors
    /// If the radiance is negative or not finite, if a shape's area is not finite or its radius
    /// negative, if the total area is zero, or if primitive numbers overflow.
    pub fn new(
        shapes: Vec<Shape>,
        first_primitive: u32,
        surface: u32,
        radiance: Rgb,
        two_sided: bool,
    ) -> Result<Self, EndpointError> {
        Self::textured(shapes, None, first_primitive, surface, radiance.into(), two_sided)
    }

    /// A light whose radiance (W/(m² sr)) is looked up at the uv of its points: those of the
    /// shapes, or, for triangles whose scene gives their corners texture coordinates, interpolated
    /// from `corner_uvs`.
    ///
    /// # Errors
    /// As for [`AreaLight::new`], and if there are texture coordinates for another number of
    /// shapes.
    pub fn textured(
        shapes: Vec<Shape>,
        corner_uvs: Option<Vec<[DVec2; 3]>>,
        first_primitive: u32,
        surface: u32,
        radiance: Texture,
        two_sided: bool,
    ) -> Result<Self, EndpointError> {
        for bound in radiance.range() {
            check::emission(OBJECT, "radiance", bound)?;
        }
        if let Some(uvs) = corner_uvs.as_ref().filter(|uvs| uvs.len() != shapes.len()) {
            return Err(EndpointError::TextureCoordinates {
                shapes: shapes.len(),
                triangles: uvs.len(),
            });
        }
        let areas: Vec<f64> = shapes.iter().map(Shape::area).collect();
        let is_valid = |shape: &Shape| match shape {
            Shape::Sphere(Sphere { radius, .. }) | Shape::Disk(Disk { radius, .. }) => {
                *radius >= 0.0
            }
            Shape::Triangle(_) | Shape::Quad(_) => true,
        };
        if let Some(index) = (0..shapes.len())
            .find(|i| !(is_valid(&shapes[*i]) && areas[*i] >= 0.0 && areas[*i].is_finite()))
        {
            return Err(EndpointError::InvalidShape { index });
        }
        let last =
            u32::try_from(shapes.len()).ok().and_then(|count| first_primitive.checked_add(count));
        if last.is_none() || shapes.len() > LightTree::MOST_ITEMS {
            return Err(EndpointError::TooManyShapes { shapes: shapes.len() });
        }
        let area: f64 = areas.iter().sum();
        if !(area > 0.0 && area.is_finite()) {
            return Err(EndpointError::NoArea { shapes: shapes.len() });
        }
        let constant = radiance.as_constant();
        let flat = match (&shapes[..], constant) {
            ([shape], Some(radiance)) if !two_sided => {
                FlatLight::new(shape, first_primitive, surface, radiance)
            }
            _ => None,
        };
        let light = Self {
            area,
            constant,
            flat,
            choice: LightTree::new(&[], &[]),
            shapes,
            first_primitive,
            surface,
            radiance,
            uvs: corner_uvs,
            radiance_integral: Rgb::BLACK,
            two_sided,
            bounds: LightBounds::NONE,
        };
        let integrals = light.integrals(&areas);
        let radiance_integral: Rgb = integrals.iter().copied().sum();
        // What the lookups miss of a texture must not make a shape dark.
        let mean = radiance_integral.mean() / area;
        let of_shape = |((shape, area), integral): ((&Shape, &f64), &Rgb)| {
            bounds_of(shape, 0.9 * integral.mean() + 0.1 * mean * area, two_sided)
        };
        let shapes = light.shapes.iter().zip(&areas).zip(&integrals);
        let all: Vec<LightBounds> = shapes.map(of_shape).collect();
        let lit = all.iter().zip(&areas).filter(|(_, area)| **area > 0.0);
        let bounds = lit.fold(LightBounds::NONE, |sum, (shape, _)| sum.union(*shape));
        Ok(Self { radiance_integral, bounds, choice: LightTree::new(&all, &areas), ..light })
    }

    /// `∫ L dA` of each shape, by the midpoint rule in the unit square that it is sampled from.
    fn integrals(&self, areas: &[f64]) -> Vec<Rgb> {
        if let Some(radiance) = self.radiance.as_constant() {
            return areas.iter().map(|area| radiance * *area).collect();
        }
        let n = ((POWER_LOOKUPS / self.shapes.len().max(1)) as f64).sqrt().max(1.0) as usize;
        let at = |i: usize| (i as f64 + 0.5) / n as f64;
        let shape_mean = |index: usize| -> Rgb {
            let cells = (0..n * n).map(|cell| DVec2::new(at(cell % n), at(cell / n)));
            cells.map(|u| self.radiance.at(self.point_on(index, u).uv)).sum::<Rgb>()
                / (n * n) as f64
        };
        let integral = |(index, &area): (usize, &f64)| match area > 0.0 {
            true => shape_mean(index) * area,
            false => Rgb::BLACK,
        };
        areas.iter().enumerate().map(integral).collect()
    }

    /// The radiance at a point.
    #[inline]
    fn radiance_at(&self, point: &SurfacePoint) -> Rgb {
        self.constant.unwrap_or_else(|| self.radiance.at(point.uv))
    }

    /// Chooses a shape for a receiver.
    #[inline]
    fn choose(&self, receiver: &SurfacePoint, u: f64) -> Option<(usize, f64)> {
        let (index, pmf) = if self.shapes.len() > FEW {
            self.choice.sample(receiver, None, u)?
        } else {
            self.choice.sample_regardless(None, u)?
        };
        Some((index as usize, pmf))
    }

    /// The probability with which it chooses one.
    #[inline]
    fn pmf(&self, receiver: &SurfacePoint, index: usize) -> f64 {
        if self.shapes.len() > FEW {
            self.choice.pmf(receiver, None, index as u32)
        } else {
            self.choice.pmf_regardless(None, index as u32)
        }
    }

    /// The density of a point of a shape that is chosen with probability `pmf`, by what is seen of
    /// it or by area.
    #[inline]
    fn density(
        &self,
        shape: &Shape,
        seen: Option<&Subtended>,
        point: &SurfacePoint,
        pmf: f64,
    ) -> PerArea {
        match seen {
            Some(seen) => seen.pdf(point) * pmf,
            None if self.shapes.len() > FEW => PerArea(pmf / shape.area()),
            None => self.point_pdf(point),
        }
    }

    /// Total area of the shapes.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Emitted radiance.
    #[must_use]
    pub fn radiance(&self) -> &Texture {
        &self.radiance
    }

    /// True if both sides emit.
    #[must_use]
    pub fn is_two_sided(&self) -> bool {
        self.two_sided
    }

    /// The surface id of all its shapes.
    #[must_use]
    pub fn surface(&self) -> u32 {
        self.surface
    }

    /// The numbers of its primitives.
    #[must_use]
    pub fn primitives(&self) -> std::ops::Range<u32> {
        self.first_primitive..self.first_primitive + self.shapes.len() as u32
    }

    /// True if the side of `point` that faces `direction` emits.
    #[inline]
    fn emits(&self, point: &SurfacePoint, direction: DVec3) -> bool {
        let cosine = point.geometric_normal.dot(direction);
        cosine > 0.0 || (self.two_sided && cosine < 0.0)
    }

    /// A point of a shape, uniform by area, as the scene reports it.
    #[inline(always)]
    fn point_on(&self, index: usize, u: DVec2) -> SurfacePoint {
        self.as_reported(index, self.shapes[index].sample_area(u))
    }

    /// A point of a shape with the ids and texture coordinates that the scene reports.
    #[inline(always)]
    fn as_reported(&self, index: usize, point: SurfacePoint) -> SurfacePoint {
        SurfacePoint {
            uv: self.uvs.as_ref().map_or(point.uv, |uvs| interpolated(uvs[index], point.uv)),
            primitive: self.first_primitive + index as u32,
            surface: self.surface,
            ..point
        }
    }
}

/// The bounds of a shape that emits `radiance_integral`, ∫ L dA.
fn bounds_of(shape: &Shape, radiance_integral: f64, two_sided: bool) -> LightBounds {
    let bounds = shape.bounds();
    let normal = match shape {
        Shape::Triangle(triangle) => unit(triangle.cross()),
        Shape::Quad(quad) => unit(quad.cross()),
        Shape::Disk(disk) => Some(disk.normal),
        // From anywhere a ball shows a quarter of its surface.
        Shape::Sphere(_) => return LightBounds::isotropic(bounds, 0.25 * radiance_integral),
    };
    match normal.filter(|_| !two_sided) {
        Some(normal) => LightBounds::lambertian(bounds, radiance_integral, normal),
        None => LightBounds::isotropic(bounds, radiance_integral),
    }
}

impl Endpoint for AreaLight {
    fn sample_point(&self, u1: f64, u2: DVec2) -> Option<PointSample> {
        let (index, _) = self.choice.sample_regardless(None, u1)?;
        let point = self.point_on(index as usize, u2);
        Some(PointSample { point, pdf: self.point_pdf(&point) })
    }

    fn point_pdf(&self, _point: &SurfacePoint) -> PerArea {
        PerArea(1.0 / self.area)
    }

    fn sample_direction(&self, point: &SurfacePoint, u: DVec2) -> Option<DirectionSample> {
        let (mut u, mut side) = (u, 1.0);
        if self.two_sided {
            side = if u.x < 0.5 { 1.0 } else { -1.0 };
            u.x = if u.x < 0.5 { 2.0 * u.x } else { 2.0 * u.x - 1.0 };
        }
        let local = square_to_cosine_hemisphere(u);
        let direction = Frame::from_normal(point.geometric_normal * side).to_world(local);
        let pdf = self.direction_pdf(point, direction);
        // A direction in the tangent plane may round to either side.
        (pdf.value() > 0.0).then(|| DirectionSample {
            from: *point,
            direction,
            pdf,
            weight: self.radiance_at(point) / pdf.value(),
        })
    }

    fn direction_pdf(&self, point: &SurfacePoint, direction: DVec3) -> PerProjected {
        let density = if self.two_sided { 0.5 * FRAC_1_PI } else { FRAC_1_PI };
        if self.emits(point, direction) { PerProjected(density) } else { PerProjected::ZERO }
    }

    #[inline]
    fn emit(&self, point: &SurfacePoint, direction: DVec3) -> Rgb {
        if self.emits(point, direction) { self.radiance_at(point) } else { Rgb::BLACK }
    }

    fn sample_from(&self, receiver: &SurfacePoint, u1: f64, u2: DVec2) -> Option<PointSample> {
        if let Some(flat) = &self.flat
            && !flat.is_near(receiver.position)
        {
            return Some(PointSample { point: flat.point_at(u2), pdf: flat.pdf });
        }
        let (index, pmf) = self.choose(receiver, u1)?;
        let shape = &self.shapes[index];
        let seen = Subtended::new(shape, receiver, self.two_sided);
        let point = match &seen {
            Some(seen) => self.as_reported(index, seen.sample(u2, self.constant.is_none())),
            None => self.point_on(index, u2),
        };
        let pdf = self.density(shape, seen.as_ref(), &point, pmf);
        (pdf.value() > 0.0).then_some(PointSample { point, pdf })
    }

    fn pdf_from(&self, receiver: &SurfacePoint, point: &SurfacePoint) -> PerArea {
        let index = point.primitive.wrapping_sub(self.first_primitive) as usize;
        let Some(shape) = self.shapes.get(index) else { return PerArea::ZERO };
        if let Some(flat) = &self.flat
            && !flat.is_near(receiver.position)
        {
            return flat.pdf;
        }
        let seen = Subtended::new(shape, receiver, self.two_sided);
        self.density(shape, seen.as_ref(), point, self.pmf(receiver, index))
    }
}

impl Light for AreaLight {
    fn power(&self) -> Rgb {
        self.radiance_integral * (PI * if self.two_sided { 2.0 } else { 1.0 })
    }

    fn bounds(&self) -> Option<LightBounds> {
        Some(self.bounds)
    }

    fn can_be_hit(&self) -> bool {
        true
    }

    fn is_black(&self) -> bool {
        self.radiance.range()[1].is_black()
    }

    #[inline]
    fn as_flat(&self) -> Option<&FlatLight> {
        self.flat.as_ref()
    }

    /// False if it is flat, one-sided, and everything is behind it.
    fn can_illuminate(&self, bounds: &Bounds) -> bool {
        let is_in_front = |shape: &Shape| {
            let (origin, normal) = match shape {
                Shape::Triangle(triangle) => (triangle.vertices[0], triangle.cross()),
                Shape::Quad(quad) => (quad.origin, quad.cross()),
                Shape::Disk(disk) => (disk.center, disk.normal),
                Shape::Sphere(_) => return true,
            };
            // The corner that is farthest along the normal.
            let corner = DVec3::select(normal.cmpgt(DVec3::ZERO), bounds.max, bounds.min);
            (corner - origin).dot(normal) > 0.0
        };
        !bounds.is_empty() && (self.two_sided || self.shapes.iter().any(is_in_front))
    }

    fn into_any(self) -> AnyLight {
        AnyLight::Area(Box::new(self))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Quad, Triangle};
    use crate::math::warp::testing::random;

    /// A quad of area 6, of which each half shows one colour of a board.
    fn light() -> AreaLight {
        let quad = Quad { origin: DVec3::ZERO, edge_u: DVec3::X * 2.0, edge_v: DVec3::Y * 3.0 };
        let board = Texture::checkerboard(Rgb::new(1.0, 0.0, 3.0), Rgb::new(5.0, 0.0, 1.0));
        AreaLight::textured(vec![Shape::Quad(quad)], None, 0, 0, board, false).expect("valid")
    }

    #[test]
    fn power_is_the_integral_of_the_texture() {
        let power = light().power();
        assert!(
            (power - Rgb::new(3.0, 0.0, 2.0) * (6.0 * PI)).map(f64::abs).max_component() < 1e-9,
            "{power:?}"
        );
        // 400 000 samples of a weight of relative deviation 2/3: a standard error of 0.1 %.
        let (light, mut rng) = (light(), random(5));
        let n = 400_000;
        let mut sum = Rgb::BLACK;
        for _ in 0..n {
            let point = light.sample_point(rng(), DVec2::new(rng(), rng())).expect("a point");
            let Some(sample) = light.sample_direction(&point.point, DVec2::new(rng(), rng()))
            else {
                continue;
            };
            assert!(
                (sample.weight * sample.pdf.value() - light.emit(&point.point, sample.direction))
                    .max_component()
                    < 1e-12
            );
            // dσ⊥ dA
            sum += sample.weight / point.pdf.value() / f64::from(n);
        }
        assert!(
            (sum[0] / power[0] - 1.0).abs() < 0.005 && (sum[2] / power[2] - 1.0).abs() < 0.005,
            "{sum:?}"
        );
    }

    /// A light that is one flat shape is sampled as one that is not known to be, to the bit.
    #[test]
    fn flat_lights_are_sampled_as_any_other() {
        let quad = Quad {
            origin: DVec3::new(0.3, -1.0, 0.2),
            edge_u: DVec3::new(2.0, 0.1, 0.0),
            edge_v: DVec3::new(0.3, 1.0, -0.7),
        };
        let triangle = Triangle { vertices: [DVec3::ZERO, DVec3::X * 2.0, DVec3::ONE] };
        let radiance = Rgb::new(1.0, 2.0, 3.0);
        let mut rng = random(8);
        for shape in [Shape::Quad(quad), Shape::Triangle(triangle)] {
            let light = |two_sided| AreaLight::new(vec![shape], 7, 5, radiance, two_sided);
            let (light, general) = (light(false).expect("valid"), light(true).expect("valid"));
            let flat = light.as_flat().expect("one flat shape");
            assert!(general.as_flat().is_none());
            let mut by_area = 0;
            for _ in 0..1000 {
                let position = DVec3::from_array([(); 3].map(|()| 10.0 * rng() - 5.0));
                let receiver = SurfacePoint::on_surface(position, 0.0, DVec3::Z);
                let (u1, u2) = (rng(), DVec2::new(rng(), rng()));
                let sample = light.sample_from(&receiver, u1, u2).expect("a point");
                let to_receiver = position - sample.point.position;
                if flat.normal.dot(to_receiver) > 0.0 || !flat.is_near(position) {
                    assert_eq!(Some(sample), general.sample_from(&receiver, u1, u2));
                }
                assert_eq!(sample.pdf, light.pdf_from(&receiver, &sample.point));
                let emitted = light.emit(&sample.point, to_receiver);
                let shines = flat.normal.dot(to_receiver) > 0.0;
                assert_eq!(emitted, if shines { flat.radiance } else { Rgb::BLACK });
                if !flat.is_near(position) {
                    by_area += 1;
                    assert_eq!((sample.point, sample.pdf), (flat.point_at(u2), flat.pdf));
                }
            }
            assert!((500..1000).contains(&by_area), "{by_area}");
        }
    }

    #[test]
    fn triangles_show_the_colours_of_their_corners() {
        let triangle = Triangle { vertices: [DVec3::ZERO, DVec3::X, DVec3::Y] };
        let uvs = vec![[DVec2::splat(0.25), DVec2::new(1.25, 0.25), DVec2::new(0.25, 1.25)]];
        let board = Texture::checkerboard(Rgb::WHITE, Rgb::BLACK);
        let light = AreaLight::textured(
            vec![Shape::Triangle(triangle)],
            Some(uvs),
            0,
            0,
            board.clone(),
            false,
        )
        .expect("valid");
        let mut rng = random(6);
        for _ in 0..1000 {
            let point = light.sample_point(rng(), DVec2::new(rng(), rng())).expect("a point").point;
            let expected = board.at(point.position.truncate() + 0.25);
            assert_eq!(light.emit(&point, DVec3::Z), expected);
            assert_eq!(light.emit(&point, -DVec3::Z), Rgb::BLACK);
        }
        let error = AreaLight::textured(
            vec![Shape::Triangle(triangle)],
            Some(Vec::new()),
            0,
            0,
            board,
            false,
        );
        assert!(matches!(
            error,
            Err(EndpointError::TextureCoordinates { shapes: 1, triangles: 0 })
        ));
    }
}

//! The children of a node of the light tree, and what each could send to a receiver.

use super::LightBounds;
use crate::geometry::{self, SurfacePoint};
use glam::{DVec3, Vec3, Vec4};

/// The children of a node are at most as many.
pub(super) const CHILDREN: usize = 4;
/// Cosines are rounded to f32, outwards by this; a cosine that is less counts as this, too.
const MARGIN: f32 = 1e-3;
/// Within a box its lights are as near as this part of its squared radius: between the mean over a
/// ball, a third, and that over a disk.
const CLOSEST: f32 = 0.1;
/// Part of a node's radius that is the rounding of its children's centres.
const BLUR: f32 = 1e-6;
/// Squared distances below count as inside of what is there, and receivers farther away count as
/// this far in the same direction: squares must stay in range.
const LEAST_SQUARE: f32 = 1e-36;
const FARTHEST: f64 = 1e17;
/// Of children that are items.
const ITEM: u32 = 1 << 31;

/// The units of a tree: positions and radii relative to its size, intensities relative to the
/// largest. They keep f32 in range.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Units {
    center: DVec3,
    inverse_size: f64,
    inverse_intensity: f64,
    inverse_irradiance: f64,
}

impl Units {
    pub fn of(lights: &[(u32, LightBounds)]) -> Self {
        let bounded = lights.iter().filter(|(_, light)| light.is_bounded());
        let all = bounded.fold(LightBounds::NONE, |all, (_, light)| all.union(*light));
        // A power of two keeps positions as they are.
        let radius = if all.bounds.is_empty() { 0.0 } else { all.bounds.radius() };
        let size = if radius > 0.0 { libm::exp2(libm::log2(radius).ceil()) } else { 1.0 };
        let as_intensity = |light: &LightBounds| match light.is_bounded() {
            true => light.intensity,
            false => light.intensity * size * size,
        };
        let lights = lights.iter().map(|(_, light)| as_intensity(light));
        let largest = lights.fold(f64::MIN_POSITIVE, f64::max);
        Self {
            center: if all.bounds.is_empty() { DVec3::ZERO } else { all.bounds.center() },
            inverse_size: 1.0 / size,
            inverse_intensity: 1.0 / largest,
            inverse_irradiance: size * size / largest,
        }
    }
}

/// A receiver in the units of a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Receiver {
    position: DVec3,
    normal: Vec3,
    has_normal: bool,
    is_infinite: bool,
}

impl Receiver {
    #[inline]
    pub fn new(x: &SurfacePoint, units: &Units) -> Self {
        let position = (x.position - units.center) * units.inverse_size;
        let farthest = position.abs().max_element();
        let shrink = if farthest > FARTHEST { FARTHEST / farthest } else { 1.0 };
        Self {
            position: position * shrink,
            normal: x.geometric_normal.as_vec3(),
            has_normal: x.place == geometry::Place::Area,
            is_infinite: x.place == geometry::Place::Infinite,
        }
    }
}

/// The children of a node, each of them lights in a box, with a cone of directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// The middle of all, and the centres of the children relative to it.
    origin: DVec3,
    center: [Vec4; 3],
    /// Half extents of the boxes; infinite for lights without bounds.
    half: [Vec4; 3],
    /// 0 where there is no child.
    intensity: Vec4,
    axis: [Vec4; 3],
    cos_o: Vec4,
    cos_e: Vec4,
    /// Nodes, or items.
    links: [u32; CHILDREN],
    /// Square of the distance within which a centre is no better known.
    blur: f32,
    /// The place of the node among its parent's children; without meaning at the root.
    pub place: Place,
}

/// A place among the children of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Place(u32);

impl Place {
    pub fn new(node: usize, child: usize) -> Self {
        Self((node * CHILDREN + child) as u32)
    }

    #[inline]
    pub fn node(self) -> usize {
        self.0 as usize / CHILDREN
    }

    #[inline]
    pub fn child(self) -> usize {
        self.0 as usize % CHILDREN
    }
}

/// A child of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Child {
    Node(u32),
    Item(u32),
}

impl Node {
    /// A node around lights, still without children.
    pub fn around(lights: &LightBounds, units: &Units, place: Place) -> Self {
        let bounds = lights.bounds;
        let is_bounded = lights.is_bounded();
        let (origin, radius) = match is_bounded {
            true => (
                (bounds.center() - units.center) * units.inverse_size,
                bounds.radius() * units.inverse_size,
            ),
            false => (DVec3::ZERO, 1.0),
        };
        let blur = BLUR * radius as f32;
        Self {
            origin,
            center: [Vec4::ZERO; 3],
            half: [Vec4::ZERO; 3],
            intensity: Vec4::ZERO,
            axis: [Vec4::ZERO; 3],
            cos_o: Vec4::NEG_ONE,
            cos_e: Vec4::NEG_ONE,
            links: [0; CHILDREN],
            blur: (blur * blur).max(LEAST_SQUARE),
            place,
        }
    }

    pub fn set(&mut self, i: usize, lights: &LightBounds, units: &Units, child: Child) {
        let scale = if lights.is_bounded() {
            let half = 0.5 * (lights.bounds.max - lights.bounds.min) * units.inverse_size;
            let center = (lights.bounds.center() - units.center) * units.inverse_size;
            for axis in 0..3 {
                self.center[axis][i] = (center - self.origin)[axis] as f32;
                self.half[axis][i] = match half[axis] > 0.0 {
                    true => (half[axis] as f32).max(f32::MIN_POSITIVE).next_up(),
                    false => 0.0,
                };
            }
            units.inverse_intensity
        } else {
            (0..3).for_each(|axis| self.half[axis][i] = f32::INFINITY);
            units.inverse_irradiance
        };
        (0..3).for_each(|axis| self.axis[axis][i] = lights.axis[axis] as f32);
        // What is there must be seen, however faint.
        self.intensity[i] = ((lights.intensity * scale) as f32).max(f32::MIN_POSITIVE);
        self.cos_o[i] = (libm::cos(lights.theta_o) as f32 - MARGIN).max(-1.0);
        self.cos_e[i] = libm::cos(lights.theta_e) as f32 - MARGIN;
        self.links[i] = match child {
            Child::Node(node) => node,
            Child::Item(item) => item | ITEM,
        };
    }

    #[inline]
    pub fn child(&self, i: usize) -> Child {
        match self.links[i] {
            item if item & ITEM != 0 => Child::Item(item & !ITEM),
            node => Child::Node(node),
        }
    }

    /// The children that there are.
    pub fn children(&self) -> impl Iterator<Item = (usize, Child)> {
        (0..CHILDREN).filter(|i| self.intensity[*i] > 0.0).map(|i| (i, self.child(i)))
    }

    /// 1 for each child.
    pub fn evenly(&self) -> [f64; CHILDREN] {
        std::array::from_fn(|i| if self.intensity[i] > 0.0 { 1.0 } else { 0.0 })
    }

    /// Estimates of the irradiance that each child causes at a receiver where it is not hidden: the
    /// means of `Φ cos θ' cos θ_i/d²` over its box, as if its lights were on a line from the nearest
    /// distance to the farthest (after Conty Estevez and Kulla 2018, section 4.3, who take the
    /// centre's distance and bounds of the cosines). 0 only if it is certain that no light comes: if
    /// `θ' - θ_o - θ_u` is beyond θ_e, where the sphere around the box is seen under the angle 2 θ_u.
    #[inline]
    pub fn importances(&self, x: &Receiver) -> [f64; CHILDREN] {
        let to_origin = (self.origin - x.position).as_vec3();
        let vx = self.center[0] + to_origin.x;
        let vy = self.center[1] + to_origin.y;
        let vz = self.center[2] + to_origin.z;
        let [hx, hy, hz] = self.half;
        let square = vx * vx + vy * vy + vz * vz;
        let radius_square = hx * hx + hy * hy + hz * hz;
        let within = radius_square.max(Vec4::splat(self.blur));
        let is_inside = square.cmple(within);
        // Along a line from the nearest distance to the farthest, the mean of 1/d² and, with a cosine
        // h/d, that of h/d³ over it.
        let by_axis = [(vx, hx), (vy, hy), (vz, hz)];
        let length = |v: [Vec4; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let near = length(by_axis.map(|(v, h)| (v.abs() - h).max(Vec4::ZERO)));
        let far = length(by_axis.map(|(v, h)| v.abs() + h));
        let near = near.max(Vec4::splat(self.blur).sqrt());
        let falloff = (near * far).max(within * CLOSEST).recip();
        let per_length = 0.5 * (near.recip() + far.recip());
        let inverse = square.max(Vec4::splat(LEAST_SQUARE)).sqrt().recip();
        let (wx, wy, wz) = (vx * inverse, vy * inverse, vz * inverse);
        // Heights over a plane vary by as much.
        let spread = |nx: Vec4, ny: Vec4, nz: Vec4| nx.abs() * hx + ny.abs() * hy + nz.abs() * hz;

        let [ax, ay, az] = self.axis;
        let cosine = -(ax * wx + ay * wy + az * wz);
        let (sin, sin_o) = (sine_of(cosine), sine_of(self.cos_o));
        let cos_less = cosine * self.cos_o + sin * sin_o;
        let is_normal = cosine.cmpge(self.cos_o) | is_inside;
        let cos_less = Vec4::select(is_normal, Vec4::ONE, cos_less);
        let sin_less = Vec4::select(is_normal, Vec4::ZERO, sin * self.cos_o - cosine * sin_o);
        let sin_u = (radius_square.sqrt() * inverse).min(Vec4::ONE);
        let cos_u = sine_of(sin_u);
        let nearest = cos_less * cos_u + sin_less * sin_u;
        let is_lit =
            is_normal | cos_less.cmpge(cos_u) | nearest.cmpgt(self.cos_e.max(Vec4::splat(-MARGIN)));
        let emitted = mean_positive(cos_less * square * inverse, spread(ax, ay, az));
        let emitted = (emitted * per_length).clamp(Vec4::splat(MARGIN), Vec4::ONE);
        let emitted = Vec4::select(is_normal, Vec4::ONE, emitted);
        let emitted = Vec4::select(is_lit, emitted, Vec4::ZERO);

        let received = if x.has_normal {
            let [nx, ny, nz] = x.normal.to_array().map(Vec4::splat);
            let mean = mean_absolute(nx * vx + ny * vy + nz * vz, spread(nx, ny, nz));
            (mean * per_length).clamp(Vec4::splat(MARGIN), Vec4::ONE)
        } else {
            Vec4::ONE
        };
        let everywhere = Vec4::splat(f32::INFINITY).cmple(hx);
        let [angles, falloff] = if x.is_infinite {
            [Vec4::ONE; 2]
        } else {
            [emitted * received, falloff].map(|part| Vec4::select(everywhere, Vec4::ONE, part))
        };
        // The product may leave the range of f32.
        let product =
            |i: usize| f64::from(self.intensity[i]) * f64::from(falloff[i]) * f64::from(angles[i]);
        std::array::from_fn(product)
    }
}

#[inline]
fn sine_of(cosine: Vec4) -> Vec4 {
    (1.0 - cosine * cosine).max(Vec4::ZERO).sqrt()
}

/// The mean of |t| for t from x - s to x + s.
#[inline]
fn mean_absolute(x: Vec4, s: Vec4) -> Vec4 {
    let x = x.abs();
    Vec4::select(x.cmpge(s), x, 0.5 * (x * x / s + s))
}

/// The mean of t⁺ for t from x - s to x + s.
#[inline]
fn mean_positive(x: Vec4, s: Vec4) -> Vec4 {
    let above = (x + s).max(Vec4::ZERO);
    Vec4::select(x.cmpge(s), x, 0.25 * above * above / s)
}

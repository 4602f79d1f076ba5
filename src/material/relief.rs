//! Reliefs: slopes of a surface that are too fine for its shape, and that only shading shows.

use super::Texture;
use crate::geometry::Frame;
use glam::{DVec2, DVec3};

/// A normal map or a bump map: the slopes of a surface, as a texture. They change shading normals,
/// and neither shape nor shadows; `docs/numerics.md` says what is seen of slopes that face away.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    texture: Texture,
    scale: f64,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Normals(GreenAxis),
    Heights,
}

/// The direction along the surface in which the green of a normal map grows. Red grows with u.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GreenAxis {
    /// Upwards in the image, against v; or the bitangent of tangents that a mesh has.
    #[default]
    AgainstV,
    /// The cross product of the normal and the direction in which u grows, whatever v does.
    RightHanded,
}

/// The ground of a relief: a point of a surface.
pub(crate) struct Ground {
    /// The shading normal of the shape, a unit vector.
    pub normal: DVec3,
    pub geometric_normal: DVec3,
    /// The direction of growing u.
    pub tangent: DVec3,
    /// The side of the bitangent, 1 or -1 times that of `normal × tangent`, if the mesh says it.
    pub handedness: Option<f64>,
    pub uv: DVec2,
    /// The derivatives of the position by u and v.
    pub partials: [DVec3; 2],
}

impl Relief {
    /// A map of normals, whose components x, y and z are in the texture's red, green and blue as
    /// (1 + x) / 2 and so on. `scale` multiplies x and y before the normal is made unit length.
    #[must_use]
    pub fn normal_map(normals: Texture, scale: f64, green: GreenAxis) -> Self {
        Self { texture: normals, scale, kind: Kind::Normals(green) }
    }

    /// A map of heights, `scale` times the luminance of the texture, in world units. Between
    /// pixels of an image that is interpolated; other textures are flat.
    #[must_use]
    pub fn bump_map(heights: Texture, scale: f64) -> Self {
        Self { texture: heights, scale, kind: Kind::Heights }
    }

    pub(crate) fn texture(&self) -> &Texture {
        &self.texture
    }

    /// The factor of the slopes.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The shading normal of a point: that of the ground where the map gives none on the front of
    /// the surface.
    pub(crate) fn normal(&self, ground: &Ground) -> DVec3 {
        let normal = match self.kind {
            Kind::Normals(green) => self.mapped(green, ground),
            Kind::Heights => self.bumped(ground),
        };
        let is_in_front = |normal: &DVec3| normal.dot(ground.geometric_normal) > 0.0;
        normal.try_normalize().filter(is_in_front).unwrap_or(ground.normal)
    }

    fn mapped(&self, green: GreenAxis, ground: &Ground) -> DVec3 {
        let [x, y, z] = self.texture.at(ground.uv).0.map(|value| 2.0 * value - 1.0);
        let frame = Frame::from_normal_and_tangent(ground.normal, ground.tangent);
        let side = match green {
            GreenAxis::RightHanded => 1.0,
            GreenAxis::AgainstV => ground.handedness.unwrap_or_else(|| {
                let [by_u, by_v] = ground.partials;
                -by_u.cross(by_v).dot(ground.normal).signum()
            }),
        };
        frame.to_world(DVec3::new(self.scale * x, self.scale * y * side, z))
    }

    /// The normal of the surface displaced along its normal, whose own change is left out (Blinn
    /// 1978).
    fn bumped(&self, ground: &Ground) -> DVec3 {
        let slopes = self.texture.gradient(ground.uv) * self.scale;
        let normal = ground.normal;
        let raised = |partial: DVec3, slope: f64| partial + normal * (slope - normal.dot(partial));
        let [by_u, by_v] = ground.partials;
        let raised = raised(by_u, slopes.x).cross(raised(by_v, slopes.y));
        // Against the geometric normal where v grows the other way round.
        if raised.dot(ground.geometric_normal) < 0.0 { -raised } else { raised }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Image;
    use crate::material::{Interpolation, Wrap};
    use crate::math::Rgb;
    use approx::assert_relative_eq;

    fn ground(uv: DVec2) -> Ground {
        Ground {
            normal: DVec3::Z,
            geometric_normal: DVec3::Z,
            tangent: DVec3::X,
            handedness: None,
            uv,
            partials: [DVec3::X * 2.0, DVec3::Y * 3.0],
        }
    }

    /// Green is up in the image, where v shrinks, unless the map is right-handed or the mesh tells.
    #[test]
    fn red_and_green_have_directions() {
        let normals = || Texture::from(Rgb::new(0.8, 0.9, 1.0));
        let at = |green, ground: &Ground| Relief::normal_map(normals(), 0.5, green).normal(ground);
        let (up, down) = (DVec3::new(0.3, 0.4, 1.0), DVec3::new(0.3, -0.4, 1.0));
        let flat = ground(DVec2::ZERO);
        let mirrored = Ground { partials: [DVec3::X, DVec3::NEG_Y], ..ground(DVec2::ZERO) };
        let told = Ground { handedness: Some(1.0), ..ground(DVec2::ZERO) };
        for (green, ground, expected) in [
            (GreenAxis::AgainstV, &flat, down),
            (GreenAxis::AgainstV, &mirrored, up),
            (GreenAxis::AgainstV, &told, up),
            (GreenAxis::RightHanded, &flat, up),
            (GreenAxis::RightHanded, &mirrored, up),
        ] {
            let (normal, expected) = (at(green, ground), expected.normalize());
            assert_relative_eq!(normal, expected, max_relative = 1e-14);
        }
        // A normal below the surface is none.
        let below = Relief::normal_map(Rgb::new(1.0, 0.5, 0.2).into(), 1.0, GreenAxis::AgainstV);
        assert_eq!(below.normal(&flat), DVec3::Z);
    }

    /// The normal of heights is that of the displaced plane, whichever way its parameters turn.
    #[test]
    fn heights_have_the_normals_of_their_slopes() {
        let image = Image::from_fn(4, 4, |x, y| Rgb::splat(0.25 * f64::from(x) - f64::from(y * y)));
        let heights =
            Texture::bitmap(image, Interpolation::Bilinear, [Wrap::Clamp; 2]).expect("valid");
        let turned = glam::DAffine2::from_scale_angle_translation(
            DVec2::new(0.5, 0.75),
            0.3,
            DVec2::splat(0.4),
        );
        let heights = heights.with_transform(turned).expect("finite");
        let relief = Relief::bump_map(heights.clone(), 0.7);
        let uv = DVec2::new(0.31, 0.12);
        let step = 1e-6;
        let along = |d: DVec2| {
            let height = |uv| 0.7 * heights.at(uv).luminance();
            (height(uv + d * step) - height(uv - d * step)) / (2.0 * step)
        };
        let (by_u, by_v) = (along(DVec2::X), along(DVec2::Y));
        assert!(by_u.abs() > 0.1 && by_v.abs() > 0.1, "{by_u} {by_v}");
        for side in [1.0, -1.0] {
            let base = ground(uv);
            let partials = [base.partials[0], base.partials[1] * side];
            let expected = DVec3::new(-by_u / 2.0, -by_v / (3.0 * side), 1.0).normalize();
            let normal = relief.normal(&Ground { partials, ..base });
            assert_relative_eq!(normal, expected, max_relative = 1e-8);
        }
        // Without parameters there are no slopes.
        let lost = Ground { partials: [DVec3::ZERO; 2], ..ground(uv) };
        assert_eq!(relief.normal(&lost), DVec3::Z);
    }
}

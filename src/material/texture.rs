//! Colours that vary over a surface: functions of its parameters uv.
//!
//! A texture is looked up at `to_uv · (u, v)`, u to the right and v downwards in an image whose
//! upper left corner is at (0, 0) and whose lower right corner is at (1, 1). Values are linear RGB;
//! what they mean (a reflectance, a radiance, a weight) is up to the user.

use super::VertexSite;
use crate::film::Image;
use crate::math::Rgb;
use glam::{DAffine2, DVec2};
use std::sync::Arc;

/// A colour as a function of uv; cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    pattern: Pattern,
    to_uv: DAffine2,
    factor: Rgb,
    /// The threshold of a texture in black and white: black where no channel reaches it.
    cutoff: Option<f64>,
    /// True if it is looked up at the other texture coordinates of a mesh.
    other_coordinates: bool,
    vertex_factor: Option<VertexFactor>,
}

/// A factor of a texture that a mesh has at its vertices ([`Mesh::colors`](crate::scene::Mesh)), 1
/// where it has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexFactor {
    /// The colour.
    Color,
    /// The alpha, as grey.
    Alpha,
}

#[derive(Clone, Debug, PartialEq)]
enum Pattern {
    Constant(Rgb),
    Checkerboard([Rgb; 2]),
    Bitmap { bitmap: Bitmap, interpolation: Interpolation, wrap: [Wrap; 2] },
    Product(Arc<[Texture; 2]>),
}

/// An image that textures can show, with the range of its colours, which is found once for all of
/// them; cheap to clone.
#[derive(Clone, Debug)]
pub struct Bitmap {
    image: Arc<Image>,
    range: [Rgb; 2],
}

/// The lookup of an image between the centres of its pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The nearest pixel.
    Nearest,
    /// Linear along both axes.
    #[default]
    Bilinear,
}

/// The continuation of an image beyond its border along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Repeated again and again.
    #[default]
    Repeat,
    /// Repeated again and again, every other time mirrored.
    Mirror,
    /// Continued by its outermost pixels.
    Clamp,
}

/// The reason for refusing a texture.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// The image has no pixels.
    #[error("the image has no pixels")]
    Empty,
    /// A colour is infinite or not a number.
    #[error("a colour of the texture is infinite or not a number")]
    NotFinite,
    /// The transform of uv is infinite or not a number.
    #[error("the transform of texture coordinates is infinite or not a number")]
    Transform,
    /// A texture that has been cut to black and white cannot be scaled.
    #[error("a texture that has been cut to black and white cannot be scaled")]
    Cut,
    /// The colours of a product of textures cannot be clamped or changed.
    #[error("the colours of a product of textures cannot be clamped or changed")]
    Product,
}

impl From<Rgb> for Texture {
    fn from(colour: Rgb) -> Self {
        Self::of(Pattern::Constant(colour))
    }
}

impl Texture {
    const fn of(pattern: Pattern) -> Self {
        Self {
            pattern,
            to_uv: DAffine2::IDENTITY,
            factor: Rgb::WHITE,
            cutoff: None,
            other_coordinates: false,
            vertex_factor: None,
        }
    }

    /// Two colours in the squares of a board, four squares per unit square: the first where u and v
    /// are both in the first or both in the second half.
    #[must_use]
    pub fn checkerboard(first: Rgb, second: Rgb) -> Self {
        Self::of(Pattern::Checkerboard([first, second]))
    }

    /// An image; `wrap` along u and along v.
    ///
    /// # Errors
    /// If the image has no pixels, or one that is infinite or not a number.
    pub fn bitmap(
        image: impl Into<Arc<Image>>,
        interpolation: Interpolation,
        wrap: [Wrap; 2],
    ) -> Result<Self, TextureError> {
        Bitmap::new(image).map(|bitmap| bitmap.texture(interpolation, wrap))
    }

    /// The same texture, with another transform applied to texture coordinates before all others.
    ///
    /// # Errors
    /// If the transform is not finite.
    pub fn with_transform(mut self, to_uv: DAffine2) -> Result<Self, TextureError> {
        if let Pattern::Product(factors) = &self.pattern {
            let [first, second] = factors.each_ref().map(|f| f.clone().with_transform(to_uv));
            return Ok(Self { pattern: Pattern::Product(Arc::new([first?, second?])), ..self });
        }
        self.to_uv *= to_uv;
        if self.to_uv.is_finite() { Ok(self) } else { Err(TextureError::Transform) }
    }

    /// The same texture with every colour multiplied.
    ///
    /// # Errors
    /// If the factor is not finite.
    pub fn scaled(mut self, factor: Rgb) -> Result<Self, TextureError> {
        if !factor.is_finite() {
            return Err(TextureError::NotFinite);
        }
        match self.cutoff {
            // What was cut is black or white.
            Some(_) => return Err(TextureError::Cut),
            None => self.factor *= factor,
        }
        Ok(self)
    }

    /// The same texture in other colours: `change` is applied to those of the pattern, before an
    /// image is interpolated, which for an affine change is the same as after.
    ///
    /// # Errors
    /// If a colour becomes infinite or not a number, or the texture has been cut or is a product.
    pub fn recoloured(&self, change: impl Fn(Rgb) -> Rgb) -> Result<Self, TextureError> {
        if self.cutoff.is_some() {
            return Err(TextureError::Cut);
        }
        let change = |colour: Rgb| change(colour * self.factor);
        let pattern = match &self.pattern {
            Pattern::Constant(colour) => Pattern::Constant(change(*colour)),
            Pattern::Checkerboard(colours) => Pattern::Checkerboard(colours.map(change)),
            Pattern::Bitmap { bitmap: Bitmap { image, .. }, interpolation, wrap } => {
                let mut image = Image::clone(image);
                image.pixels_mut().iter_mut().for_each(|pixel| *pixel = change(*pixel));
                let (interpolation, wrap) = (*interpolation, *wrap);
                Pattern::Bitmap { bitmap: Bitmap::new(image)?, interpolation, wrap }
            }
            Pattern::Product(_) => return Err(TextureError::Product),
        };
        let recoloured = Self { pattern, factor: Rgb::WHITE, ..self.clone() };
        let [least, greatest] = recoloured.range();
        let is_finite = least.is_finite() && greatest.is_finite();
        if is_finite { Ok(recoloured) } else { Err(TextureError::NotFinite) }
    }

    /// The image that it shows, if it shows one.
    #[must_use]
    pub fn image(&self) -> Option<&Image> {
        match &self.pattern {
            Pattern::Bitmap { bitmap, .. } => Some(&bitmap.image),
            _ => None,
        }
    }

    /// White where a channel is at least `cutoff`, black elsewhere.
    #[must_use]
    pub fn cut(self, cutoff: f64) -> Self {
        Self { cutoff: Some(cutoff), ..self }
    }

    /// The same texture with every channel of its colours clamped to a range.
    ///
    /// # Errors
    /// If it is a product.
    pub fn clamped(self, least: f64, greatest: f64) -> Result<Self, TextureError> {
        let clamp = |colour: Rgb| colour.map(|c| c.clamp(least, greatest));
        let factor = self.factor;
        let pattern = match self.pattern {
            Pattern::Constant(colour) => Pattern::Constant(clamp(colour * factor)),
            Pattern::Checkerboard(colours) => {
                Pattern::Checkerboard(colours.map(|colour| clamp(colour * factor)))
            }
            Pattern::Bitmap { bitmap, interpolation, wrap } => {
                let image = bitmap.image;
                let pixel = |x, y| clamp(image.get(x, y).unwrap_or_default() * factor);
                let clamped = Image::from_fn(image.width(), image.height(), pixel);
                Pattern::Bitmap { bitmap: Bitmap::new(clamped)?, interpolation, wrap }
            }
            Pattern::Product(_) => return Err(TextureError::Product),
        };
        Ok(Self { pattern, factor: Rgb::WHITE, ..self })
    }

    /// The product with another texture, channel by channel.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        Self::of(Pattern::Product(Arc::new([self, other])))
    }

    /// True if it has been cut to black and white.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.cutoff.is_some()
    }

    /// The same texture, looked up at the other set of texture coordinates on a
    /// [mesh](crate::scene::Mesh) that has two. Emission has the first one.
    #[must_use]
    pub fn with_other_coordinates(self) -> Self {
        if let Pattern::Product(factors) = &self.pattern {
            let factors = factors.each_ref().map(|factor| factor.clone().with_other_coordinates());
            return Self { pattern: Pattern::Product(Arc::new(factors)), ..self };
        }
        Self { other_coordinates: true, ..self }
    }

    /// The same texture, multiplied by what a [mesh](crate::scene::Mesh) has at its vertices
    /// before it is cut. Emission, maps and lights see no vertices.
    #[must_use]
    pub fn with_vertex_factor(self, factor: VertexFactor) -> Self {
        Self { vertex_factor: Some(factor), ..self }
    }

    /// True if it is looked up at the other set of texture coordinates.
    pub(crate) fn has_other_coordinates(&self) -> bool {
        self.other_coordinates
    }

    /// True if a mesh may have more to say about it than one pair of texture coordinates.
    #[inline]
    pub(crate) fn asks_vertices(&self) -> bool {
        let is_product_of_such = match &self.pattern {
            Pattern::Product(factors) => factors.iter().any(Self::asks_vertices),
            _ => false,
        };
        self.other_coordinates || self.vertex_factor.is_some() || is_product_of_such
    }

    /// The colour, if it is the same everywhere.
    #[inline]
    #[must_use]
    pub fn as_constant(&self) -> Option<Rgb> {
        match &self.pattern {
            _ if self.vertex_factor.is_some() => None,
            Pattern::Constant(colour) => Some(self.finish(*colour)),
            Pattern::Product(factors) => {
                let [first, second] = factors.each_ref().map(Self::as_constant);
                Some(self.finish(first? * second?))
            }
            Pattern::Checkerboard(_) | Pattern::Bitmap { .. } => None,
        }
    }

    /// A colour of the pattern after the factor and the cutoff.
    fn finish(&self, colour: Rgb) -> Rgb {
        let colour = colour * self.factor;
        match self.cutoff {
            None => colour,
            Some(cutoff) if colour.max_component() >= cutoff => Rgb::WHITE,
            Some(_) => Rgb::BLACK,
        }
    }

    /// The colour at a point of the surface.
    #[inline]
    #[must_use]
    pub fn at(&self, uv: DVec2) -> Rgb {
        self.finish(self.look_up(uv))
    }

    /// The colour at a point of a surface with these texture coordinates, perhaps on a mesh.
    #[inline]
    pub(crate) fn seen<'a>(&self, uv: DVec2, site: &impl Fn() -> Option<VertexSite<'a>>) -> Rgb {
        if self.asks_vertices() { self.on_vertices(uv, site()) } else { self.at(uv) }
    }

    #[inline(never)]
    fn on_vertices(&self, uv: DVec2, site: Option<VertexSite<'_>>) -> Rgb {
        match site {
            Some(site) => self.on_mesh(&site),
            None => self.at(uv),
        }
    }

    /// The colour at a point of a mesh.
    pub(crate) fn on_mesh(&self, site: &VertexSite<'_>) -> Rgb {
        let colour = match &self.pattern {
            Pattern::Product(factors) => factors[0].on_mesh(site) * factors[1].on_mesh(site),
            _ => self.look_up(site.uv(self.other_coordinates)),
        };
        self.finish(match self.vertex_factor {
            None => colour,
            Some(VertexFactor::Color) => {
                let [r, g, b, _] = site.color().to_array();
                colour * Rgb::new(r, g, b)
            }
            Some(VertexFactor::Alpha) => colour * site.color().w,
        })
    }

    fn look_up(&self, uv: DVec2) -> Rgb {
        if let Pattern::Constant(colour) = self.pattern {
            return colour;
        }
        let uv = self.to_uv.transform_point2(uv);
        match &self.pattern {
            Pattern::Constant(colour) => *colour,
            Pattern::Product(factors) => factors[0].at(uv) * factors[1].at(uv),
            Pattern::Checkerboard(colours) => {
                let half = |x: f64| x - x.floor() >= 0.5;
                colours[usize::from(half(uv.x) != half(uv.y))]
            }
            Pattern::Bitmap { bitmap, interpolation, wrap } => match interpolation {
                Interpolation::Nearest => {
                    let p = uv * bitmap.size();
                    bitmap.pixel(*wrap, p.x.floor() as i64, p.y.floor() as i64)
                }
                Interpolation::Bilinear => {
                    let ([top, bottom], f) = bitmap.around(*wrap, uv);
                    let across = |[left, right]: [Rgb; 2]| left * (1.0 - f.x) + right * f.x;
                    across(top) * (1.0 - f.y) + across(bottom) * f.y
                }
            },
        }
    }

    /// The derivatives of the luminance by u and v. Between pixels an image that is interpolated
    /// has some; patterns that jump have none.
    pub(crate) fn gradient(&self, uv: DVec2) -> DVec2 {
        let Pattern::Bitmap { bitmap, interpolation: Interpolation::Bilinear, wrap } =
            &self.pattern
        else {
            return DVec2::ZERO;
        };
        if self.cutoff.is_some() {
            return DVec2::ZERO;
        }
        let (corners, f) = bitmap.around(*wrap, self.to_uv.transform_point2(uv));
        let [[a, b], [c, d]] =
            corners.map(|row| row.map(|colour| (colour * self.factor).luminance()));
        let by_pixel = DVec2::new(
            (b - a) * (1.0 - f.y) + (d - c) * f.y,
            (c - a) * (1.0 - f.x) + (d - b) * f.x,
        ) * bitmap.size();
        self.to_uv.matrix2.transpose() * by_pixel
    }

    /// Every value is between two colours, channel by channel: these.
    #[must_use]
    pub fn range(&self) -> [Rgb; 2] {
        if let Some(cutoff) = self.cutoff {
            let uncut = Self { cutoff: None, ..self.clone() };
            let shown = |colour: Rgb| if colour.max_component() >= cutoff { 1.0 } else { 0.0 };
            return uncut.range().map(|bound| Rgb::splat(shown(bound)));
        }
        let [least, greatest] = match &self.pattern {
            Pattern::Constant(colour) => [*colour; 2],
            Pattern::Checkerboard(colours) => hull(colours),
            Pattern::Bitmap { bitmap, .. } => bitmap.range,
            Pattern::Product(factors) => {
                let [a, b] = factors.each_ref().map(Self::range);
                hull(&[a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]])
            }
        };
        // A negative factor swaps them, and vertices may make them black.
        let [least, greatest] = [least * self.factor, greatest * self.factor];
        match self.vertex_factor {
            None => hull(&[least, greatest]),
            Some(_) => hull(&[least, greatest, Rgb::BLACK]),
        }
    }

    /// True if all colours are finite and in a range, channel by channel.
    #[must_use]
    pub fn is_within(&self, least: f64, greatest: f64) -> bool {
        let valid =
            |colour: &Rgb| colour.0.iter().all(|c| c.is_finite() && (least..=greatest).contains(c));
        match &self.pattern {
            Pattern::Checkerboard(colours) if self.vertex_factor.is_none() => {
                colours.iter().all(|colour| valid(&self.finish(*colour)))
            }
            _ => self.range().iter().all(valid),
        }
    }
}

impl Bitmap {
    /// A checked image.
    ///
    /// # Errors
    /// If the image has no pixels, or one that is infinite or not a number.
    pub fn new(image: impl Into<Arc<Image>>) -> Result<Self, TextureError> {
        let image = image.into();
        if image.pixels().is_empty() {
            return Err(TextureError::Empty);
        }
        if !image.pixels().iter().all(|pixel| pixel.is_finite()) {
            return Err(TextureError::NotFinite);
        }
        let range = hull(image.pixels());
        Ok(Self { image, range })
    }

    /// The image.
    #[must_use]
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// A texture of the image; `wrap` along u and along v.
    #[must_use]
    pub fn texture(self, interpolation: Interpolation, wrap: [Wrap; 2]) -> Texture {
        Texture::of(Pattern::Bitmap { bitmap: self, interpolation, wrap })
    }

    fn size(&self) -> DVec2 {
        DVec2::new(f64::from(self.image.width()), f64::from(self.image.height()))
    }

    #[inline]
    fn pixel(&self, wrap: [Wrap; 2], x: i64, y: i64) -> Rgb {
        let size = [self.image.width() as usize, self.image.height() as usize];
        self.image.pixels()[wrap[1].index(y, size[1]) * size[0] + wrap[0].index(x, size[0])]
    }

    /// The pixels whose centres are around a place, row by row, and where it is between them.
    #[inline]
    fn around(&self, wrap: [Wrap; 2], uv: DVec2) -> ([[Rgb; 2]; 2], DVec2) {
        let p = uv * self.size() - 0.5;
        let corner = p.floor();
        let (x, y) = (corner.x as i64, corner.y as i64);
        let row = |y| [x, x.saturating_add(1)].map(|x| self.pixel(wrap, x, y));
        ([y, y.saturating_add(1)].map(row), p - corner)
    }
}

impl PartialEq for Bitmap {
    fn eq(&self, other: &Self) -> bool {
        // Most often it is one image in memory, whose pixels need no comparison.
        Arc::ptr_eq(&self.image, &other.image) || self.image == other.image
    }
}

/// The least and the greatest value of each channel of at least one colour.
fn hull(colours: &[Rgb]) -> [Rgb; 2] {
    let [mut least, mut greatest] = [colours[0].0; 2];
    for colour in colours {
        for channel in 0..3 {
            least[channel] = least[channel].min(colour[channel]);
            greatest[channel] = greatest[channel].max(colour[channel]);
        }
    }
    [Rgb(least), Rgb(greatest)]
}

impl Wrap {
    /// The pixel that stands at an index beyond the border.
    fn index(self, i: i64, size: usize) -> usize {
        let n = size as i64;
        let wrapped = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let j = i.rem_euclid(2 * n);
                if j < n { j } else { 2 * n - 1 - j }
            }
        };
        wrapped as usize
    }
}

#[cfg(test)]
mod tests;

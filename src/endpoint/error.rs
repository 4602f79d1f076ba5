//! The reasons for which a light or a camera cannot be made.

use glam::UVec2;

/// The reason for which a light or a camera could not be made. `object` says which kind it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EndpointError {
    /// A number is infinite or not a number.
    #[error("{object}: {quantity} is infinite or not a number")]
    NotFinite {
        /// Kind of endpoint.
        object: &'static str,
        /// The quantity that the number stands for.
        quantity: &'static str,
    },
    /// A quantity that cannot be negative is.
    #[error("{object}: {quantity} is negative")]
    Negative {
        /// Kind of endpoint.
        object: &'static str,
        /// The quantity that the number stands for.
        quantity: &'static str,
    },
    /// A quantity that must be positive is not.
    #[error("{object}: {quantity} must be positive, but is {value}")]
    NotPositive {
        /// Kind of endpoint.
        object: &'static str,
        /// The quantity that the number stands for.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A direction has length zero.
    #[error("{object}: {quantity} has length zero")]
    ZeroDirection {
        /// Kind of endpoint.
        object: &'static str,
        /// The quantity that the direction stands for.
        quantity: &'static str,
    },
    /// An angle is out of its range.
    #[error("{object}: {quantity} is {degrees} degrees, but must be in {range}")]
    AngleOutOfRange {
        /// Kind of endpoint.
        object: &'static str,
        /// The quantity that the angle stands for.
        quantity: &'static str,
        /// The angle in degrees.
        degrees: f64,
        /// The valid range.
        range: &'static str,
    },
    /// The camera is where it looks at.
    #[error("{object}: its position and its target are the same")]
    CameraAtTarget {
        /// Kind of camera.
        object: &'static str,
    },
    /// The up vector is parallel to the view.
    #[error("{object}: the up vector is zero or parallel to the view")]
    UpParallelToView {
        /// Kind of camera.
        object: &'static str,
    },
    /// The film has no pixels, or more than 2³² - 1 of them.
    #[error(
        "{object}: a film of {} x {} pixels has none or more than 2^32 - 1 of them",
        .resolution.x, .resolution.y
    )]
    FilmSize {
        /// Kind of camera.
        object: &'static str,
        /// The film's resolution.
        resolution: UVec2,
    },
    /// The window is empty or reaches out of the film.
    #[error(
        "{object}: the window from {min} to {max} is empty or reaches out of the film of {} x \
         {} pixels",
        .resolution.x, .resolution.y
    )]
    WindowOutsideFilm {
        /// Kind of camera.
        object: &'static str,
        /// First pixel of the window.
        min: UVec2,
        /// One past its last pixel.
        max: UVec2,
        /// The film's resolution.
        resolution: UVec2,
    },
    /// An area light whose shapes have no area in total.
    #[error("area light: its {shapes} shapes have no area")]
    NoArea {
        /// The number of its shapes.
        shapes: usize,
    },
    /// The radius of a shape is negative, or its area is infinite or not a number.
    #[error(
        "area light: shape {index} has a negative radius, or an area that is infinite or not a \
         number"
    )]
    InvalidShape {
        /// Its index in the light.
        index: usize,
    },
    /// There are more shapes than primitive numbers.
    #[error("area light: {shapes} shapes are more than there are primitive numbers left")]
    TooManyShapes {
        /// The number of the light's shapes.
        shapes: usize,
    },
    /// An area light has texture coordinates for another number of triangles than it has shapes.
    #[error("area light: texture coordinates for {triangles} triangles, but {shapes} shapes")]
    TextureCoordinates {
        /// The number of its shapes.
        shapes: usize,
        /// The number of triangles that have texture coordinates.
        triangles: usize,
    },
    /// The number of pixels is not the product of width and height, or is zero.
    #[error(
        "environment map: {pixels} pixels given for a map of {width} x {height}, which must \
         have at least one"
    )]
    PixelCount {
        /// Width of the map.
        width: u32,
        /// Height of the map.
        height: u32,
        /// Pixels given.
        pixels: usize,
    },
    /// A pixel of an environment map is negative, infinite or not a number.
    #[error(
        "environment map: the pixel in column {column} of row {row} is negative, infinite or \
         not a number"
    )]
    InvalidPixel {
        /// Its column.
        column: u32,
        /// Its row.
        row: u32,
    },
    /// A rotation is not orthogonal.
    #[error("{object}: the rotation is not an orthogonal matrix")]
    NotARotation {
        /// Kind of endpoint.
        object: &'static str,
    },
}

//! An endpoint as what it answers to fixed questions.

use super::{DirectionSample, Endpoint, PointSample};
use crate::math::Rgb;
use glam::DVec2;

/// Numbers per dimension.
const GRID: u32 = 6;

/// The answers of an endpoint to fixed questions: points, directions and emission for numbers on a
/// grid. They tell endpoints apart whose types nothing is known of.
pub(crate) fn answers(
    endpoint: &(impl Endpoint + ?Sized),
) -> Vec<(Option<PointSample>, Option<DirectionSample>, Rgb)> {
    let number = |index: u32| (f64::from(index) + 0.37) / f64::from(GRID);
    let answer = |index: u32| {
        let [a, b] = [number(index % GRID), number(index / GRID)];
        let point = endpoint.sample_point(number(index * 7 % GRID), DVec2::new(b, a));
        let direction = point
            .as_ref()
            .and_then(|sample| endpoint.sample_direction(&sample.point, DVec2::new(a, b)));
        let emitted = point.as_ref().zip(direction.as_ref());
        let emitted = emitted.map(|(point, d)| endpoint.emit(&point.point, d.direction));
        (point, direction, emitted.unwrap_or(Rgb::BLACK))
    };
    (0..GRID * GRID).map(answer).collect()
}

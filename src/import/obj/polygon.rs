//! Triangles of polygons.

use glam::{DVec2, DVec3};

/// Polygons of more corners are not searched for ears, since that takes the cube of their number.
const MOST_CORNERS: usize = 256;

/// The triangles of a polygon of at least three corners, as numbers of corners; `false` if it
/// bends inwards and has too many corners to find out where.
///
/// Polygons that bend outwards only become fans, others lose one ear after the other (Meisters
/// 1975).
pub(super) fn triangulate(corners: &[DVec3], mut triangle: impl FnMut([usize; 3])) -> bool {
    let mut fan = || (2..corners.len()).for_each(|k| triangle([0, k - 1, k]));
    if corners.len() == 3 {
        fan();
        return true;
    }
    let flat = projected(corners);
    let turn = |a: usize, b: usize, c: usize| (flat[b] - flat[a]).perp_dot(flat[c] - flat[b]);
    let n = corners.len();
    let is_convex = (0..n).all(|k| turn(k, (k + 1) % n, (k + 2) % n) >= 0.0);
    if is_convex || n > MOST_CORNERS {
        fan();
        return is_convex;
    }
    let mut left: Vec<usize> = (0..n).collect();
    while left.len() > 3 {
        let m = left.len();
        let around = |k: usize| [left[(k + m - 1) % m], left[k], left[(k + 1) % m]];
        let is_ear = |&k: &usize| {
            let [a, b, c] = around(k);
            let is_inside = |&p: &usize| {
                ![a, b, c].contains(&p)
                    && ![a, b, c].map(|q| flat[q]).contains(&flat[p])
                    && [(a, b), (b, c), (c, a)].iter().all(|&(from, to)| {
                        (flat[to] - flat[from]).perp_dot(flat[p] - flat[from]) >= 0.0
                    })
            };
            turn(a, b, c) > 0.0 && !left.iter().any(is_inside)
        };
        // One without area is no loss, and one that crosses itself has no right answer.
        let ear = (0..m).find(is_ear).unwrap_or(0);
        triangle(around(ear));
        left.remove(ear);
    }
    triangle([left[0], left[1], left[2]]);
    true
}

/// The polygon seen along the axis that its normal (Newell's) is nearest to, counter-clockwise.
fn projected(corners: &[DVec3]) -> Vec<DVec2> {
    let next = corners.iter().cycle().skip(1);
    let normal: DVec3 = corners.iter().zip(next).map(|(a, b)| (a - corners[0]).cross(b - a)).sum();
    let axis = normal.abs().max_position();
    let sign = normal[axis].signum();
    let (x, y) = ((axis + 1) % 3, (axis + 2) % 3);
    corners.iter().map(|p| DVec2::new(p[x], p[y] * sign)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(corners: &[DVec3]) -> Vec<[usize; 3]> {
        let mut all = Vec::new();
        assert!(triangulate(corners, |triangle| all.push(triangle)));
        all
    }

    /// Twice the area of each triangle, positive where it is turned as the polygon is.
    fn areas(corners: &[DVec3], towards: DVec3) -> Vec<f64> {
        let area = |[a, b, c]: [usize; 3]| {
            (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(towards)
        };
        triangles(corners).into_iter().map(area).collect()
    }

    #[test]
    fn polygons_are_covered_once() {
        // An L, a comb, and a quadrilateral whose second corner is the one that bends inwards.
        let ell = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)];
        let comb = [
            (0, 0),
            (7, 0),
            (7, 3),
            (6, 3),
            (6, 1),
            (4, 1),
            (4, 3),
            (3, 3),
            (3, 1),
            (1, 1),
            (0, 3),
        ];
        let dart = [(0, 2), (1, 1), (2, 2), (1, 0)];
        let square = [(0, 0), (1, 0), (1, 1), (0, 1)];
        for (outline, doubled) in
            [(&ell[..], 6.0), (&comb[..], 24.0), (&dart[..], 2.0), (&square[..], 2.0)]
        {
            for (u, v) in [(DVec3::X, DVec3::Y), (DVec3::Z, DVec3::Y), (DVec3::NEG_X, DVec3::Z)] {
                let corners: Vec<DVec3> =
                    outline.iter().map(|&(x, y)| u * f64::from(x) + v * f64::from(y)).collect();
                for start in 0..corners.len() {
                    let mut turned = corners.clone();
                    turned.rotate_left(start);
                    let front = if outline == dart { v.cross(u) } else { u.cross(v) };
                    for (corners, towards) in
                        [(turned.clone(), front), (turned.into_iter().rev().collect(), -front)]
                    {
                        let areas = areas(&corners, towards);
                        assert_eq!(areas.len(), corners.len() - 2);
                        assert!(areas.iter().all(|area| *area >= 0.0), "{outline:?} {areas:?}");
                        assert_eq!(areas.iter().sum::<f64>(), doubled, "{outline:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn degenerate_polygons_have_as_many_triangles() {
        let line: Vec<DVec3> = (0..6).map(|k| DVec3::X * f64::from(k * k % 5)).collect();
        assert_eq!(triangles(&line).len(), 4);
        assert_eq!(triangles(&[DVec3::ONE; 5]).len(), 3);
        let star: Vec<DVec3> = (0..400)
            .map(|k| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 400.0).sin_cos();
                DVec3::new(cos, sin, 0.0) * f64::from(1 + k % 2)
            })
            .collect();
        let mut count = 0;
        assert!(!triangulate(&star, |_| count += 1));
        assert_eq!(count, 398);
    }
}

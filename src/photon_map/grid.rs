//! The hash grid that finds points near a point.

use super::has_area;
use glam::DVec3;

/// Points sorted by the cells of a grid over all of space, whose rows of cells a hash function maps
/// to a table of buckets (Teschner et al. 2003, "Optimized Spatial Hashing for Collision Detection
/// of Deformable Objects").
///
/// A cell is r × 2r × 2r for balls of radius r, so that a ball meets three cells in each of four
/// rows. Cells next to each other in a row are buckets next to each other, hence one range of
/// points. Smaller cells along x leave fewer points outside the ball in that range, while smaller
/// ones along y or z would give more rows, each of which may wait for memory.
///
/// The cell of a point is a function that never falls as a coordinate grows, rounding and
/// saturation included, so whatever lies between two positions lies between their cells. Nothing is
/// lost at any scale or distance from the origin.
#[derive(Clone, Debug)]
pub(super) struct HashGrid<T> {
    radius: f64,
    /// Cells per unit of length along each axis.
    resolution: DVec3,
    /// The first point of each bucket, and at the end the number of points.
    starts: Vec<u32>,
    /// Positions of the points.
    positions: Vec<DVec3>,
    points: Vec<T>,
}

impl<T> HashGrid<T> {
    /// The grid of some points for balls of one radius; without points if the square of the radius
    /// is zero, subnormal, infinite or not a number. `None` if there is not enough memory or there
    /// are more than 2³² - 1 points.
    pub(super) fn build(
        points: Vec<T>,
        radius: f64,
        position: impl Fn(&T) -> DVec3,
    ) -> Option<Self> {
        let points = if has_area(radius) { points } else { Vec::new() };
        let buckets = points.len().checked_next_power_of_two()?;
        Self::with_buckets(buckets, points, radius, position)
    }

    /// Sorts by counting, which is stable. `buckets` is a power of two.
    fn with_buckets(
        buckets: usize,
        mut points: Vec<T>,
        radius: f64,
        position: impl Fn(&T) -> DVec3,
    ) -> Option<Self> {
        u32::try_from(points.len()).ok()?;
        let mut grid = Self {
            radius,
            resolution: DVec3::new(1.0, 0.5, 0.5) / radius,
            starts: reserved(buckets + 1)?,
            positions: reserved(points.len())?,
            points: Vec::new(),
        };
        grid.starts.resize(buckets + 1, 0);
        let mut places: Vec<u32> = reserved(points.len())?;
        for point in &points {
            let [x, y, z] = grid.cell(position(point));
            let bucket = grid.bucket(row(y, z), x);
            grid.starts[bucket] += 1;
            places.push(bucket as u32);
        }
        // Counts become the buckets' ends; placing points from the last one on makes them starts.
        let mut end = 0;
        for start in &mut grid.starts {
            end += *start;
            *start = end;
        }
        for place in places.iter_mut().rev() {
            let start = &mut grid.starts[*place as usize];
            *start -= 1;
            *place = *start;
        }
        for i in 0..points.len() {
            while places[i] as usize != i {
                let place = places[i] as usize;
                points.swap(i, place);
                places.swap(i, place);
            }
        }
        grid.positions.extend(points.iter().map(position));
        grid.points = points;
        Some(grid)
    }

    /// The cell of a position; the last one along an axis has everything beyond, too.
    #[inline]
    fn cell(&self, position: DVec3) -> [i64; 3] {
        // `f64::floor` is a call where the instruction set has no rounding.
        let floor = |x: f64| {
            let towards_zero = x as i64;
            towards_zero.saturating_sub(i64::from(towards_zero as f64 > x))
        };
        (position * self.resolution).to_array().map(floor)
    }

    /// The bucket of a cell in a row.
    #[inline]
    fn bucket(&self, row: u64, x: i64) -> usize {
        row.wrapping_add(x as u64) as usize & self.last_bucket()
    }

    #[inline]
    fn last_bucket(&self) -> usize {
        self.starts.len() - 2
    }

    /// Visits each point that is nearer than the radius once, in an order that depends on nothing
    /// but the order of the points that the grid was built of.
    #[inline]
    pub(super) fn within(&self, centre: DVec3, mut visit: impl FnMut(&T)) {
        if self.points.is_empty() {
            return;
        }
        // A computed distance below r means that no coordinate differs by r, so that these cells,
        // which are of rounded positions, have those of all points in the ball between them.
        let [x0, y0, z0] = self.cell(centre - self.radius);
        let [x1, y1, z1] = self.cell(centre + self.radius);
        for (z, y) in (z0..=z1).flat_map(|z| (y0..=y1).map(move |y| (z, y))) {
            let mut scan = |first: usize, last: usize| {
                let range = self.starts[first] as usize..self.starts[last + 1] as usize;
                for (position, point) in
                    self.positions[range.clone()].iter().zip(&self.points[range])
                {
                    // Rows that share a bucket find each other's points.
                    if position.distance_squared(centre) < self.radius * self.radius
                        && self.cell(*position)[1..] == [y, z]
                    {
                        visit(point);
                    }
                }
            };
            let row = row(y, z);
            let (first, last) = (self.bucket(row, x0), self.bucket(row, x1));
            if x1.abs_diff(x0) > self.last_bucket() as u64 {
                scan(0, self.last_bucket());
            } else if first <= last {
                scan(first, last);
            } else {
                scan(first, self.last_bucket());
                scan(0, last);
            }
        }
    }

    /// The radius of the balls.
    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// All points, in the order of the buckets.
    pub(super) fn points(&self) -> &[T] {
        &self.points
    }

    /// The memory that the grid holds, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.starts.capacity() * size_of::<u32>()
            + self.positions.capacity() * size_of::<DVec3>()
            + self.points.capacity() * size_of::<T>()
    }
}

/// The hash of a row of cells along x. Multipliers are those of Weyl sequences with the golden
/// ratio and its counterpart in two dimensions; the second round mixes high bits into low ones,
/// which are all alike where cells are narrower than the spacing of numbers.
#[inline]
fn row(y: i64, z: i64) -> u64 {
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    const PLASTIC: u64 = 0xc13f_a9a9_02a6_328f;
    let sum = (y as u64).wrapping_mul(GOLDEN).wrapping_add((z as u64).wrapping_mul(PLASTIC));
    (sum ^ sum >> 32).wrapping_mul(GOLDEN) >> 32
}

/// An empty vector with room for `len` elements, `None` if there is not enough memory.
fn reserved<T>(len: usize) -> Option<Vec<T>> {
    let mut elements = Vec::new();
    elements.try_reserve_exact(len).ok()?;
    Some(elements)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::testing::random;

    /// Indices in the order of the visits.
    fn visits(grid: &HashGrid<(DVec3, usize)>, centre: DVec3) -> Vec<usize> {
        let mut found = Vec::new();
        grid.within(centre, |(_, index)| found.push(*index));
        found
    }

    fn numbered(positions: &[DVec3]) -> Vec<(DVec3, usize)> {
        positions.iter().copied().zip(0..).collect()
    }

    /// Compares grids of many sizes with the definition, around all points and `centres`; returns
    /// the number of points found.
    fn compare(positions: &[DVec3], centres: &[DVec3], radius: f64) -> usize {
        let mut count = 0;
        for buckets in [1, 2, 4, 16, 256, 4096] {
            let points = numbered(positions);
            let grid = HashGrid::with_buckets(buckets, points, radius, |p| p.0).expect("small");
            assert_eq!(grid.points().len(), positions.len());
            for &centre in positions.iter().chain(centres) {
                let mut found = visits(&grid, centre);
                found.sort_unstable();
                let near = |i: &usize| positions[*i].distance_squared(centre) < radius * radius;
                let expected: Vec<usize> = (0..positions.len()).filter(near).collect();
                assert_eq!(found, expected, "{buckets} buckets, r = {radius:e}, around {centre}");
                count += found.len();
            }
        }
        count
    }

    fn in_cube(random: &mut impl FnMut() -> f64) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| 2.0 * random() - 1.0))
    }

    #[test]
    fn each_point_of_a_ball_is_found_once() {
        let mut random = random(1);
        for exponent in [-150, -6, -3, 0, 3, 6, 150] {
            let scale = 10f64.powi(exponent);
            for offset in [0.0, 1.0, 1e6, 1e12, 1e15, 1e16, 1e18, 1e30] {
                let offset = offset * scale * in_cube(&mut random);
                let mut points =
                    |size: f64| [(); 60].map(|()| offset + size * scale * in_cube(&mut random));
                let positions = [points(1.0), points(0.01)].concat();
                let centres = points(1.0);
                for radius in [0.01, 0.3, 5.0] {
                    assert!(compare(&positions, &centres, radius * scale) >= 6 * positions.len());
                }
            }
        }
    }

    /// Points on the corners of cells of 1 × 2 × 2 and as close to them as numbers allow, and balls
    /// with points on their border.
    #[test]
    fn borders_of_cells_belong_to_one_of_them() {
        for offset in [0.0, 3.0, -1e6, 9e15] {
            let mut positions = Vec::new();
            for i in 0..5u32.pow(3) {
                let corner = DVec3::from_array([i % 5, i / 5 % 5, i / 25].map(f64::from)) - 2.0;
                let next = [f64::next_down, |x| x, f64::next_up][i as usize % 3];
                positions.push(DVec3::from_array((corner + offset).to_array().map(next)));
            }
            for radius in [1.0, 1f64.next_up(), 2f64.sqrt().next_up()] {
                compare(&positions, &[], radius);
            }
        }
    }

    #[test]
    fn extreme_coordinates_find_themselves_or_nothing() {
        let extremes = [0.0, -0.0, 5e-324, 1e-300, 2f64.powi(63), 1e300, f64::MAX];
        let mut coordinates = extremes.map(|x| [x, -x]).concat();
        coordinates.extend([f64::INFINITY, f64::NEG_INFINITY, f64::NAN]);
        let positions: Vec<DVec3> = (0..coordinates.len().pow(2))
            .map(|i| (coordinates[i % 17], coordinates[i / 17]))
            .flat_map(|(a, b)| [DVec3::new(a, b, 1.0), DVec3::new(b, 1.0, a)])
            .collect();
        for radius in [1.5e-154, 1.0, 1e10, 1.3e154] {
            assert!(compare(&positions, &[], radius) > positions.len());
        }
    }

    #[test]
    fn order_of_visits_is_that_of_the_points() {
        let mut random = random(2);
        let positions: Vec<DVec3> = (0..1000).map(|_| in_cube(&mut random)).collect();
        // All in one cell.
        let inside: Vec<DVec3> = positions.iter().map(|p| (p + 2.0) / 4.0).collect();
        let grid = HashGrid::build(numbered(&inside), 2.0, |p| p.0).expect("small");
        assert_eq!(visits(&grid, DVec3::splat(0.5)), Vec::from_iter(0..1000));

        let build = || HashGrid::build(numbered(&positions), 0.3, |p| p.0).expect("small");
        let (first, second) = (build(), build());
        assert!(positions.iter().all(|p| visits(&first, *p) == visits(&second, *p)));
    }

    #[test]
    fn unusable_radii_find_nothing() {
        let positions = [DVec3::ZERO, DVec3::ONE];
        for radius in [0.0, -1.0, 5e-324, 1e-300, 1e-155, 1e155, 1e300, f64::INFINITY, f64::NAN] {
            let grid = HashGrid::build(numbered(&positions), radius, |p| p.0).expect("small");
            assert!(grid.points().is_empty(), "{radius}");
            for centre in [DVec3::ZERO, DVec3::MAX, DVec3::INFINITY, DVec3::NAN] {
                assert!(visits(&grid, centre).is_empty(), "{radius} {centre}");
            }
        }
        let grid = HashGrid::build(Vec::new(), 1.0, |p: &(DVec3, usize)| p.0).expect("small");
        assert!(visits(&grid, DVec3::ZERO).is_empty());
    }

    #[test]
    fn too_many_points_are_refused() {
        // Points without size take no memory, however many.
        let points = Vec::from([(); 1 << 32]);
        assert!(HashGrid::build(points, 1.0, |()| DVec3::ZERO).is_none());
        assert!(reserved::<u32>(usize::MAX / 4).is_none());
    }
}

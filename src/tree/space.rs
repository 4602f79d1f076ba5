//! The space that boxes and blocks live in.

use glam::DVec3;

/// `(p - center) / extent`. A cube around the scene becomes a part of [-1, 1]³, at least a sixth as
/// wide, such that positions that are f32 numbers stay so, as those of most files are: the extent
/// is a power of two, and along each axis the centre is 0, or an f32 number so far away that its
/// difference from one within the cube is an f32 number, too (Sterbenz 1974); or no f32 number, if
/// those are too far apart for the cube.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space {
    pub center: DVec3,
    extent: f64,
    pub inverse_extent: f64,
}

impl Space {
    /// The space for a cube, given by its centre and half its side.
    pub fn new(center: DVec3, extent: f64) -> Self {
        let origin = center.map(|x| {
            let near = f64::from(x as f32);
            match () {
                () if x.abs() <= 2.0 * extent => 0.0,
                () if (x - near).abs() <= 0.25 * extent => near,
                // No two f32 numbers are within the cube.
                () => x,
            }
        });
        let size = (center - origin).abs().max_element() + extent;
        let extent = libm::exp2(libm::log2(size).ceil());
        Self { center: origin, extent, inverse_extent: 1.0 / extent }
    }

    /// A point of the world in this space.
    #[inline(always)]
    pub fn place(&self, p: DVec3) -> DVec3 {
        (p - self.center) * self.inverse_extent
    }

    /// A point of this space in the world, its coordinates in the given order.
    #[inline(always)]
    pub fn world(&self, p: DVec3, [i, j, k]: [usize; 3]) -> DVec3 {
        let center = self.center.to_array();
        p * self.extent + DVec3::new(center[i], center[j], center[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_f32_stay_such_and_the_scene_is_within_the_cube() {
        for (center, extent) in [
            ([0.1, -0.2, 0.3], 0.7),
            ([3.0, 0.0, -8.0], 1.7),
            ([1e6, -1e5, 1.0], 3.3),
            ([1e-9, 1e-9, 0.0], 1e-12),
            ([1e30, 0.0, 0.0], 1e29),
        ] {
            let center = DVec3::from(center);
            let space = Space::new(center, extent);
            for i in 0..1000 {
                let part = |n: u32| f64::from((i * n) % 1001) / 500.0 - 1.0;
                let p = (center + extent * DVec3::new(part(7), part(19), part(101)))
                    .as_vec3()
                    .as_dvec3();
                let placed = space.place(p);
                assert!(placed.abs().max_element() <= 1.0 + 1e-6, "{placed}");
                assert_eq!(placed.as_vec3().as_dvec3(), placed, "{p} in {space:?}");
                assert_eq!(space.world(placed, [0, 1, 2]), p);
            }
        }
    }
}

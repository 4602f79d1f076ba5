//! Views of a scene: scenes that answer as another one does, but for some of its answers.

/// The answers of a view, in its `impl Scene`, that are those of its field `scene`: rays, media and
/// lights. Left to the view are the BSDFs, and whatever follows from them: needs, flat surfaces, the
/// fingerprint.
macro_rules! answers_of_scene {
    () => {
        fn intersect(
            &self,
            from: &$crate::geometry::SurfacePoint,
            direction: glam::DVec3,
        ) -> Option<$crate::geometry::SurfacePoint> {
            self.scene.intersect(from, direction)
        }
        fn visible(
            &self,
            a: &$crate::geometry::SurfacePoint,
            b: &$crate::geometry::SurfacePoint,
        ) -> bool {
            self.scene.visible(a, b)
        }
        fn intersect_many<'b>(
            &self,
            rays: impl Iterator<Item = (&'b $crate::geometry::SurfacePoint, glam::DVec3)>,
            found: impl FnMut(usize, Option<$crate::geometry::SurfacePoint>),
        ) {
            self.scene.intersect_many(rays, found);
        }
        fn visible_many<'b>(
            &self,
            segments: impl Iterator<
                Item = (&'b $crate::geometry::SurfacePoint, &'b $crate::geometry::SurfacePoint),
            >,
            answer: impl FnMut(usize, bool),
        ) {
            self.scene.visible_many(segments, answer);
        }
        fn transmittance(
            &self,
            a: &$crate::geometry::SurfacePoint,
            b: &$crate::geometry::SurfacePoint,
        ) -> $crate::math::Rgb {
            self.scene.transmittance(a, b)
        }
        fn medium_towards(
            &self,
            x: &$crate::geometry::SurfacePoint,
            direction: glam::DVec3,
        ) -> u16 {
            self.scene.medium_towards(x, direction)
        }
        fn medium_at(&self, x: &$crate::geometry::SurfacePoint) -> u16 {
            self.scene.medium_at(x)
        }
        fn light_at(
            &self,
            x: &$crate::geometry::SurfacePoint,
        ) -> Option<$crate::endpoint::LightId> {
            self.scene.light_at(x)
        }
        fn environment(&self) -> Option<$crate::endpoint::LightId> {
            self.scene.environment()
        }
        fn light(&self, id: $crate::endpoint::LightId) -> &S::Light {
            self.scene.light(id)
        }
        fn pick_light(&self, u: f64) -> Option<($crate::endpoint::LightId, f64)> {
            self.scene.pick_light(u)
        }
        fn pick_pmf(&self, id: $crate::endpoint::LightId) -> f64 {
            self.scene.pick_pmf(id)
        }
        fn pick_light_for(
            &self,
            receiver: &$crate::geometry::SurfacePoint,
            u: f64,
        ) -> Option<($crate::endpoint::LightId, f64)> {
            self.scene.pick_light_for(receiver, u)
        }
        fn pick_pmf_for(
            &self,
            receiver: &$crate::geometry::SurfacePoint,
            id: $crate::endpoint::LightId,
        ) -> f64 {
            self.scene.pick_pmf_for(receiver, id)
        }
        fn light_tree(&self) -> Option<&$crate::light_tree::LightTree> {
            self.scene.light_tree()
        }
        fn light_names(&self, kind: $crate::endpoint::LightKind) -> Option<Vec<&str>> {
            self.scene.light_names(kind)
        }
    };
}

pub(crate) use answers_of_scene;

//! BSDFs of a user's own as materials.

use crate::bsdf::Bsdf;
use std::fmt;
use std::sync::Arc;

/// A shared BSDF of a user's own. Equal to its clones alone.
#[derive(Clone)]
pub struct CustomBsdf(Arc<dyn Bsdf>);

impl CustomBsdf {
    /// Shares a BSDF.
    #[must_use]
    pub fn new(bsdf: impl Bsdf + 'static) -> Self {
        Self(Arc::new(bsdf))
    }
}

impl std::ops::Deref for CustomBsdf {
    type Target = dyn Bsdf;

    #[inline]
    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl PartialEq for CustomBsdf {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for CustomBsdf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("CustomBsdf").field(&self.lobes()).finish()
    }
}

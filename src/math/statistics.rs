//! Tests of statistical hypotheses, for checking samplers, BSDFs and integrators.

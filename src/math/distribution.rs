//! Discrete and two-dimensional piecewise-constant distributions.

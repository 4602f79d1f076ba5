//! The distributions behind tests and confidence intervals, against those of another library.
#![allow(missing_docs, reason = "a test program")]

use approx::assert_relative_eq;
use pathspace::math::statistics::{regularized_gamma_q, two_sided_p_value};
use pathspace::math::student::{student_t_p_value, student_t_quantile};
use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::function::{erf::erfc, gamma};

#[test]
fn incomplete_gamma_function() {
    for a in [0.1, 0.5, 1.0, 2.5, 10.0, 100.0, 1000.0] {
        for factor in [0.01, 0.5, 0.9, 1.0, 1.1, 2.0] {
            let x = a * factor;
            assert_relative_eq!(
                regularized_gamma_q(a, x),
                gamma::gamma_ur(a, x),
                max_relative = 1e-9,
                epsilon = 1e-13
            );
        }
    }
    assert!(regularized_gamma_q(-1.0, 1.0).is_nan());
    assert_eq!(regularized_gamma_q(1.0, f64::INFINITY), 0.0);
}

#[test]
fn normal_distribution() {
    for z in [0.0, 0.1, 1.0, -3.0, 8.0] {
        let expected = erfc(f64::abs(z) / 2f64.sqrt());
        assert_relative_eq!(two_sided_p_value(z), expected, max_relative = 1e-9);
    }
}

#[test]
fn student_distribution() {
    for freedom in [1.0, 2.5, 7.0, 31.0, 1000.0] {
        let student = StudentsT::new(0.0, 1.0, freedom).unwrap();
        for t in [0.01, 0.5, 1.0, 2.0, 5.0, 20.0] {
            let p = student_t_p_value(t, freedom);
            assert_relative_eq!(p, 2.0 * student.sf(t), max_relative = 1e-8);
            assert_relative_eq!(student_t_quantile(p, freedom), t, max_relative = 1e-8);
        }
    }
}

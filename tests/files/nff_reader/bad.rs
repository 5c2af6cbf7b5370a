//! Bad files, and messages about them.

use phalanx::formats::{MAX_DIAGNOSTICS, read_nff};

#[test]
fn twenty_errors_are_reported_in_file_order_then_reading_stops() {
    let text = format!("{}{}", super::HEAD, "s a 0 0 1\n".repeat(30));
    let errors = read_nff(&text).unwrap_err();
    let positions: Vec<_> = errors.iter().map(|e| (e.line, e.column)).collect();
    let expected: Vec<_> = (0..MAX_DIAGNOSTICS).map(|k| (10 + k, 3)).collect();
    assert_eq!(positions, expected);
}

#[test]
fn a_count_alone_allocates_nothing() {
    // 10^15 corners would be more than there is memory; the process would end here.
    for count in ["1000000000000000", "18446744073709551615", "400000000"] {
        let errors = read_nff(&format!("{}p {count}\n0 0 0\n1 0 0\n", super::HEAD)).unwrap_err();
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert!(
            errors[0].message.contains("more than the rest"),
            "{errors:?}"
        );
    }
}

#[test]
fn polygons_of_too_many_corners_are_refused_at_their_count() {
    let polygon = |count: usize| format!("p {count}\n{}", "0 0 0\n".repeat(count));
    let errors = read_nff(&polygon(65_537)).map(|_| "a scene");
    let errors = errors.expect_err("too many corners");
    assert_eq!((errors.len(), errors[0].line, errors[0].column), (1, 1, 3));
    assert!(errors[0].message.contains("at most 65536"), "{errors:?}");
}

#[test]
fn colours_beyond_single_precision_are_refused_where_they_stand() {
    let text = "s 0 0 0 1\nf 1e30 1 1 1e30 0 1 0 1\ns 0 0 0 1\n";
    let errors = read_nff(text).map(|_| "a scene");
    let errors = errors.expect_err("too bright");
    assert_eq!((errors.len(), errors[0].line), (1, 2), "{errors:?}");
    assert!(errors[0].message.contains("colour"), "{errors:?}");
}

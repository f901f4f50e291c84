//! Angles beyond all turns: they are what is left of them when whole turns are taken away, exactly (row 33).

use crate::ways::{assert_in_all_ways, on_deep_stacks, picture};

/// What is left of a whole number of degrees when turns are taken away, by whole numbers alone: the number is `m` times 2 to the `e`.
fn left_of(degrees: f64) -> u64 {
    let (bits, hidden) = (degrees.to_bits(), 1_u64 << 52);
    let exponent = (bits >> 52 & 0x7ff) as i64 - 1075;
    let mut left = (bits & (hidden - 1) | hidden) % 360;
    assert!(exponent >= 0, "only what has no fraction");
    for _ in 0..exponent {
        left = left * 2 % 360;
    }
    left
}

/// Angles of all sizes, none of them with a fraction.
fn angles() -> Vec<f64> {
    let mut angles = vec![1e300, 1e22, 1e16, 1.7e308, f64::MAX, 9_007_199_254_740_993.0 * 90.0];
    angles.extend((53..1024).step_by(23).map(|it| libm::exp2(f64::from(it)) * 1.234_567_890_123));
    angles
}

#[test]
fn sines_of_huge_angles_are_those_of_what_is_left_of_them() {
    // By hand: 10^3 is 280, 10^4 is 280 again, for 10 times 280 is 2,800, which is 280 and seven turns. So 10^22, a float, is 280 degrees.
    assert_eq!(left_of(1e22), 280);
    let mut cases = Vec::new();
    for angle in angles() {
        let left = left_of(angle);
        let radians = left as f64 * std::f64::consts::PI / 180.0;
        for (name, value) in [("sin", libm::sin(radians)), ("cos", libm::cos(radians))] {
            for sign in ["", "-"] {
                let value = if sign == "-" && name == "sin" { -value } else { value };
                let rule = format!("T(n) if abs(n - {value:e}) < 4e-15 -> box;");
                cases.push((format!("csg S {{ start T({name}({sign}{angle:e})); {rule} }}"), "fine"));
            }
        }
    }
    // Something else is told.
    cases.push(("csg S { start T(sin(1e22)); T(n) if abs(n - sin(281)) < 4e-15 -> box; }".to_owned(), "E1001"));
    assert_in_all_ways(&cases);
}

#[test]
fn turns_by_huge_angles_are_those_by_what_is_left_of_them() {
    let different: Vec<f64> = on_deep_stacks(|| {
        let differs = |angle: &f64| {
            ["rotx(@)", "roty(@)", "rotz(-@)", "rotate((1, 2, 3), @)"].iter().any(|turn| {
                let turned = |by: String| {
                    picture(&format!("csg S {{ start {} (box | cone(2, 1)); }}", turn.replace('@', &by)), false)
                };
                let turned = [turned(format!("{angle:e}")), turned(left_of(*angle).to_string())];
                turned[0].is_err() || turned[0] != turned[1]
            })
        };
        angles().into_iter().filter(differs).collect()
    });
    assert!(different.is_empty(), "{different:?}");
}

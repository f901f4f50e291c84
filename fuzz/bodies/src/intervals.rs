//! Boolean expressions over lists of intervals: whatever the ends are, a point is in the result if and only if the operands say so.

use treegen_runtime::geometry::{End, Interval, Intervals};

use crate::bytes::Bytes;

/// A surface: the operand it is of, and its own place.
type Surface = (usize, f64);

/// A list and what it should be: the leaves that it is made of, and for each sample whether it is inside.
struct Operand {
    list: Intervals<Surface>,
    inside: Vec<bool>,
}

/// Operations one after another on a stack of lists.
///
/// # Panics
/// If a list is not sorted, touches itself or holds a piece without length; if, without tolerance, a point is in a result that is not in
/// the Boolean of its operands or the other way round, or an end is not where its surface is.
pub fn intervals(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let tolerance = [0.0, 0.0, 1e-9, 0.5, 3.0][bytes.below(5)];
    let count = 1 + bytes.below(6);
    let leaves: Vec<Vec<(f64, f64)>> = (0..count).map(|_| pieces(&mut bytes)).collect();
    let samples = samples(&leaves);
    let mut stack: Vec<Operand> = leaves.iter().enumerate().map(|(number, it)| leaf(number, it, &samples)).collect();
    let known = stack.iter().map(|it| Operand { list: it.list.clone(), inside: it.inside.clone() }).collect::<Vec<_>>();
    for _ in 0..64 {
        if bytes.is_empty() {
            break;
        }
        let kind = bytes.below(5);
        let result = match (kind, stack.len()) {
            (3, 2..) => {
                let many = 2 + bytes.below(stack.len() - 1);
                let operands = stack.split_off(stack.len() - many.min(stack.len()));
                union_of(&operands, tolerance, &samples)
            }
            (4, _) | (_, ..2) => {
                let again = &known[bytes.below(known.len())];
                Operand { list: again.list.clone(), inside: again.inside.clone() }
            }
            (kind, _) => {
                let (Some(b), Some(a)) = (stack.pop(), stack.pop()) else { return };
                combined(kind, &a, &b, tolerance)
            }
        };
        judge(&result, &samples, tolerance);
        stack.push(result);
    }
}

/// Pieces in any order that may overlap; each is sorted in itself.
fn pieces(bytes: &mut Bytes<'_>) -> Vec<(f64, f64)> {
    let mut pieces: Vec<(f64, f64)> = (0..bytes.below(12))
        .map(|_| {
            let (near, far) = match bytes.below(4) {
                0 => (bytes.float(), bytes.float()),
                1 => (f64::NEG_INFINITY, f64::from(bytes.next() as i8)),
                2 => (f64::from(bytes.next() as i8), f64::INFINITY),
                _ => {
                    let near = f64::from(bytes.next() as i8);
                    (near, near + f64::from(bytes.next() % 8))
                }
            };
            if far < near { (far, near) } else { (near, far) }
        })
        .filter(|it| !it.0.is_nan())
        .collect();
    pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
    pieces
}

fn leaf(number: usize, pieces: &[(f64, f64)], samples: &[f64]) -> Operand {
    let end = |t: f64| End { t, surface: (number, t), flipped: false };
    let list = Intervals::of_sorted(pieces.iter().map(|it| Interval { near: end(it.0), far: end(it.1) }));
    let inside = samples.iter().map(|at| pieces.iter().any(|it| it.0 < *at && *at < it.1)).collect();
    let operand = Operand { list, inside };
    judge(&operand, samples, 0.0);
    operand
}

/// A point between any two neighbouring ends, and one before and behind all.
fn samples(leaves: &[Vec<(f64, f64)>]) -> Vec<f64> {
    let mut ends: Vec<f64> = leaves.iter().flatten().flat_map(|it| [it.0, it.1]).filter(|it| !it.is_nan()).collect();
    ends.extend([f64::NEG_INFINITY, f64::INFINITY, 0.0]);
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let between = |a: f64, b: f64| match (a.is_finite(), b.is_finite()) {
        (true, true) => a / 2.0 + b / 2.0,
        (true, false) => a + a.abs() + 1.0,
        (false, true) => b - b.abs() - 1.0,
        (false, false) => 0.0,
    };
    let samples = ends.windows(2).map(|it| (it[0], between(it[0], it[1]), it[1]));
    samples.filter(|it| it.0 < it.1 && it.1 < it.2).map(|it| it.1).collect()
}

fn combined(kind: usize, a: &Operand, b: &Operand, tolerance: f64) -> Operand {
    let (list, rule): (_, fn(bool, bool) -> bool) = match kind {
        0 => (a.list.union(&b.list, tolerance), |a, b| a || b),
        1 => (a.list.intersection(&b.list, tolerance), |a, b| a && b),
        _ => (a.list.difference(&b.list, tolerance), |a, b| a && !b),
    };
    let inside = a.inside.iter().zip(&b.inside).map(|(a, b)| rule(*a, *b)).collect();
    Operand { list, inside }
}

fn union_of(operands: &[Operand], tolerance: f64, samples: &[f64]) -> Operand {
    let lists: Vec<_> = operands.iter().map(|it| it.list.clone()).collect();
    let inside = (0..samples.len()).map(|at| operands.iter().any(|it| it.inside[at])).collect();
    Operand { list: Intervals::union_of(&lists, tolerance), inside }
}

fn judge(operand: &Operand, samples: &[f64], tolerance: f64) {
    let list = operand.list.as_slice();
    assert!(list.iter().all(|it| it.near.t < it.far.t), "{list:?}");
    assert!(list.windows(2).all(|it| it[0].far.t < it[1].near.t), "{list:?}");
    if tolerance > 0.0 {
        return;
    }
    for (at, inside) in samples.iter().zip(&operand.inside) {
        let found = list.iter().any(|it| it.near.t < *at && *at < it.far.t);
        assert!(found == *inside, "{at} should be {inside} in {list:?}");
    }
    for end in list.iter().flat_map(|it| [it.near, it.far]) {
        assert!(end.t == end.surface.1, "{end:?} is not where its surface is");
    }
}

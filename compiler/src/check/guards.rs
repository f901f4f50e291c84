//! Guards that never hold, whatever the values are: `false`, `1 > 2`, `n > 3 and n < 2`.

use treegen_grammar::ast::{BinaryOp, UnaryOp};

use crate::program::{Expr, ExprKind, SlotId};

/// Whether a condition is false whatever is in it. It may be false always without this seeing it.
pub(super) fn never(condition: &Expr) -> bool {
    match &condition.kind {
        ExprKind::Bool(it) => !it,
        ExprKind::Binary { first, rest } => match &rest[..] {
            [(BinaryOp::Or, ..), ..] => operands(first, rest).all(never),
            [(BinaryOp::And, ..), ..] => operands(first, rest).any(never) || contradicts(first, rest),
            [(op, _, second)] => match (number(first), number(second)) {
                (Some(a), Some(b)) => compared(*op, a, b) == Some(false),
                _ => false,
            },
            _ => false,
        },
        _ => false,
    }
}

type Rest = [(BinaryOp, treegen_grammar::Span, Expr)];

fn operands<'a>(first: &'a Expr, rest: &'a Rest) -> impl Iterator<Item = &'a Expr> {
    std::iter::once(first).chain(rest.iter().map(|it| &it.2))
}

/// A number that is written out.
fn number(expr: &Expr) -> Option<f64> {
    match &expr.kind {
        ExprKind::Number(it) => Some(*it),
        ExprKind::Unary { ops, operand } => match (&ops[..], number(operand)) {
            ([UnaryOp::Negate], Some(it)) => Some(-it),
            _ => None,
        },
        _ => None,
    }
}

fn compared(op: BinaryOp, a: f64, b: f64) -> Option<bool> {
    Some(match op {
        BinaryOp::Equal => a == b,
        BinaryOp::NotEqual => a != b,
        BinaryOp::Less => a < b,
        BinaryOp::LessEqual => a <= b,
        BinaryOp::Greater => a > b,
        BinaryOp::GreaterEqual => a >= b,
        _ => return None,
    })
}

/// Whether comparisons of one value with numbers, which all have to hold, leave it none.
fn contradicts(first: &Expr, rest: &Rest) -> bool {
    let mut known: Vec<(SlotId, BinaryOp, f64)> = Vec::new();
    for operand in operands(first, rest) {
        let Some((slot, op, bound)) = comparison(operand) else { continue };
        let clashes = |it: &&(SlotId, BinaryOp, f64)| it.0 == slot && excludes((it.1, it.2), (op, bound));
        if known.iter().any(|it| clashes(&it)) {
            return true;
        }
        known.push((slot, op, bound));
    }
    false
}

/// `n < 3` or `3 > n` as the value, the sign and the number.
fn comparison(expr: &Expr) -> Option<(SlotId, BinaryOp, f64)> {
    let ExprKind::Binary { first, rest } = &expr.kind else { return None };
    let [(op, _, second)] = &rest[..] else { return None };
    match (&first.kind, &second.kind) {
        (ExprKind::Slot(slot), _) => Some((*slot, *op, number(second)?)),
        (_, ExprKind::Slot(slot)) => Some((*slot, turned(*op), number(first)?)),
        _ => None,
    }
}

fn turned(op: BinaryOp) -> BinaryOp {
    match op {
        BinaryOp::Less => BinaryOp::Greater,
        BinaryOp::LessEqual => BinaryOp::GreaterEqual,
        BinaryOp::Greater => BinaryOp::Less,
        BinaryOp::GreaterEqual => BinaryOp::LessEqual,
        other => other,
    }
}

/// Whether no number fulfils both.
fn excludes(one: (BinaryOp, f64), other: (BinaryOp, f64)) -> bool {
    use BinaryOp::{Equal, Greater, GreaterEqual, Less, LessEqual};
    match (one, other) {
        ((Equal, a), (op, b)) | ((op, b), (Equal, a)) => compared(op, a, b) == Some(false),
        ((Less, a), (Greater | GreaterEqual, b)) | ((Greater | GreaterEqual, b), (Less, a)) => a <= b,
        ((LessEqual, a), (Greater, b)) | ((Greater, b), (LessEqual, a)) => a <= b,
        ((LessEqual, a), (GreaterEqual, b)) | ((GreaterEqual, b), (LessEqual, a)) => a < b,
        _ => false,
    }
}

//! Loose bounds of states: quick to find, valid, and only used to prune the search for exact ones (`support`).
//!
//! The bounds of a state follow from those of the states in it, so they are found from the innermost outwards. States
//! that contain themselves get theirs all at once, as a fixed point: bounds that hold whatever is made from them hold
//! for ever. If the cycle shrinks there are such bounds; if none are found it may never end.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DVec3};

use super::piece::{Piece, Shape};
use super::store::{Store, led_by};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::Origin;
use crate::geometry::{Aabb, Primitive};
use crate::trace::Entry;

/// Bounds of something: all of it lies in the box and in the ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Loose {
    /// A box, perhaps infinite.
    pub(super) bounds: Aabb,
    /// A box around those of its parts that are finite.
    pub(super) finite: Aabb,
    /// A ball; infinite if the box is.
    center: DVec3,
    radius: f64,
}

impl Loose {
    /// Of nothing.
    pub(super) const EMPTY: Self =
        Self { bounds: Aabb::EMPTY, finite: Aabb::EMPTY, center: DVec3::ZERO, radius: f64::NEG_INFINITY };

    /// Of some pieces, by what is known of the states in them.
    pub(super) fn of_pieces(pieces: &[Piece], known: &impl Fn(u32) -> Self) -> Self {
        let parts: Vec<Self> = pieces.iter().map(|it| Self::of_piece(it, known)).collect();
        Self::union(&parts)
    }

    /// Of one piece, in the frame outside it.
    pub(super) fn of_piece(piece: &Piece, known: &impl Fn(u32) -> Self) -> Self {
        let map = &piece.outer_from_inner;
        match &piece.shape {
            Shape::Leaf(primitive, _) => Self::of_primitive(primitive, map),
            Shape::Instance(state, _) => known(*state).mapped(map),
            Shape::Intersect(operands) => {
                let operands = operands.iter().map(|it| Self::of_pieces(it, known));
                operands.reduce(Self::intersection).unwrap_or(Self::EMPTY).mapped(map)
            }
            Shape::Difference(operands) => {
                operands.first().map_or(Self::EMPTY, |it| Self::of_pieces(it, known)).mapped(map)
            }
        }
    }

    fn of_primitive(primitive: &Primitive, map: &DAffine3) -> Self {
        let bounds = primitive_bounds(primitive, map);
        let loose = Self::of_box(bounds);
        let own = Self::of_box(primitive.bounds()).mapped(map);
        if own.radius < loose.radius { Self { center: own.center, radius: own.radius, ..loose } } else { loose }
    }

    fn of_box(bounds: Aabb) -> Self {
        if bounds.is_empty() {
            return Self::EMPTY;
        }
        if !bounds.is_finite() {
            return Self { bounds, finite: Aabb::EMPTY, center: DVec3::ZERO, radius: f64::INFINITY };
        }
        let (center, half) = (bounds.min * 0.5 + bounds.max * 0.5, bounds.max * 0.5 - bounds.min * 0.5);
        Self { bounds, finite: bounds, center, radius: half.length() }
    }

    /// The same in the frame outside.
    pub(super) fn mapped(self, map: &DAffine3) -> Self {
        if self.bounds.is_empty() {
            return Self::EMPTY;
        }
        let center = map.transform_point3(self.center);
        let radius = self.radius * stretch(&map.matrix3);
        let mapped = |bounds: &Aabb| bounds.mapped(map).intersection(&ball_box(center, radius));
        let finite = if self.bounds.is_finite() { mapped(&self.finite) } else { self.finite.mapped(map) };
        Self { bounds: mapped(&self.bounds), finite, center, radius }
    }

    fn union(parts: &[Self]) -> Self {
        let bounds = parts.iter().fold(Aabb::EMPTY, |all, it| all.union(&it.bounds));
        let finite = parts.iter().fold(Aabb::EMPTY, |all, it| all.union(&it.finite));
        let whole = Self::of_box(bounds);
        let reach = |it: &Self| (it.center - whole.center).length() + it.radius;
        let radius = parts.iter().map(reach).fold(f64::NEG_INFINITY, f64::max);
        let radius = if radius < whole.radius { radius } else { whole.radius };
        Self { finite, radius, ..whole }
    }

    fn intersection(self, other: Self) -> Self {
        let bounds = self.bounds.intersection(&other.bounds);
        let whole = Self::of_box(bounds);
        let smaller = if other.radius < self.radius { other } else { self };
        if smaller.radius < whole.radius && !bounds.is_empty() {
            Self { center: smaller.center, radius: smaller.radius, ..whole }
        } else {
            whole
        }
    }

    /// The same ball, with the box around it.
    fn around_ball(&self) -> Self {
        let bounds = ball_box(self.center, self.radius);
        if self.bounds.is_empty() || !bounds.is_finite() { *self } else { Self { bounds, finite: bounds, ..*self } }
    }

    /// At least the greatest `direction · p`.
    pub(super) fn support(&self, direction: DVec3) -> f64 {
        if self.bounds.is_empty() {
            return f64::NEG_INFINITY;
        }
        let mut of_box = 0.0;
        for axis in 0..3 {
            let part = direction[axis];
            if part != 0.0 {
                of_box += part * if part > 0.0 { self.bounds.max[axis] } else { self.bounds.min[axis] };
            }
        }
        let of_ball = self.center.dot(direction) + self.radius * direction.length();
        // Not `min`: of an infinite ball the sum may be no number.
        if of_ball < of_box { of_ball } else { of_box }
    }

    fn contains(&self, other: &Self) -> bool {
        let inside = |a: &Aabb, b: &Aabb| b.is_empty() || (a.min.cmple(b.min).all() && a.max.cmpge(b.max).all());
        let ball = other.bounds.is_empty()
            || self.radius == f64::INFINITY
            || (other.center - self.center).length() + other.radius <= self.radius;
        ball && inside(&self.bounds, &other.bounds) && inside(&self.finite, &other.finite)
    }

    /// Larger by a factor.
    fn inflated(&self, factor: f64) -> Self {
        let grown = |bounds: &Aabb| {
            let extra = (bounds.max - bounds.min) * (0.5 * (factor - 1.0));
            if bounds.is_empty() { *bounds } else { Aabb { min: bounds.min - extra, max: bounds.max + extra } }
        };
        Self {
            bounds: grown(&self.bounds),
            finite: grown(&self.finite),
            center: self.center,
            radius: self.radius * factor,
        }
    }
}

/// The smallest box around a primitive in the frame outside.
pub(super) fn primitive_bounds(primitive: &Primitive, map: &DAffine3) -> Aabb {
    let rows = map.matrix3.transpose();
    let (mut min, mut max) = (map.translation, map.translation);
    for (axis, row) in [rows.x_axis, rows.y_axis, rows.z_axis].into_iter().enumerate() {
        max[axis] += primitive.support(row);
        min[axis] -= primitive.support(-row);
    }
    box_between(min, max)
}

/// The box of what reaches from `min` to `max`, which rounding may have crossed where it is flat.
pub(super) fn box_between(min: DVec3, max: DVec3) -> Aabb {
    if max.min_element() == f64::NEG_INFINITY || min.max_element() == f64::INFINITY {
        return Aabb::EMPTY;
    }
    Aabb { min: min.min(max), max: max.max(min) }
}

fn ball_box(center: DVec3, radius: f64) -> Aabb {
    if radius < f64::INFINITY { Aabb { min: center - radius, max: center + radius } } else { Aabb::ALL }
}

/// At least the most that a matrix stretches a vector: the root of the greatest row sum of MᵀM, which is exact for
/// rotations with uniform scaling. (No eigenvalue of a matrix is above its greatest row sum.)
pub(super) fn stretch(matrix: &DMat3) -> f64 {
    let square = matrix.transpose() * *matrix;
    let rows = [square.x_axis, square.y_axis, square.z_axis].map(|it| it.abs().element_sum());
    rows[0].max(rows[1]).max(rows[2]).sqrt()
}

impl Store<'_> {
    /// The loose bounds of a state.
    ///
    /// # Errors
    /// What fails in expanding what is below it, the limit of depth, or a cycle that does not shrink.
    pub(super) fn loose(&self, state: u32) -> Result<Loose, Fault> {
        if let Some(loose) = self.known(state).loose.get() {
            return Ok(*loose);
        }
        Search { store: self, path: Vec::new(), open: Vec::new(), numbers: HashMap::new() }.run(state)?;
        Ok(self.known_loose(state))
    }

    /// Loose bounds that have been found before.
    pub(super) fn known_loose(&self, state: u32) -> Loose {
        self.known(state).loose.get().copied().unwrap_or(Loose::EMPTY)
    }
}

/// A depth-first search for the states below one and their cycles (Tarjan 1972), on a stack of its own: derivations
/// go deep.
struct Search<'a, 's> {
    store: &'a Store<'s>,
    path: Vec<Visit>,
    /// States whose cycles are not complete yet.
    open: Vec<u32>,
    /// In which order the open states were met.
    numbers: HashMap<u32, usize>,
}

/// A state on the path of a [`Search`].
struct Visit {
    state: u32,
    called: Origin,
    /// The states in it that are still to be looked at.
    inside: Vec<(u32, Origin)>,
    number: usize,
    /// The first open state that is reached from it.
    first: usize,
}

impl Search<'_, '_> {
    fn run(mut self, root: u32) -> Result<(), Fault> {
        self.visit(root, Origin::NONE)?;
        while let Some(visit) = self.path.last_mut() {
            let Some((state, called)) = visit.inside.pop() else {
                self.leave()?;
                continue;
            };
            if self.store.known(state).loose.get().is_some() {
                continue;
            }
            match self.numbers.get(&state) {
                Some(number) => visit.first = visit.first.min(*number),
                None => self.visit(state, called)?,
            }
        }
        Ok(())
    }

    fn visit(&mut self, state: u32, called: Origin) -> Result<(), Fault> {
        let number = self.numbers.len();
        self.numbers.insert(state, number);
        self.open.push(state);
        self.path.push(Visit { state, called, inside: Vec::new(), number, first: number });
        let most = self.store.limits.depth;
        if self.path.len() > most as usize + 1 {
            return Err(
                self.led_here(Fault::new(FaultKind::Limit { limit: Limit::Depth, most: u64::from(most) }, called))
            );
        }
        // Loose bounds need every state below. States are never dropped, so their number has a limit.
        let states = u64::from(self.store.limits.items);
        if u64::from(state) >= states {
            return Err(self.led_here(Fault::new(FaultKind::Limit { limit: Limit::Nodes, most: states }, called)));
        }
        let pieces = self.store.pieces(state).map_err(|it| self.led_here(it))?;
        if let Some(visit) = self.path.last_mut() {
            Piece::instances(pieces, &mut |state, called| visit.inside.push((state, called)));
            visit.inside.reverse();
        }
        Ok(())
    }

    fn led_here(&self, fault: Fault) -> Fault {
        led_by(fault, self.path.iter().map(|it| self.store.step(it.state, it.called)))
    }

    /// All in a state has been looked at.
    fn leave(&mut self) -> Result<(), Fault> {
        let Some(visit) = self.path.pop() else {
            return Ok(());
        };
        if visit.first < visit.number {
            if let Some(above) = self.path.last_mut() {
                above.first = above.first.min(visit.first);
            }
            return Ok(());
        }
        let start = self.open.iter().rposition(|it| *it == visit.state).unwrap_or(0);
        let cycle = self.open.split_off(start);
        // Nothing below is open any more, so the numbers that are left are those of the states that are.
        for state in &cycle {
            self.numbers.remove(state);
        }
        let found = match cycle.as_slice() {
            [state] if !self.contains_itself(*state)? => vec![self.of_state(*state, &HashMap::new())?],
            _ => {
                let endless = self.endless(&cycle, visit.called);
                self.fixed_point(&cycle)?.ok_or_else(|| self.led_here(endless))?
            }
        };
        for (state, loose) in cycle.iter().zip(found) {
            self.store.known(*state).loose.get_or_init(|| loose);
        }
        Ok(())
    }

    fn contains_itself(&self, state: u32) -> Result<bool, Fault> {
        let mut found = false;
        Piece::instances(self.store.pieces(state)?, &mut |it, _| found |= it == state);
        Ok(found)
    }

    fn of_state(&self, state: u32, guess: &HashMap<u32, Loose>) -> Result<Loose, Fault> {
        let known = |it: u32| guess.get(&it).copied().unwrap_or_else(|| self.store.known_loose(it));
        Ok(Loose::of_pieces(self.store.pieces(state)?, &known))
    }

    /// Bounds for all states of a cycle, such that what is made from them lies in them.
    fn fixed_point(&self, cycle: &[u32]) -> Result<Option<Vec<Loose>>, Fault> {
        let step = |bounds: &[Loose]| -> Result<Vec<Loose>, Fault> {
            let guess: HashMap<u32, Loose> = cycle.iter().copied().zip(bounds.iter().copied()).collect();
            cycle.iter().map(|it| self.of_state(*it, &guess)).collect()
        };
        let holds = |outer: &[Loose], inner: &[Loose]| outer.iter().zip(inner).all(|(a, b)| a.contains(b));
        let mut reached = vec![Loose::EMPTY; cycle.len()];
        // From nothing, a cycle that shrinks comes near its bounds in some rounds but hardly ever gets there.
        for _ in 0..24 {
            reached = step(&reached)?;
        }
        if reached.iter().all(|it| it.bounds.is_empty()) {
            // Round and round, and never a primitive: what such a cycle comes to, if it shrinks, is where any point goes.
            reached = vec![Loose::of_box(Aabb { min: DVec3::ZERO, max: DVec3::ZERO }); cycle.len()];
            for _ in 0..24 {
                reached = step(&reached)?;
            }
        }
        // Boxes may grow as they turn though what is in them shrinks; the box around a ball does not.
        let balls: Vec<Loose> = reached.iter().map(Loose::around_ball).collect();
        for start in [reached, balls] {
            let mut factor = 1.0 + 1e-3;
            // Up to 2^40 times as far. Further out, adding what a step of the cycle moves by would be lost in rounding.
            for _ in 0..50 {
                let mut guess: Vec<Loose> = start.iter().map(|it| it.inflated(factor)).collect();
                if holds(&guess, &step(&guess)?) {
                    // What is made from bounds that hold holds as well, and is smaller.
                    for _ in 0..24 {
                        guess = step(&guess)?;
                    }
                    return Ok(Some(guess));
                }
                factor = 1.0 + (factor - 1.0) * 2.0;
            }
        }
        Ok(None)
    }

    fn endless(&self, cycle: &[u32], called: Origin) -> Fault {
        let selects = cycle.iter().filter_map(|it| match self.store.state(*it).entry {
            Entry::Select(select) => Some((*it, select)),
            Entry::System(_) => None,
        });
        match selects.min() {
            Some((state, select)) => {
                let module = self.store.step(state, called).name;
                Fault::new(FaultKind::Endless { select, module }, called)
            }
            None => {
                let most = u64::from(self.store.limits.depth);
                Fault::new(FaultKind::Limit { limit: Limit::Depth, most }, called)
            }
        }
    }
}

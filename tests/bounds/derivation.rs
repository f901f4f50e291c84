//! Points of what is really there: derivations followed at random down to a primitive, and points of its surface.

use glam::{DAffine3, DVec3};
use treegen_runtime::Fault;
use treegen_runtime::form::PrimitiveKind;
use treegen_runtime::geometry::{Primitive, Ray};
use treegen_runtime::trace::{Expander, Group, Item, Solid, State};

/// Numbers made at random: a sequence of its own for each seed.
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    }

    pub(crate) fn direction(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()).normalize_or(DVec3::X)
    }
}

/// A state on the way to some points, and where these lie in its frame.
pub(crate) struct Stop {
    pub(crate) state: State,
    pub(crate) points: Vec<DVec3>,
}

/// States inside one another that are followed at most.
const DEEPEST: usize = 80;

/// Follows a derivation from a state to a primitive that is drawn by lot, and takes points of its surface: for each state
/// on the way, where they lie. Nothing if the way ends in nothing, or goes on too long.
pub(crate) fn follow(expander: &Expander<'_>, root: State, dice: &mut Dice) -> Result<Vec<Stop>, Fault> {
    let mut way = vec![(root, DAffine3::IDENTITY)];
    loop {
        let (state, _) = &way[way.len() - 1];
        let group = expander.expand(state)?;
        match pick(expander, &group, dice, 4)? {
            Some(Picked::Points(points)) => return Ok(stops(&way, points)),
            Some(Picked::State(state, map)) if way.len() < DEEPEST => way.push((state, map)),
            _ => return Ok(Vec::new()),
        }
    }
}

/// From points in the innermost frame to where they lie in each.
fn stops(way: &[(State, DAffine3)], points: Vec<DVec3>) -> Vec<Stop> {
    let mut points = points;
    let mut stops = Vec::new();
    for (state, map) in way.iter().rev() {
        stops.push(Stop { state: state.clone(), points: points.clone() });
        points.iter_mut().for_each(|it| *it = map.transform_point3(*it));
    }
    stops
}

enum Picked {
    Points(Vec<DVec3>),
    State(State, DAffine3),
}

/// One part of a group by lot: a state in it, or points of its surface.
fn pick(expander: &Expander<'_>, group: &Group, dice: &mut Dice, nested: u32) -> Result<Option<Picked>, Fault> {
    if group.items.is_empty() {
        return Ok(None);
    }
    let item = &group.items[dice.below(group.items.len())];
    let map = item.group_from_item;
    match &item.solid {
        Solid::Leaf { primitive, .. } => Ok(Some(Picked::Points(mapped(surface(primitive, dice), &map)))),
        Solid::Instance(state, _) => Ok(Some(Picked::State(state.clone(), map))),
        Solid::Intersect(operands) => {
            let number = dice.below(operands.len());
            let points = points_of(expander, &operands[number], dice, nested)?;
            let inside = |point: &DVec3| {
                operands.iter().enumerate().all(|(other, it)| other == number || holds(expander, it, *point, nested))
            };
            Ok(Some(Picked::Points(mapped(points.into_iter().filter(inside).collect(), &map))))
        }
        Solid::Difference(first, others) => {
            let points = points_of(expander, first, dice, nested)?;
            let outside = |point: &DVec3| others.iter().all(|it| !holds(expander, it, *point, nested));
            Ok(Some(Picked::Points(mapped(points.into_iter().filter(outside).collect(), &map))))
        }
    }
}

fn mapped(points: Vec<DVec3>, map: &DAffine3) -> Vec<DVec3> {
    points.into_iter().map(|it| map.transform_point3(it)).collect()
}

/// Points of the surface of a group, through its states down to primitives.
fn points_of(expander: &Expander<'_>, group: &Group, dice: &mut Dice, nested: u32) -> Result<Vec<DVec3>, Fault> {
    let Some(below) = nested.checked_sub(1) else { return Ok(Vec::new()) };
    match pick(expander, group, dice, below)? {
        None => Ok(Vec::new()),
        Some(Picked::Points(points)) => Ok(points),
        Some(Picked::State(state, map)) => {
            let inner = expander.expand(&state)?;
            Ok(mapped(points_of(expander, &inner, dice, below)?, &map))
        }
    }
}

/// Whether a point surely lies in a group; of what goes too deep nothing is said.
fn holds(expander: &Expander<'_>, group: &Group, point: DVec3, nested: u32) -> bool {
    let of = |item: &Item| {
        let map = item.group_from_item.inverse();
        let point = map.transform_point3(point);
        let Some(below) = nested.checked_sub(1) else { return false };
        match &item.solid {
            Solid::Leaf { primitive, .. } => {
                let ray = Ray { origin: point, direction: DVec3::new(0.3, 0.5, 0.8) };
                primitive.chords(&ray, None).iter().any(|it| it.near.t < 0.0 && it.far.t > 0.0)
            }
            Solid::Instance(state, _) => expander.expand(state).is_ok_and(|it| holds(expander, &it, point, below)),
            Solid::Intersect(operands) => operands.iter().all(|it| holds(expander, it, point, below)),
            Solid::Difference(first, others) => {
                holds(expander, first, point, below) && !others.iter().any(|it| holds(expander, it, point, below))
            }
        }
    };
    group.items.iter().any(of)
}

/// Points of the surface of a primitive: where lines by lot come in and go out.
fn surface(primitive: &Primitive, dice: &mut Dice) -> Vec<DVec3> {
    if primitive.kind() == PrimitiveKind::Triangle {
        // Its corners, and points between them.
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let between = (0..9).map(|_| {
            let (a, b) = (dice.unit().abs(), dice.unit().abs());
            if a + b < 1.0 { DVec3::new(a, b, 0.0) } else { DVec3::new(1.0 - a, 1.0 - b, 0.0) }
        });
        return between.chain(corners).collect();
    }
    let mut points = Vec::new();
    for _ in 0..12 {
        let target = DVec3::new(dice.unit(), dice.unit(), dice.unit());
        let direction = dice.direction();
        let ray = Ray { origin: target - direction * 3.0, direction };
        let ends = primitive.chords(&ray, None);
        points.extend(ends.iter().flat_map(|it| [ray.at(it.near.t), ray.at(it.far.t)]));
    }
    points.retain(|it| it.is_finite());
    points
}

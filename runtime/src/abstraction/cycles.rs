//! Cycles: states that lead back to themselves, and bounds that hold for all of them at once.
//!
//! Bounds that hold whatever is made from them hold for ever. If a cycle shrinks there are such bounds. Nothing here
//! depends on the order in which the states of a cycle are given.

use glam::{DAffine3, DMat3, DVec3};

use super::circle::{self, Edge, all_shrink, one_that_keeps_size};
use super::entries::Circle;
use super::loose::Loose;
use super::profile::stretch;
use super::sketch::{Count, Extent, Part, Sketch, What};
use super::step::{Step, Way};
use crate::geometry::Aabb;

/// The strongly connected components of a graph reached from one node, each after those it leads to (Tarjan 1972). It
/// works on a stack of its own: derivations go deep.
pub(super) fn components(count: usize, start: u32, next: impl Fn(u32, usize) -> Option<u32>) -> Vec<Vec<u32>> {
    const UNSEEN: u32 = u32::MAX;
    const DONE: u32 = u32::MAX - 1;
    let mut numbers = vec![UNSEEN; count];
    let mut lows = vec![0_u32; count];
    let (mut found, mut open, mut seen) = (Vec::new(), Vec::new(), 0);
    let mut path: Vec<(u32, usize)> = vec![(start, 0)];
    while let Some((node, edge)) = path.last_mut() {
        let (at, number) = (*node, *edge);
        if number == 0 && numbers[at as usize] == UNSEEN {
            numbers[at as usize] = seen;
            lows[at as usize] = seen;
            seen += 1;
            open.push(at);
        }
        *edge += 1;
        if let Some(inner) = next(at, number) {
            match numbers[inner as usize] {
                UNSEEN => path.push((inner, 0)),
                DONE => {}
                known => lows[at as usize] = lows[at as usize].min(known),
            }
            continue;
        }
        path.pop();
        if let Some((above, _)) = path.last() {
            lows[*above as usize] = lows[*above as usize].min(lows[at as usize]);
        }
        if lows[at as usize] == numbers[at as usize] {
            let first = open.iter().rposition(|it| *it == at).unwrap_or(0);
            let component = open.split_off(first);
            component.iter().for_each(|it| numbers[*it as usize] = DONE);
            found.push(component);
        }
    }
    found
}

/// A state of a cycle.
#[derive(Clone, Copy)]
pub(super) struct Knot<'a> {
    pub(super) sketch: &'a Sketch,
    /// For each successor, its number in the cycle, or what it amounts to.
    pub(super) links: &'a [Link],
    /// The circle that its entry is in.
    pub(super) circle: Option<Circle>,
}

impl Knot<'_> {
    /// How many states of its circle are inside one another in it, if it is not one of a cycle.
    fn rounds(&self) -> u32 {
        let inner = self.links.iter().map(|it| match it {
            Link::Outside(extent) if extent.circle == self.circle => extent.rounds,
            Link::Outside(_) | Link::Inside(_) => 0,
        });
        inner.max().unwrap_or(0).saturating_add(1)
    }
}

/// Where a state of a cycle leads.
#[derive(Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "they live for one solution, and are mostly of the large kind")]
pub(super) enum Link {
    /// To the state of this number in the cycle.
    Inside(u32),
    /// Out of it.
    Outside(Extent),
}

/// That a cycle has no bounds: it does not shrink, or may not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Endless {
    /// A way round on which nothing gets smaller: the numbers of its states in the cycle, in order.
    pub(super) circle: Vec<usize>,
}

/// Rounds from nothing up, and from bounds that hold down.
const ROUNDS: u32 = 24;
/// How often bounds are tried that are twice as far out. Further out, adding what a step of the cycle moves by would be
/// lost in rounding.
const DOUBLINGS: u32 = 50;
/// Ways that a cycle is unrolled to.
const MOST_WAYS: usize = 1024;
/// Steps that a cycle is unrolled by.
const MOST_UNROLLED: u32 = 1 << 12;

/// What the states of a component amount to, in the order given.
///
/// # Errors
/// A cycle of theirs has no bounds.
pub(super) fn extents<'a>(component: impl Iterator<Item = Knot<'a>>) -> Result<Vec<Extent>, Endless> {
    let knots: Vec<Knot<'_>> = component.collect();
    match knots.as_slice() {
        [knot] if !knot.links.iter().any(|it| matches!(it, Link::Inside(_))) => {
            let known = |it: u32| match knot.links.get(it as usize) {
                Some(Link::Outside(extent)) => *extent,
                _ => Extent::EMPTY,
            };
            let extent = knot.sketch.extent(&known);
            let count = Count { states: extent.count.states.saturating_add(1), ..extent.count };
            let height = extent.height.saturating_add(1);
            let (circle, rounds) = (knot.circle, knot.rounds());
            Ok(vec![Extent { loose: extent.loose.with_room(), count, height, circle, rounds, ..extent }])
        }
        knots => solve(knots),
    }
}

/// Bounds for all states of a cycle, such that what is made from them lies in them.
fn solve(cycle: &[Knot<'_>]) -> Result<Vec<Extent>, Endless> {
    let step = |bounds: &[Loose]| step(cycle, bounds);
    let mut reached = vec![Loose::EMPTY; cycle.len()];
    // From nothing, a cycle that shrinks comes near its bounds in some rounds but hardly ever gets there.
    for _ in 0..ROUNDS {
        reached = step(&reached);
    }
    if reached.iter().all(Loose::is_empty) {
        // Round and round, and never a primitive: what such a cycle comes to, if it shrinks, is where any point goes.
        reached = vec![Loose::of_box(Aabb { min: DVec3::ZERO, max: DVec3::ZERO }); cycle.len()];
        for _ in 0..ROUNDS {
            reached = step(&reached);
        }
    }
    let edges = edges(cycle);
    let found = match one_that_keeps_size(&edges, cycle.len()) {
        None => fixed_point(&reached, step),
        Some(_) => unrolled(cycle, &reached),
    };
    let found = found.ok_or_else(|| endless(&edges, cycle.len()))?;
    let links = cycle.iter().flat_map(|it| it.links);
    let outside = links.filter_map(|it| if let Link::Outside(extent) = it { Some(extent.height) } else { None });
    let height = outside.max().unwrap_or(0).saturating_add(1);
    let extent = |(loose, knot): (Loose, &Knot<'_>)| Extent { loose, height, circle: knot.circle, ..Extent::ALL };
    Ok(found.into_iter().zip(cycle).map(extent).collect())
}

/// What to say of a cycle without bounds.
fn endless(edges: &[Edge], count: usize) -> Endless {
    let any = || edges.first().map(|it| circle::through(edges, count, it));
    Endless { circle: one_that_keeps_size(edges, count).or_else(any).unwrap_or_default() }
}

/// What a round through a cycle makes of bounds.
fn step(cycle: &[Knot<'_>], bounds: &[Loose]) -> Vec<Loose> {
    let of = |knot: &Knot<'_>| {
        let known = |it: u32| match knot.links.get(it as usize) {
            Some(Link::Inside(number)) => Extent { loose: bounds[*number as usize], ..Extent::EMPTY },
            Some(Link::Outside(extent)) => *extent,
            None => Extent::EMPTY,
        };
        knot.sketch.extent(&known).loose.with_room()
    };
    cycle.iter().map(of).collect()
}

fn fixed_point(reached: &[Loose], step: impl Fn(&[Loose]) -> Vec<Loose>) -> Option<Vec<Loose>> {
    let holds = |outer: &[Loose], inner: &[Loose]| outer.iter().zip(inner).all(|(a, b)| a.contains(b));
    // Boxes may grow as they turn though what is in them shrinks; the box around a ball does not.
    let balls: Vec<Loose> = reached.iter().map(Loose::around_ball).collect();
    let centered: Vec<Loose> = reached.iter().map(Loose::around_origin).collect();
    for start in [reached, &balls, &centered] {
        let mut factor = 1.0 + 1e-3;
        for _ in 0..DOUBLINGS {
            let mut guess: Vec<Loose> = start.iter().map(|it| it.inflated(factor)).collect();
            if holds(&guess, &step(&guess)) {
                // What is made from bounds that hold holds as well, and is smaller.
                for _ in 0..ROUNDS {
                    guess = step(&guess);
                }
                return Some(guess);
            }
            factor = 1.0 + (factor - 1.0) * 2.0;
        }
    }
    None
}

fn edges(cycle: &[Knot<'_>]) -> Vec<Edge> {
    let mut edges = Vec::new();
    for (from, knot) in cycle.iter().enumerate() {
        knot.sketch.ways(&Way::default(), &mut |way, state| {
            if let Some(Link::Inside(to)) = knot.links.get(state as usize) {
                edges.push(Edge { from, to: *to as usize, stretch: way.stretch() });
            }
        });
    }
    edges
}

/// A way through a cycle of some steps.
#[derive(Clone, Copy)]
struct Path {
    from: usize,
    to: usize,
    map: DAffine3,
}

/// Bounds for a cycle that grows in one step and yet shrinks in many: a shear, say. Its steps must be known.
fn unrolled(cycle: &[Knot<'_>], reached: &[Loose]) -> Option<Vec<Loose>> {
    let mut paths = known_paths(cycle)?;
    // What there is within so many steps of each state.
    let mut near = step(cycle, &vec![Loose::EMPTY; cycle.len()]);
    let mut length = 1;
    while length < MOST_UNROLLED {
        // Twice as many steps: what is there, and the same again at the end of each way.
        let further = |it: usize| {
            let ways = paths.iter().filter(|path| path.from == it);
            let mut all = vec![near[it]];
            all.extend(ways.map(|path| near[path.to].through_map(&path.map)));
            Loose::union(&all).with_room()
        };
        near = (0..cycle.len()).map(further).collect();
        paths = doubled(&paths)?;
        length *= 2;
        let of = |path: &Path| Edge { from: path.from, to: path.to, stretch: norm(&path.map.matrix3) };
        let edges: Vec<Edge> = paths.iter().map(of).collect();
        if all_shrink(&edges, cycle.len()) {
            let sketches: Vec<Sketch> = (0..cycle.len()).map(|it| composite(it, &near, &paths)).collect();
            let links: Vec<Link> = (0..cycle.len() as u32).map(Link::Inside).collect();
            let knots: Vec<Knot<'_>> =
                sketches.iter().map(|sketch| Knot { sketch, links: &links, circle: None }).collect();
            return fixed_point(reached, |it| step(&knots, it));
        }
    }
    None
}

/// The ways of one step, if all are known and nothing is cut.
fn known_paths(cycle: &[Knot<'_>]) -> Option<Vec<Path>> {
    let mut paths = Vec::new();
    for (from, knot) in cycle.iter().enumerate() {
        for part in &knot.sketch.parts {
            let What::State(state) = &part.what else { return None };
            if let Some(Link::Inside(to)) = knot.links.get(*state as usize) {
                paths.push(Path { from, to: *to as usize, map: part.way.known()? });
            }
        }
    }
    Some(paths)
}

fn doubled(paths: &[Path]) -> Option<Vec<Path>> {
    let mut longer = Vec::new();
    for first in paths {
        for second in paths.iter().filter(|it| it.from == first.to) {
            longer.push(Path { from: first.from, to: second.to, map: first.map * second.map });
            if longer.len() > MOST_WAYS {
                return None;
            }
        }
    }
    Some(longer)
}

fn composite(state: usize, near: &[Loose], paths: &[Path]) -> Sketch {
    let ways = paths.iter().filter(|it| it.from == state);
    let part = |path: &Path| {
        let mut way = Way::default();
        way.push(Step::Known { map: path.map, stretch: norm(&path.map.matrix3) });
        Part { way, copies: 1, certain: true, what: What::State(path.to as u32) }
    };
    Sketch::new(near[state], ways.map(part).collect())
}

/// At least the norm of a matrix, though it is a product of many.
fn norm(matrix: &DMat3) -> f64 {
    stretch(matrix) * (1.0 + 1e-9)
}

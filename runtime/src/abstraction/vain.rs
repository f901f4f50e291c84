//! Solids that have nothing in them, for certain: planes that leave nothing, quadrics that no point is inside of, operands of `&` that do not
//! meet, and what `\` takes away whole.
//!
//! Looked for in the states that are certain to be there and know all their values without a draw. What stands at one place of the text
//! may be there many times, in a `repeat` or for many values: nothing is said of it if it has something in it once.

use std::collections::{BTreeMap, HashSet};

use glam::{DAffine3, DVec3};

use super::certain::{MOST_STATES, concrete};
use super::flow::Flow;
use super::loose::primitive_bounds;
use super::run::Explored;
use crate::form::{Origin, PrimitiveKind};
use crate::geometry::{Aabb, Primitive};
use crate::trace::{Entry, Expander, Group, Solid};

/// How near two solids are one, in parts of their size: the pieces of a ray that are left between them are too short to count.
const NEAR: f64 = 1e-12;

/// A solid that has nothing in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vain {
    /// A hull whose planes leave nothing.
    Hull(Origin),
    /// A quadric that no point is inside of.
    Quadric(Origin),
    /// An intersection, with an operand and one after it that does not meet it, or not what it leaves.
    Apart(Origin, Origin),
    /// A difference, with what it cuts and what takes all of that away.
    CutAway(Origin, Origin),
}

/// A place in the text, in an order.
type Place = (u32, u32, u32);

/// What stands at each place, by its first solid and its last: nothing, as far as is known.
type Places = BTreeMap<(Place, Place), Option<Vain>>;

/// The solids among all that was met that have nothing in them; the expander is one within limits of its own.
pub(super) fn solids(expander: &Expander<'_>, flow: &Flow, explored: &Explored) -> Vec<Vain> {
    // Of entries that are met with values that are not looked at, nothing is known.
    let mut unknown: HashSet<Entry> = HashSet::new();
    let mut found: Vec<(Entry, Places)> = Vec::new();
    for (number, it) in explored.met.iter().enumerate() {
        let met = explored.state(it);
        let state = (it.certain && number < MOST_STATES).then(|| concrete(expander, flow, met)).flatten();
        let group = state.filter(|it| it.path.is_none()).and_then(|it| expander.expand(&it).ok());
        match group {
            Some(group) => {
                let mut places = Places::new();
                look(&group, &mut places);
                found.push((met.entry, places));
            }
            None => {
                unknown.insert(met.entry);
            }
        }
    }
    let mut all = Places::new();
    for (_, places) in found.into_iter().filter(|it| !unknown.contains(&it.0)) {
        places.into_iter().for_each(|(place, vain)| note(&mut all, place, vain));
    }
    all.into_values().flatten().collect()
}

fn note(places: &mut Places, place: (Place, Place), vain: Option<Vain>) {
    places.entry(place).and_modify(|it| *it = it.and(vain)).or_insert(vain);
}

/// Looks at all that a state expands to.
fn look(group: &Group, places: &mut Places) {
    for item in &group.items {
        match &item.solid {
            Solid::Leaf { primitive, origin, .. } => {
                let vain = if let Some(hull) = primitive.hull() {
                    (hull.is_empty() && hull.open().is_none()).then_some(Vain::Hull(*origin))
                } else if primitive.kind() == PrimitiveKind::Quadric {
                    primitive.bounds().is_empty().then_some(Vain::Quadric(*origin))
                } else {
                    continue;
                };
                note(places, (place(*origin), place(*origin)), vain);
            }
            Solid::Instance(..) => {}
            Solid::Intersect(operands) => {
                operands.iter().for_each(|it| look(it, places));
                judge(operands.iter(), apart(operands), places);
            }
            Solid::Difference(first, others) => {
                std::iter::once(&**first).chain(others).for_each(|it| look(it, places));
                judge(std::iter::once(&**first).chain(others), cut_away(first, others), places);
            }
        }
    }
}

/// Notes what is known of a Boolean.
fn judge<'g>(mut operands: impl DoubleEndedIterator<Item = &'g Group>, vain: Option<Vain>, places: &mut Places) {
    let (first, last) = (operands.next().and_then(first_place), operands.next_back().and_then(first_place));
    if let (Some(first), Some(last)) = (first, last) {
        note(places, (place(first), place(last)), vain);
    }
}

/// Operands that do not meet: the first, and the first one that meets nothing of those before it.
fn apart(operands: &[Group]) -> Option<Vain> {
    let first = operands.first().and_then(first_place)?;
    let mut left = Aabb::ALL;
    for operand in operands {
        left = left.intersection(&bounds(operand, &DAffine3::IDENTITY));
        if left.is_empty() {
            return Some(Vain::Apart(first, first_place(operand)?)).filter(|_| !std::ptr::eq(operand, &operands[0]));
        }
    }
    None
}

/// What cuts all of a single solid away: the same one in the same place.
fn cut_away(first: &Group, others: &[Group]) -> Option<Vain> {
    let [item] = first.items.as_slice() else { return None };
    let Solid::Leaf { primitive, origin, .. } = &item.solid else { return None };
    for other in others.iter().flat_map(|it| &it.items) {
        if let Solid::Leaf { primitive: cutter, origin: by, .. } = &other.solid
            && is_same(primitive, cutter)
            && is_near(&item.group_from_item, &other.group_from_item)
        {
            return Some(Vain::CutAway(*origin, *by));
        }
    }
    None
}

/// Whether two primitives are the same unit solid, as far as is easily told.
fn is_same(one: &Primitive, other: &Primitive) -> bool {
    let kind = one.kind();
    let is_told_by_its_reach = matches!(
        kind,
        PrimitiveKind::Sphere
            | PrimitiveKind::Cylinder
            | PrimitiveKind::Box
            | PrimitiveKind::Tetrahedron
            | PrimitiveKind::Cone
            | PrimitiveKind::Torus
            | PrimitiveKind::Ellipsoid
    );
    // Along the axes, and so that both radii of a cone are told.
    let reaches = |it: &Primitive| {
        [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 0.0, 16.0), DVec3::new(1.0, 0.0, -16.0)]
            .map(|direction| it.support(direction))
    };
    kind == other.kind() && is_told_by_its_reach && reaches(one) == reaches(other)
}

fn is_near(one: &DAffine3, other: &DAffine3) -> bool {
    let (a, b) = (one.to_cols_array(), other.to_cols_array());
    let size = a[..9].iter().fold(0.0, |most: f64, it| most.max(it.abs()));
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= NEAR * size)
}

/// A box around a group in the frame outside a map; states in it may be anywhere.
fn bounds(group: &Group, outer_from_group: &DAffine3) -> Aabb {
    let of_item = |item: &crate::trace::Item| {
        let map = *outer_from_group * item.group_from_item;
        match &item.solid {
            Solid::Leaf { primitive, .. } => primitive_bounds(primitive, &map),
            Solid::Instance(..) => Aabb::ALL,
            Solid::Intersect(operands) => {
                operands.iter().fold(Aabb::ALL, |left, it| left.intersection(&bounds(it, &map)))
            }
            Solid::Difference(first, _) => bounds(first, &map),
        }
    };
    group.items.iter().map(of_item).fold(Aabb::EMPTY, |all, it| if it.is_empty() { all } else { all.union(&it) })
}

/// Where the first solid of a group is written.
fn first_place(group: &Group) -> Option<Origin> {
    group.items.iter().find_map(|item| match &item.solid {
        Solid::Leaf { origin, .. } | Solid::Instance(_, origin) => Some(*origin),
        Solid::Intersect(operands) => operands.iter().find_map(first_place),
        Solid::Difference(first, _) => first_place(first),
    })
}

fn place(origin: Origin) -> Place {
    (origin.file, origin.start, origin.end)
}

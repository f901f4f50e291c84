//! The states of a scene, one by one.

use std::collections::HashSet;

use super::tally::{MOST_BYTES, MOST_PARTS};
use crate::fault::{Fault, FaultKind};
use crate::form::{Origin, Scene};
use crate::limits::Limits;
use crate::picture::Watch;
use crate::quick_hash::BuildQuickHash;
use crate::trace::{Expander, Group, Solid, State};

/// How many states a scene has: each is expanded once, however often it is laid down. `None`: more than `most`, or too much in them.
///
/// # Errors
/// A fault on the way, or an interrupt.
pub fn count_states(scene: &Scene, most: usize, limits: &Limits, watch: &dyn Watch) -> Result<Option<usize>, Fault> {
    let expander = Expander::new(scene, limits);
    let mut seen: HashSet<State, BuildQuickHash> = HashSet::default();
    let mut ahead = vec![expander.root()?];
    seen.extend(ahead.iter().cloned());
    let (mut left, mut bytes) = (MOST_PARTS, 0);
    while let Some(state) = ahead.pop() {
        if watch.interrupted() {
            return Err(Fault::new(FaultKind::Interrupted, Origin::NONE));
        }
        let group = expander.expand(&state)?;
        left = left.saturating_sub(group.items.len() as u64);
        called(&group, &mut |it| {
            if seen.len() <= most && bytes <= MOST_BYTES && seen.insert(it.clone()) {
                bytes += 2 * it.bytes();
                ahead.push(it.clone());
            }
        });
        if seen.len() > most || left == 0 || bytes > MOST_BYTES {
            return Ok(None);
        }
    }
    Ok(Some(seen.len()))
}

/// Hands on every state in a group, and in the operands of its Booleans.
pub(super) fn called(group: &Group, take: &mut impl FnMut(&State)) {
    for item in &group.items {
        match &item.solid {
            Solid::Leaf { .. } => {}
            Solid::Instance(state, _) => take(state),
            Solid::Intersect(operands) => operands.iter().for_each(|it| called(it, take)),
            Solid::Difference(first, others) => {
                std::iter::once(&**first).chain(others).for_each(|it| called(it, take));
            }
        }
    }
}

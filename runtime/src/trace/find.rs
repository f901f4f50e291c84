//! Finding the derivations that a scene needs.

use std::collections::HashSet;

use super::expand::{Entry, Expander, Group, Solid, State};
use crate::eval::Env;
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{Node, Origin, Scene, ShapeId};
use crate::limits::Limits;

/// A shape as a scene uses it.
#[derive(Clone, Debug)]
pub struct Derivable {
    /// The shape.
    pub shape: ShapeId,
    /// The state that it is in.
    pub state: State,
    /// The environment of its system there. Slots that nothing reads are 0.
    pub env: Env,
}

/// The first shape that a scene shows, in the order written; with a name, the first of a system of that name.
///
/// # Errors
/// What fails in expanding the scene on the way there.
pub fn find_shape(scene: &Scene, limits: &Limits, name: Option<&str>) -> Result<Option<Derivable>, Fault> {
    Ok(find(scene, limits, name, 1)?.pop())
}

/// All shapes that a scene shows, in the order written, each with the values that it has there: those that shapes place are not looked for.
///
/// # Errors
/// What fails in expanding the scene.
pub fn find_shapes(scene: &Scene, limits: &Limits) -> Result<Vec<Derivable>, Fault> {
    find(scene, limits, None, usize::MAX)
}

fn find(scene: &Scene, limits: &Limits, name: Option<&str>, most: usize) -> Result<Vec<Derivable>, Fault> {
    let mut found = Vec::new();
    let expander = Expander::new(scene, limits);
    let mut seen: HashSet<State> = HashSet::new();
    // The next one last.
    let mut ahead = vec![expander.root()?];
    while let Some(state) = ahead.pop() {
        if !seen.insert(state.clone()) {
            continue;
        }
        if seen.len() > limits.items as usize {
            let kind = FaultKind::Limit { limit: Limit::Nodes, most: u64::from(limits.items) };
            return Err(Fault::new(kind, Origin::NONE));
        }
        if let Entry::System(id) = state.entry {
            let system = scene.graph.system(id);
            if let Node::Shape(shape) = scene.graph.node(system.start)
                && name.is_none_or(|it| it == system.name)
            {
                let env = expander.env(&state);
                found.push(Derivable { shape: *shape, state, env });
                if found.len() == most {
                    break;
                }
                continue;
            }
        }
        let group = expander.expand(&state)?;
        let before = ahead.len();
        states_in(&group, &mut ahead);
        ahead[before..].reverse();
    }
    Ok(found)
}

/// Adds the states in a group, those inside Booleans too, in the order written.
fn states_in(group: &Group, states: &mut Vec<State>) {
    for item in &group.items {
        match &item.solid {
            Solid::Leaf { .. } => {}
            Solid::Instance(state, _) => states.push(state.clone()),
            Solid::Intersect(operands) => operands.iter().for_each(|it| states_in(it, states)),
            Solid::Difference(first, others) => {
                std::iter::once(first.as_ref()).chain(others).for_each(|it| states_in(it, states));
            }
        }
    }
}

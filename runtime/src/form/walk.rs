//! Compiled walks: what the rules of `shape` and `hull` systems do, stride by stride (B08, section 3.2; FG86, section 2.1).
//!
//! A walk is plain data, read from left to right by the interpreter ([`derive`](crate::derive)). It names slots of its system, nodes
//! of the graph and modules of its own [`Shape`]; [`Graph`](super::Graph) checks that they are there.

use super::{Choice, Code, MaterialId, NodeId, Origin, Slot, SystemId, TransformKind};
use crate::eval::Formula;

/// Names a shape of a [`Graph`](super::Graph).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ShapeId(pub u32);

/// Names a module of a [`Shape`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ModuleId(pub u32);

/// The rules of a `shape` or `hull` system.
///
/// What it derives to depends on the slots of the system it belongs to and on the path, and on nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The system it belongs to.
    pub system: SystemId,
    /// The slots of its state: what its `var`s name. A module takes them along as they are when it is laid down.
    pub state: Vec<Slot>,
    /// What it starts with.
    pub start: Walk,
    /// Its modules.
    pub modules: Vec<Module>,
    /// How its normals split, if it is a hull.
    pub splitting: Option<Splitting>,
}

/// How the normals of a hull split.
#[derive(Clone, Debug, PartialEq)]
pub struct Splitting {
    /// Which splits next.
    pub order: Order,
    /// How many generations there are, or how many splits: one whole number, at least 0. None: 1.
    pub count: Option<Formula>,
    /// Whether normals are left out that do not point outwards (FG86, figure 3).
    pub outward: bool,
    /// The place of its own draws.
    pub place: u64,
    /// Its place in the text.
    pub origin: Origin,
}

/// Which normal of a hull splits next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// All at once, generation after generation.
    Parallel,
    /// The oldest.
    Oldest,
    /// Any.
    Random,
    /// The one whose life ends first: lives last 1 on an average, and how much is left of one does not depend on its age.
    Lifetime,
}

/// All rules of one module of a [`Shape`].
#[derive(Clone, Debug, PartialEq)]
pub struct Module {
    /// Its name.
    pub name: String,
    /// Where its parameters are bound.
    pub params: Vec<Slot>,
    /// How one of the rules is chosen among those of one priority. A selection function chooses among all.
    pub choice: Choice,
    /// Its rules in the order written.
    pub rules: Vec<WalkRule>,
    /// The place of its first rule in the text.
    pub origin: Origin,
}

/// One rule of a [`Module`].
#[derive(Clone, Debug, PartialEq)]
pub struct WalkRule {
    /// Its label, if it has one.
    pub label: Option<String>,
    /// Rules with smaller numbers are applied first.
    pub priority: i32,
    /// Whether its successor is added to the module (`+>`), which stays, and does not stand in its place.
    pub appends: bool,
    /// When it applies: one truth value. None: always.
    pub guard: Option<Formula>,
    /// Its weight: one number. None: 1.
    pub weight: Option<Formula>,
    /// Its successor.
    pub body: Walk,
    /// Its place in the text.
    pub origin: Origin,
}

/// A walk: strides taken one after the other with a frame, a paint, a state and a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walk {
    /// The strides.
    pub strides: Vec<Stride>,
}

/// One stride of a [`Walk`].
#[derive(Clone, Debug, PartialEq)]
pub enum Stride {
    /// Moves the frame.
    Transform {
        /// How.
        kind: TransformKind,
        /// The numbers of the transformation.
        code: Formula,
        /// Its place in the text.
        origin: Origin,
    },
    /// Turns the frame's z towards a direction.
    Toward {
        /// The direction in the system's own space (x, y, z), and by how many degrees at most.
        code: Formula,
        /// Its place in the text.
        origin: Origin,
    },
    /// Changes the state, or names values.
    Calc(Formula),
    /// Sets the paint.
    Paint(MaterialId),
    /// Folds the path to so many values.
    Variant {
        /// How many: one whole number, at least 1.
        count: Formula,
        /// Its place in the text.
        origin: Origin,
    },
    /// Lays a conical frustum along z, and moves to its end.
    Segment {
        /// Its length and its radii at both ends.
        code: Formula,
        /// A number that tells it apart from the other segments of its walk.
        number: u32,
        /// Its place in the text.
        origin: Origin,
    },
    /// Lays a normal that does not split.
    Normal {
        /// Its length.
        code: Formula,
        /// Its place in the text.
        origin: Origin,
    },
    /// Lays down a module, with the frame, the paint and the state as they are.
    Module {
        /// Which.
        module: ModuleId,
        /// Its arguments, one for each parameter. All are found before any is bound.
        args: Formula,
        /// The call's place, which joins the path.
        place: u64,
        /// Its place in the text.
        origin: Origin,
    },
    /// Places a solid in the frame.
    Place {
        /// The solid.
        solid: NodeId,
        /// A number that tells it apart from the other solids of its walk.
        number: u32,
        /// Its place in the text.
        origin: Origin,
    },
    /// A walk after which frame, paint, state and path are what they were.
    Bracket(Bracket),
    /// A walk taken so many times, each time with its number in a slot. The number joins the place of draws and calls.
    Repeat {
        /// How many times: one whole number, at least 0.
        count: Formula,
        /// Where each finds its number, from 0.
        index: Slot,
        /// What is repeated.
        body: Walk,
        /// Its place in the text.
        origin: Origin,
    },
    /// One of two walks, by a condition.
    Choice {
        /// The condition: one truth value.
        condition: Formula,
        /// The walk taken when it holds.
        then: Walk,
        /// The walk taken when it does not.
        otherwise: Walk,
    },
}

/// `[ walk ]`, with what has to be put back after it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bracket {
    walk: Walk,
    // Invariant: every slot of the state that the walk assigns.
    assigned: Vec<Slot>,
}

impl Bracket {
    /// Brackets around a walk of a system whose state is in these slots.
    pub fn new(walk: Walk, state: &[Slot]) -> Self {
        let mut assigned = Vec::new();
        walk.visit(&mut |stride| {
            if let Stride::Calc(code) = stride {
                assigned.extend(code.code().stores().filter(|it| state.contains(it)));
            }
        });
        assigned.sort_unstable();
        assigned.dedup();
        Self { walk, assigned }
    }

    /// The walk inside.
    pub fn walk(&self) -> &Walk {
        &self.walk
    }

    /// The slots of the state that the walk assigns.
    pub fn assigned(&self) -> &[Slot] {
        &self.assigned
    }
}

impl Walk {
    /// Calls `visit` with all strides, those inside others after them.
    ///
    /// It calls itself for walks inside others, whose nesting the grammar limits.
    pub fn visit<'w>(&'w self, visit: &mut impl FnMut(&'w Stride)) {
        for stride in &self.strides {
            visit(stride);
            match stride {
                Stride::Bracket(bracket) => bracket.walk.visit(visit),
                Stride::Repeat { body, .. } => body.visit(visit),
                Stride::Choice { then, otherwise, .. } => {
                    then.visit(visit);
                    otherwise.visit(visit);
                }
                Stride::Transform { .. }
                | Stride::Toward { .. }
                | Stride::Calc(_)
                | Stride::Paint(_)
                | Stride::Variant { .. }
                | Stride::Segment { .. }
                | Stride::Normal { .. }
                | Stride::Module { .. }
                | Stride::Place { .. } => {}
            }
        }
    }
}

impl Stride {
    /// Its code, and how many results that must give if it is known. Not all strides have one.
    pub fn code(&self) -> Option<(&Code, Option<usize>)> {
        let (formula, results) = match self {
            Self::Transform { kind, code, .. } => (code, Some(kind.params())),
            Self::Toward { code, .. } => (code, Some(4)),
            Self::Calc(code) => (code, None),
            Self::Segment { code, .. } => (code, Some(3)),
            Self::Normal { code, .. } => (code, Some(1)),
            Self::Module { args, .. } => (args, None),
            Self::Variant { count, .. } | Self::Repeat { count, .. } => (count, Some(1)),
            Self::Choice { condition, .. } => (condition, Some(1)),
            Self::Paint(_) | Self::Place { .. } | Self::Bracket(_) => return None,
        };
        Some((formula.code(), results))
    }
}

impl Shape {
    /// All its walks.
    pub fn walks(&self) -> impl Iterator<Item = &Walk> {
        std::iter::once(&self.start).chain(self.modules.iter().flat_map(|it| it.rules.iter().map(|it| &it.body)))
    }

    /// The solids that its walks place.
    pub fn solids(&self) -> impl Iterator<Item = NodeId> {
        let mut solids = Vec::new();
        for walk in self.walks() {
            walk.visit(&mut |stride| {
                if let Stride::Place { solid, .. } = stride {
                    solids.push(*solid);
                }
            });
        }
        solids.into_iter()
    }

    /// The codes by which it chooses rules, and finds how often they are applied.
    pub fn selections(&self) -> impl Iterator<Item = &Code> {
        let count = self.splitting.iter().filter_map(|it| it.count.as_ref().map(Formula::code));
        let rules = self.modules.iter().flat_map(|module| {
            let function = if let Choice::Function(code) = &module.choice { Some(code) } else { None };
            let rules = module.rules.iter().flat_map(|it| it.guard.iter().chain(&it.weight));
            function.into_iter().chain(rules.map(Formula::code))
        });
        count.chain(rules)
    }
}

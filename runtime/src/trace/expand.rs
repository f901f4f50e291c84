//! States, and what one stands for up to the next ones.
//!
//! A state is where the derivation of a graph comes back to: an S-node or a system, with the values that anything below it still
//! reads. Expanding a state evaluates every C-, S- and T-node up to the next states, and gives what is there. It is a pure function
//! of the state.

use std::sync::Arc;

use glam::DAffine3;

use super::Route;
use super::distinct::{Constant, Distinct};
use super::liveness::{Live, Liveness};
use super::walk::{CHOICE, Here, Walk};
use crate::eval::{Env, Machine, Path, matrix, trail_step};
use crate::fault::{Fault, FaultKind, TrailStep};
use crate::form::{Graph, MaterialId, NodeId, Origin, Scene, SelectId, Slot, SystemId, Value};
use crate::geometry::{Hide, Part, Primitive, Relief, Rind};
use crate::limits::Limits;

/// Where a derivation stands: two states that are equal stand for the same solid.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct State {
    /// The S-node that is to select, or the system that is to start.
    pub entry: Entry,
    /// The values of the slots that are live there.
    pub slots: Box<[Value]>,
    /// The path, if anything below draws.
    pub path: Option<Path>,
    /// The paint that it is given, if that has a relief: stems without paint of their own have it.
    pub hide: Option<MaterialId>,
}

impl State {
    /// One of the states that have the same values on paths made up; none if nothing below draws.
    pub(crate) fn likeness(&self, which: u32) -> Option<Self> {
        self.path.map(|_| Self { path: Some(Path::made_up(which)), ..self.clone() })
    }

    /// About how many bytes it takes. Lists are shared, and counted by their places only.
    pub(crate) fn bytes(&self) -> usize {
        let of = |value: &Value| if let Value::List(it) = value { size_of_val(&**it) } else { 0 };
        size_of::<Self>() + size_of_val(&*self.slots) + self.slots.iter().map(of).sum::<usize>()
    }
}

/// The nodes where states are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Entry {
    /// An S-node.
    Select(SelectId),
    /// A system, its formals, `let`s and first state filled in.
    System(SystemId),
}

/// The union of some parts, all in one frame.
#[derive(Clone, Debug, Default)]
pub struct Group {
    /// The parts, in the order written.
    pub items: Vec<Item>,
}

impl Group {
    /// A frame for the next part to stand in, that of the last part if it is the same.
    pub(super) fn shared(&self, frame: Option<DAffine3>) -> Option<Arc<DAffine3>> {
        let frame = frame?;
        let last = self.items.last().and_then(|it| it.group_from_paint.as_ref());
        Some(last.filter(|it| ***it == frame).map_or_else(|| Arc::new(frame), Arc::clone))
    }
}

/// One part of a [`Group`].
#[derive(Clone, Debug)]
pub struct Item {
    /// Maps points of the part's own frame to the group's.
    pub group_from_item: DAffine3,
    /// The innermost paint between the group and the part; what is inside the part and has its own paint keeps that.
    pub material: Option<MaterialId>,
    /// The frame in which that paint stands, in the group's, if its look depends on it. Neighbours of the same frame share it.
    pub group_from_paint: Option<Arc<DAffine3>>,
    /// The choices and copies between the group and the part.
    pub route: Route,
    /// What it is.
    pub solid: Solid,
}

/// What a part of a [`Group`] can be.
#[derive(Clone, Debug)]
pub enum Solid {
    /// A primitive.
    Leaf {
        /// Which.
        primitive: Primitive,
        /// Its place in the text.
        origin: Origin,
        /// What is known of its rind, if it is a segment of a stem and paints ask for that.
        bark: Option<Box<Bark>>,
    },
    /// Whatever a state stands for. The place is that of the call in the text.
    Instance(State, Origin),
    /// What lies in all of these. Inside of Booleans routes do not count: the whole is one solid.
    Intersect(Vec<Group>),
    /// What lies in the first and in none of the others.
    Difference(Box<Group>, Vec<Group>),
}

/// The surface of a segment.
#[derive(Clone, Debug)]
pub struct Bark {
    /// Its rind.
    pub rind: Rind,
    /// Its relief.
    pub hide: Option<Arc<Hide>>,
}

impl Bark {
    /// Its relief on this rind.
    pub(crate) fn relief(&self) -> Option<Relief<'_>> {
        self.hide.as_deref().map(|it| Relief::new(&self.rind, it))
    }
}

/// What a node is if it is the same everywhere.
#[derive(Clone, Debug)]
pub(super) enum Fixed {
    /// It is not, or fails.
    No,
    /// The matrix of a T-node.
    Matrix(DAffine3),
    /// A primitive.
    Primitive(Primitive),
}

/// A stem whole.
#[derive(Debug)]
pub(crate) struct WholeStem<'p> {
    /// Its parts in order, in the frame of the group.
    pub(crate) parts: &'p [Part],
    /// For each part the frame in which its paint stands, in the group's, if its look depends on it.
    pub(crate) group_from_paint: &'p [Option<DAffine3>],
    /// The choices and copies between the group and the stem.
    pub(crate) route: Route,
}

/// Takes a stem.
pub(crate) type StemTaker<'t> = dyn FnMut(&WholeStem<'_>) -> Result<(), Fault> + 't;

/// Expands the states of a scene.
#[derive(Debug)]
pub struct Expander<'s> {
    pub(super) graph: &'s Graph,
    pub(super) limits: Limits,
    pub(super) seed: u64,
    /// By number of the material: whether its look depends on the frame in which its paint stands.
    in_place: Box<[bool]>,
    /// Whether it depends on where things are on stems.
    on_stems: Box<[bool]>,
    /// The reliefs of materials.
    hides: Box<[Option<Arc<Hide>>]>,
    liveness: Liveness,
    fixed: Distinct<Fixed>,
}

impl<'s> Expander<'s> {
    /// An expander for a scene.
    pub fn new(scene: &'s Scene, limits: &Limits) -> Self {
        let graph = &scene.graph;
        let materials = 0..scene.materials.len() as u32;
        Self {
            graph,
            limits: *limits,
            seed: scene.seed,
            in_place: materials.clone().map(|it| scene.is_painted_in_place(MaterialId(it))).collect(),
            on_stems: materials.map(|it| scene.is_painted_on_stems(MaterialId(it))).collect(),
            hides: scene.hides(),
            liveness: Liveness::of(graph),
            fixed: Distinct::of(graph, Fixed::No, |it| fixed(graph, it)),
        }
    }

    /// Whether a material's look depends on the frame in which its paint stands.
    pub(super) fn is_in_place(&self, material: MaterialId) -> bool {
        self.in_place.get(material.0 as usize).is_some_and(|it| *it)
    }

    /// Whether a material's look depends on where things are on stems.
    pub(super) fn is_on_stems(&self, material: Option<MaterialId>) -> bool {
        material.and_then(|it| self.on_stems.get(it.0 as usize)).is_some_and(|it| *it)
    }

    /// A material, if it has a relief.
    pub(super) fn with_relief(&self, material: MaterialId) -> Option<MaterialId> {
        self.hides.get(material.0 as usize).is_some_and(Option::is_some).then_some(material)
    }

    /// What is to be known of the bark of a part of a stem that this relief's material is on.
    pub(super) fn bark(&self, part: &Part, hide: Option<MaterialId>) -> Option<Bark> {
        // Its paint may be one that the shape as a whole is given.
        let rind = part.rind.filter(|_| self.on_stems.contains(&true))?;
        let hide = hide.and_then(|it| self.hides.get(it.0 as usize)?.clone());
        Some(Bark { rind, hide })
    }

    /// The state of the whole scene.
    ///
    /// # Errors
    /// What fails in finding the scene's own values.
    pub fn root(&self) -> Result<State, Fault> {
        let env = self.machine().root(self.graph)?;
        Ok(self.state(Entry::System(self.graph.root()), &env))
    }

    /// The same where that may take so much.
    ///
    /// # Errors
    /// As [`Expander::root`].
    pub(crate) fn root_within(&self, limits: &Limits) -> Result<State, Fault> {
        let env = Machine::new(self.graph.functions(), self.seed, limits).root(self.graph)?;
        Ok(self.state(Entry::System(self.graph.root()), &env))
    }

    /// How far things may grow.
    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// What a state stands for, up to the next states.
    ///
    /// # Errors
    /// A fault in an evaluation on the way, or more parts than the limit.
    pub fn expand(&self, state: &State) -> Result<Group, Fault> {
        self.expand_with(&mut self.machine(), state)
    }

    /// The same without stems: those are handed on whole.
    ///
    /// # Errors
    /// As [`Expander::expand`], or whatever the taker of stems says.
    pub(crate) fn expand_but_stems(&self, state: &State, stems: &mut StemTaker<'_>) -> Result<Group, Fault> {
        self.expand_to(&mut self.machine(), state, Some(stems))
    }

    /// The same on a machine that is there already.
    pub(super) fn expand_with(&self, machine: &mut Machine<'s>, state: &State) -> Result<Group, Fault> {
        self.expand_to(machine, state, None)
    }

    fn expand_to(
        &self,
        machine: &mut Machine<'s>,
        state: &State,
        stems: Option<&mut StemTaker<'_>>,
    ) -> Result<Group, Fault> {
        let mut env = self.env(state);
        let mut group = Group::default();
        let (body, route) = match state.entry {
            Entry::System(id) => (self.graph.system(id).start, Route::START),
            Entry::Select(id) => {
                let select = self.graph.select(id);
                let chosen = machine.choose(self.graph, select, &mut env).map_err(|it| self.without_unknown(id, it))?;
                (select.rules[chosen].body, Route::step(CHOICE ^ chosen as u64))
            }
        };
        Walk::new(self, machine, env, stems).add(&mut group, body, Here::at(route, state.hide))?;
        Ok(group)
    }

    /// What the program says shall stand for a state from far away; none if it says nothing.
    ///
    /// # Errors
    /// As [`Expander::expand`].
    pub fn expand_proxy(&self, state: &State) -> Result<Option<Group>, Fault> {
        self.expand_proxy_with(&mut self.machine(), state)
    }

    /// The same on a machine that is there already.
    pub(super) fn expand_proxy_with(&self, machine: &mut Machine<'s>, state: &State) -> Result<Option<Group>, Fault> {
        let Some(proxy) = self.proxy(state.entry) else {
            return Ok(None);
        };
        let mut group = Group::default();
        let here = Here::at(Route::START, state.hide);
        Walk::new(self, machine, self.env(state), None).add(&mut group, proxy, here)?;
        Ok(Some(group))
    }

    /// The node that stands for the states of an entry from far away, if the program names one.
    pub(super) fn proxy(&self, entry: Entry) -> Option<NodeId> {
        match entry {
            Entry::Select(id) => self.graph.select(id).proxy,
            Entry::System(_) => None,
        }
    }

    /// What to tell about a state in the trail of a fault below it.
    pub fn trail_step(&self, state: &State, origin: Origin) -> TrailStep {
        match state.entry {
            Entry::Select(id) => {
                let mut step = trail_step(self.graph, self.graph.select(id), &self.env(state), origin);
                self.keep_known(id, &mut step.values);
                step
            }
            Entry::System(id) => TrailStep { name: self.graph.system(id).name.clone(), values: Vec::new(), origin },
        }
    }

    /// Of what is told of a module, in order, keeps what a state knows.
    fn keep_known(&self, id: SelectId, values: &mut Vec<(String, Value)>) {
        let live = &self.liveness.select(id).slots;
        let mut slots = self.graph.select(id).told().into_iter();
        values.retain(|_| slots.next().is_some_and(|it| live.contains(&it)));
    }

    /// A fault that tells no value of what nothing below reads: a state does not know it.
    fn without_unknown(&self, id: SelectId, mut fault: Fault) -> Fault {
        if let FaultKind::NoRule { values, .. } = &mut fault.kind {
            self.keep_known(id, values);
        }
        fault
    }

    /// A machine for this scene.
    pub(super) fn machine(&self) -> Machine<'s> {
        Machine::new(self.graph.functions(), self.seed, &self.limits)
    }

    /// What a node is if it is the same everywhere.
    pub(super) fn fixed(&self, node: NodeId) -> &Fixed {
        self.fixed.of_node(node)
    }

    /// The slots that states of an entry have values of.
    pub(crate) fn live_slots(&self, entry: Entry) -> &[Slot] {
        &self.live(entry).slots
    }

    /// What states of an entry know.
    pub(super) fn live(&self, entry: Entry) -> &Live {
        match entry {
            Entry::Select(id) => self.liveness.select(id),
            Entry::System(id) => self.liveness.system(id),
        }
    }

    /// The state of an environment at an entry: what is not live is forgotten.
    pub(super) fn state(&self, entry: Entry, env: &Env) -> State {
        let live = self.live(entry);
        let slots = live.slots.iter().map(|it| env.slots[usize::from(it.0)].clone()).collect();
        State { entry, slots, path: live.path.then_some(env.path), hide: None }
    }

    /// A state of an entry with these values of its live slots, on a path made up if anything below it draws.
    pub(crate) fn likeness_of(&self, entry: Entry, slots: Box<[Value]>) -> State {
        State { entry, slots, path: self.live(entry).path.then(|| Path::made_up(0)), hide: None }
    }

    /// An environment of a state: what is not live is 0.
    pub(crate) fn env(&self, state: &State) -> Env {
        let system = match state.entry {
            Entry::Select(id) => self.graph.select(id).system,
            Entry::System(id) => id,
        };
        let mut slots = vec![Value::Number(0.0); self.graph.system(system).slots.len()];
        for (slot, value) in self.live(state.entry).slots.iter().zip(&state.slots) {
            slots[usize::from(slot.0)] = value.clone();
        }
        Env { slots, path: state.path.unwrap_or_default(), turn: 0 }
    }
}

fn fixed(graph: &Graph, constant: &Constant) -> Fixed {
    match constant {
        Constant::Transform(kind, numbers) => {
            let map = matrix(*kind, numbers).filter(|it| it.is_finite() && it.inverse().is_finite());
            map.map_or(Fixed::No, Fixed::Matrix)
        }
        Constant::Primitive(kind, numbers) => graph.primitive(*kind, numbers).map_or(Fixed::No, Fixed::Primitive),
    }
}

//! The walk from a scene to its primitives.
//!
//! It goes through the graph as GT95's derivation does: S-nodes select, C-nodes assign, T-nodes multiply their matrix to the chain.
//! What is still to be done lies on a stack of its own, where an operator or a `repeat` takes one entry however many operands or
//! copies it has left. So the walk needs room for the nesting of the rules, which has a limit, and none for what it has passed.

use glam::DAffine3;
use smallvec::SmallVec;

use super::piece::{Boolean, Piece, Placed};
use crate::derive;
use crate::eval::{Env, Machine, trail_step};
use crate::fault::{Fault, FaultKind, Limit, TrailStep};
use crate::form::{
    Graph, MaterialId, Node, NodeId, Origin, PrimitiveKind, Scene, SelectId, ShapeId, Slot, SystemId, Value,
};
use crate::geometry::Part;
use crate::limits::Limits;
use crate::picture::Watch;
use crate::trace::{CHOICE, COPY, OPERAND, Route, shapes};

/// All pieces of a scene, in the order written.
///
/// After a fault there are none.
pub struct Pieces<'s> {
    graph: &'s Graph,
    machine: Machine<'s>,
    limits: Limits,
    /// What is to be done, the next last.
    tasks: Vec<Task<'s>>,
    /// How many modules and systems it is inside.
    depth: u32,
    /// About how many bytes the values of all these take.
    bytes: usize,
    /// How many more primitives there may be.
    left: u64,
    /// How many there were.
    primitives: u64,
    watch: &'s dyn Watch,
    /// How much was done since the watch was asked.
    unwatched: u32,
}

/// Bytes that the values of all modules and systems take at most that it is inside: where each has thousands, fewer may be inside one another.
const MOST_BYTES: usize = 256 << 20;
/// Copies of a module's values: for the trail of a fault, and for what is still to be done on both sides of it.
const COPIES: usize = 3;

/// So much is done before the watch is asked again.
const WATCHED: u32 = 1024;

/// Something to be done.
#[derive(Debug)]
enum Task<'s> {
    /// Go to a node.
    Go(NodeId, Here),
    /// Go to the operands of a union from this number on.
    Union { operands: &'s [NodeId], next: usize, here: Here },
    /// Go to the copies of a `repeat` from this number on.
    Copies { body: NodeId, index: Slot, count: u32, next: u32, here: Here },
    /// Go to the operands of a Boolean from this number on.
    Operands { operands: Operands<'s>, next: usize, here: Here },
    /// An operand of a Boolean ends.
    EndOperand,
    /// A Boolean ends.
    End,
    /// A module or system ends.
    Leave(Entered),
    /// A primitive to be told, and its place in the text.
    Tell(Box<Placed>, Origin),
}

/// The operands of a Boolean.
#[derive(Clone, Copy, Debug)]
struct Operands<'s> {
    first: Option<NodeId>,
    others: &'s [NodeId],
}

impl Operands<'_> {
    fn get(self, number: usize) -> Option<NodeId> {
        match (self.first, number) {
            (None, _) => self.others.get(number).copied(),
            (Some(first), 0) => Some(first),
            (Some(_), _) => self.others.get(number - 1).copied(),
        }
    }
}

/// What was entered, for the trail of a fault.
#[derive(Debug)]
enum Entered {
    Module(SelectId, Env, Origin),
    System(SystemId, Origin),
}

/// Where a walk is, and what it brings along.
#[derive(Clone, Debug)]
struct Here {
    world_from_here: DAffine3,
    material: Option<MaterialId>,
    route: Route,
    /// Whether it is inside a Boolean: the whole is one solid, and its route has ended.
    inside: bool,
    env: Env,
}

impl Here {
    fn step(&mut self, number: u64) {
        if !self.inside {
            self.route = self.route.then(Route::step(number));
        }
    }

    fn place(&self, kind: PrimitiveKind, parameters: SmallVec<[f64; 12]>) -> Placed {
        let Self { world_from_here: world_from_primitive, material, route, .. } = *self;
        Placed { kind, parameters, world_from_primitive, material, route: route.hash() }
    }
}

/// Takes the parts of a shape, as things to be done.
struct Parts<'h, 's> {
    here: &'h Here,
    tasks: Vec<Task<'s>>,
}

impl Parts<'_, '_> {
    fn here(&self, system_from_part: &DAffine3, material: Option<MaterialId>, route: Route, env: Env) -> Here {
        let Here { world_from_here, material: outer, inside, .. } = *self.here;
        let route = if inside { self.here.route } else { self.here.route.then(route) };
        Here { world_from_here: world_from_here * *system_from_part, material: material.or(outer), route, inside, env }
    }
}

impl shapes::Taker for Parts<'_, '_> {
    fn placed(&mut self, placed: derive::Placed<'_>) -> Result<(), Fault> {
        let (system_from_frame, route) = shapes::way(&placed);
        let here = self.here(&system_from_frame, placed.material, route, placed.env.clone());
        self.tasks.push(Task::Go(placed.solid, here));
        Ok(())
    }

    fn part(&mut self, part: Part, route: Route) -> Result<(), Fault> {
        let here = self.here(&part.stem_from_part, part.material, route, Env::default());
        let parameters: &[f64] = part.parameters.as_ref().map_or(&[], |it| it);
        let placed = here.place(part.primitive.kind(), parameters.into());
        self.tasks.push(Task::Tell(Box::new(placed), part.origin));
        Ok(())
    }

    fn hull(&mut self, hull: shapes::Hull) -> Result<(), Fault> {
        let here = self.here(&DAffine3::IDENTITY, hull.material, Route::START, Env::default());
        let placed = here.place(PrimitiveKind::Hull, hull.parameters.into());
        self.tasks.push(Task::Tell(Box::new(placed), hull.origin));
        Ok(())
    }
}

impl<'s> Pieces<'s> {
    /// The pieces of a scene, until the watch wishes to stop.
    ///
    /// # Errors
    /// What fails in finding the scene's own values.
    pub fn of(scene: &'s Scene, limits: &Limits, watch: &'s dyn Watch) -> Result<Self, Fault> {
        let graph = &scene.graph;
        let mut machine = Machine::new(graph.functions(), scene.seed, limits);
        let env = machine.root(graph)?;
        let here =
            Here { world_from_here: DAffine3::IDENTITY, material: None, route: Route::START, inside: false, env };
        let tasks = vec![Task::Go(graph.system(graph.root()).start, here)];
        let (left, primitives, unwatched) = (limits.primitives, 0, 0);
        Ok(Self { graph, machine, limits: *limits, tasks, depth: 0, bytes: 0, left, primitives, watch, unwatched })
    }

    /// How many primitives there were so far.
    pub fn primitives(&self) -> u64 {
        self.primitives
    }

    /// Does what is to be done next; gives the piece that is found on the way.
    fn work(&mut self, task: Task<'s>) -> Result<Option<Piece>, Fault> {
        self.unwatched += 1;
        if self.unwatched >= WATCHED {
            self.unwatched = 0;
            if self.watch.interrupted() {
                return Err(Fault::new(FaultKind::Interrupted, Origin::NONE));
            }
        }
        match task {
            Task::Go(node, here) => return self.go(node, here),
            Task::Union { operands, next, here } => self.union(operands, next, here),
            Task::Copies { body, index, count, next, here } => {
                let mut copy = here.clone();
                copy.env.turn(index, next);
                copy.step(COPY ^ u64::from(next));
                if next + 1 < count {
                    self.tasks.push(Task::Copies { body, index, count, next: next + 1, here });
                }
                self.tasks.push(Task::Go(body, copy));
            }
            Task::Operands { operands, next, here } => {
                let Some(operand) = operands.get(next) else { return Ok(None) };
                self.tasks.push(Task::Operands { operands, next: next + 1, here: here.clone() });
                self.tasks.push(Task::EndOperand);
                self.tasks.push(Task::Go(operand, here));
                return Ok(Some(Piece::BeginOperand));
            }
            Task::EndOperand => return Ok(Some(Piece::EndOperand)),
            Task::End => return Ok(Some(Piece::End)),
            Task::Leave(entered) => {
                self.depth -= 1;
                self.bytes -= entered.bytes(self.graph);
            }
            Task::Tell(placed, origin) => {
                self.count(origin)?;
                self.primitives += 1;
                return Ok(Some(Piece::Primitive(*placed)));
            }
        }
        Ok(None)
    }

    /// Goes down from a node until it finds a piece, or something to be done in more than one step.
    fn go(&mut self, node: NodeId, mut here: Here) -> Result<Option<Piece>, Fault> {
        let graph = self.graph;
        let mut node = node;
        loop {
            match graph.node(node) {
                Node::Empty => {
                    self.count(Origin::NONE)?;
                    return Ok(None);
                }
                Node::Primitive { kind, code, origin } => {
                    self.count(*origin)?;
                    let parameters = self.machine.primitive(*kind, code, &mut here.env)?;
                    let placed = here.place(*kind, parameters);
                    placed.check(self.graph, *origin, here.inside)?;
                    self.primitives += 1;
                    return Ok(Some(Piece::Primitive(placed)));
                }
                Node::Transform { kind, code, body, origin } => {
                    here.world_from_here *= self.machine.transform(*kind, code, &mut here.env, *origin)?;
                    node = *body;
                }
                Node::Calc { code, body, .. } => {
                    self.machine.calculate(code, &mut here.env)?;
                    node = *body;
                }
                Node::Paint { material, body } => {
                    here.material = Some(*material);
                    node = *body;
                }
                Node::Variant { count, body, origin } => {
                    let count = self.machine.whole(count, &mut here.env, "variant", 1, *origin)?;
                    here.env.fold(count);
                    node = *body;
                }
                Node::Choice { condition, then, otherwise } => {
                    node = if self.machine.truth(condition, &mut here.env)? { *then } else { *otherwise };
                }
                Node::Repeat { count, index, body, origin } => {
                    let count = self.machine.whole(count, &mut here.env, "repeat", 0, *origin)?;
                    if count > 0 {
                        self.tasks.push(Task::Copies { body: *body, index: *index, count, next: 0, here });
                    } else {
                        self.count(*origin)?;
                    }
                    return Ok(None);
                }
                Node::Union(operands) => {
                    self.union(operands, 0, here);
                    return Ok(None);
                }
                Node::Intersect(operands) => {
                    let operands = Operands { first: None, others: operands };
                    return Ok(Some(self.boolean(Boolean::Intersection, operands, here)));
                }
                Node::Difference(first, others) => {
                    let operands = Operands { first: Some(*first), others };
                    return Ok(Some(self.boolean(Boolean::Difference, operands, here)));
                }
                Node::Call(call) => {
                    here.env = self.machine.enter(graph, call, &mut here.env)?;
                    here.step(call.place);
                    self.enter(Entered::Module(call.select, here.env.clone(), call.origin), call.origin)?;
                    let select = graph.select(call.select);
                    let chosen = self.machine.choose(graph, select, &mut here.env)?;
                    here.step(CHOICE ^ chosen as u64);
                    node = select.rules[chosen].body;
                }
                Node::System(call) => {
                    here.env = self.machine.enter_system(graph, call, &mut here.env)?;
                    here.step(call.place);
                    self.enter(Entered::System(call.system, call.origin), call.origin)?;
                    node = graph.system(call.system).start;
                }
                Node::Shape(shape) => {
                    self.derive(*shape, &here)?;
                    return Ok(None);
                }
            }
        }
    }

    /// Derives a shape; its parts are told one after the other.
    fn derive(&mut self, shape: ShapeId, here: &Here) -> Result<(), Fault> {
        let mut parts = Parts { here, tasks: Vec::new() };
        shapes::parts(self.graph, shape, &here.env, self.machine.seed(), &self.limits, &mut parts)?;
        self.tasks.extend(parts.tasks.into_iter().rev());
        Ok(())
    }

    fn union(&mut self, operands: &'s [NodeId], next: usize, here: Here) {
        let Some(operand) = operands.get(next) else { return };
        let mut copy = here.clone();
        copy.step(OPERAND ^ next as u64);
        self.tasks.push(Task::Union { operands, next: next + 1, here });
        self.tasks.push(Task::Go(*operand, copy));
    }

    fn boolean(&mut self, boolean: Boolean, operands: Operands<'s>, mut here: Here) -> Piece {
        here.inside = true;
        self.tasks.push(Task::End);
        self.tasks.push(Task::Operands { operands, next: 0, here });
        Piece::Begin(boolean)
    }

    fn enter(&mut self, entered: Entered, origin: Origin) -> Result<(), Fault> {
        self.bytes += entered.bytes(self.graph);
        self.tasks.push(Task::Leave(entered));
        self.depth += 1;
        if self.depth > self.limits.depth || self.bytes > MOST_BYTES {
            let most = u64::from(self.depth - 1);
            return Err(Fault::new(FaultKind::Limit { limit: Limit::Depth, most }, origin));
        }
        Ok(())
    }

    /// Counts a primitive, or a place where there is none: every branch of the walk ends at one or the other, so this bounds it.
    fn count(&mut self, origin: Origin) -> Result<(), Fault> {
        self.left = self.left.checked_sub(1).ok_or_else(|| self.too_many(origin))?;
        Ok(())
    }

    /// The fault of one primitive too many: at the innermost call, since it is its rule that made them grow.
    fn too_many(&self, origin: Origin) -> Fault {
        let entered =
            self.tasks.iter().rev().find_map(|it| if let Task::Leave(it) = it { Some(it.origin()) } else { None });
        let kind = FaultKind::Limit { limit: Limit::Primitives, most: self.limits.primitives };
        Fault::new(kind, entered.unwrap_or(origin))
    }

    /// The fault with the way to it, and nothing more to be done.
    fn told(&mut self, fault: Fault) -> Fault {
        let mut fault = fault;
        for task in std::mem::take(&mut self.tasks).into_iter().rev() {
            if let Task::Leave(entered) = task {
                fault = fault.reached_through(entered.step(self.graph));
            }
        }
        fault
    }
}

impl Iterator for Pieces<'_> {
    type Item = Result<Piece, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let task = self.tasks.pop()?;
            match self.work(task) {
                Ok(None) => {}
                Ok(Some(piece)) => return Some(Ok(piece)),
                Err(fault) => return Some(Err(self.told(fault))),
            }
        }
    }
}

impl Entered {
    /// The place of the call.
    fn origin(&self) -> Origin {
        match self {
            Self::Module(_, _, origin) | Self::System(_, origin) => *origin,
        }
    }

    /// About how many bytes its values take.
    fn bytes(&self, graph: &Graph) -> usize {
        let slots = match self {
            Self::Module(_, env, _) => env.slots.len(),
            Self::System(system, _) => graph.system(*system).slots.len(),
        };
        COPIES * slots * size_of::<Value>()
    }

    fn step(self, graph: &Graph) -> TrailStep {
        match self {
            Self::Module(select, env, origin) => trail_step(graph, graph.select(select), &env, origin),
            Self::System(system, origin) => {
                TrailStep { name: graph.system(system).name.clone(), values: Vec::new(), origin }
            }
        }
    }
}

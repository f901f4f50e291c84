//! The derivation of shapes (B08, sections 3.2.2 and 3.2.3): rules are applied to modules until none applies. That of hulls (FG86,
//! section 2.1) differs in the order, in its end and in what is laid; see [`splitting`].
//!
//! In: a [`Shape`] of a graph and the environment of its system. Out: the [`SegmentList`] that was laid, or the [`Normal`]s, and,
//! through a [`Watcher`], the solids that were placed. The list of modules that wait is explicit, so a derivation takes no stack.
//!
//! What becomes of a module depends only on what it took along when it was laid down: its arguments, the state, the frame, the
//! paint and its path. So the order of the derivation decides nothing but where one that is stopped stands.

mod frame;
mod memo;
mod packed;
mod prepared;
mod queue;
mod record;
mod select;
mod splitting;
mod trail;
mod waiting;
mod walker;

pub use record::{Applied, Recorder};
pub use splitting::Normal;

use glam::DAffine3;

use self::frame::Frame;
use self::prepared::Prepared;
use self::splitting::Splits;
use self::trail::Ancestry;
use self::waiting::{Done, Ticket, Waiting};
use self::walker::Here;
use crate::eval::{Env, Machine};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{Choice, Graph, MaterialId, NodeId, Origin, SegmentList, Shape, ShapeId, Value, Walk};
use crate::geometry::Family;
use crate::limits::Limits;

/// Someone who is told what happens in a derivation besides segments.
pub trait Watcher {
    /// A solid was placed.
    ///
    /// # Errors
    /// A fault, which ends the derivation.
    fn placed(&mut self, placed: Placed<'_>) -> Result<(), Fault>;

    /// A rule was applied, or the start was walked. `values` gives the module's values by number: its parameters, then the state.
    fn applied(&mut self, shape: &Shape, step: &Step, values: &dyn Fn(usize) -> Value);

    /// A segment has no length, or no thickness at either end, and is not laid. This is its place in the text.
    fn skipped(&mut self, _origin: Origin) {}
}

/// Someone who takes no notice.
#[derive(Clone, Copy, Debug)]
pub struct Nobody;

impl Watcher for Nobody {
    fn placed(&mut self, _placed: Placed<'_>) -> Result<(), Fault> {
        Ok(())
    }

    fn applied(&mut self, _shape: &Shape, _step: &Step, _values: &dyn Fn(usize) -> Value) {}
}

/// A solid that a walk placed.
#[derive(Debug)]
pub struct Placed<'d> {
    /// The solid.
    pub solid: NodeId,
    /// The map from the frame of the walk to the system's space.
    pub system_from_frame: DAffine3,
    /// The paint of the walk.
    pub material: Option<MaterialId>,
    /// A hash of the rules, copies and brackets that led to it.
    pub route: u64,
    /// What its expressions see.
    pub env: &'d Env,
    /// Its place in the text.
    pub origin: Origin,
}

/// One step of a derivation: a rule that was applied, or the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The module's number in the order of being laid down; none for the start.
    pub number: Option<u32>,
    /// The numbers of the modules that it laid down.
    pub laid: std::ops::Range<u32>,
    /// How many segments it laid, or normals that do not split.
    pub segments: u32,
    /// How many solids it placed.
    pub solids: u32,
    /// The module and its rule, each by number in the shape; none for the start.
    pub rule: Option<(usize, usize)>,
}

/// Derives the shapes of a graph. It keeps its memory from one derivation to the next, so one for each thread is meant.
#[derive(Debug)]
pub struct Deriver<'g> {
    graph: &'g Graph,
    machine: Machine<'g>,
    waiting: Waiting,
    ancestry: Ancestry,
    /// How many segments and stems the last derivation left.
    left: [usize; 2],
    /// Strides and operations of the last derivation, and what its rules come to.
    work: u64,
}

/// Strides that a rule counts as: to lay modules down and to find whose turn it is.
const RULE: u64 = 16;

impl<'g> Deriver<'g> {
    /// A deriver for a graph, whose draws depend on the seed.
    pub fn new(graph: &'g Graph, seed: u64, limits: &Limits) -> Self {
        let machine = Machine::new(graph.functions(), seed, limits);
        Self { graph, machine, waiting: Waiting::default(), ancestry: Ancestry::default(), left: [0; 2], work: 0 }
    }

    /// How much work the last derivation was: its strides, the operations of its expressions, and its rules, of which each counts as some.
    pub(crate) fn work(&self) -> u64 {
        self.work
    }

    /// Derives a shape in the environment of its system.
    ///
    /// # Errors
    /// A fault in an expression, or a limit, with the modules that led there.
    pub fn derive(&mut self, shape: ShapeId, env: &Env, watcher: &mut impl Watcher) -> Result<SegmentList, Fault> {
        let list = self.run(shape, env, watcher)?.0;
        self.left = [list.len(), list.stems().len()];
        Ok(list)
    }

    /// Derives a hull in the environment of its system: the normals that are left. A shape has none.
    ///
    /// # Errors
    /// As [`Deriver::derive`].
    pub fn normals(&mut self, shape: ShapeId, env: &Env, watcher: &mut impl Watcher) -> Result<Vec<Normal>, Fault> {
        Ok(self.run(shape, env, watcher)?.1.map(|it| it.normals).unwrap_or_default())
    }

    /// The same with all planes of the derivation, those that were split too.
    pub(crate) fn normals_and_family(
        &mut self,
        shape: ShapeId,
        env: &Env,
        watcher: &mut impl Watcher,
    ) -> Result<(Vec<Normal>, Family), Fault> {
        let splits = self.run(shape, env, watcher)?.1;
        Ok(splits.map_or_else(Default::default, |it| {
            let family = it.family();
            (it.normals, family)
        }))
    }

    fn run(
        &mut self,
        shape: ShapeId,
        env: &Env,
        watcher: &mut impl Watcher,
    ) -> Result<(SegmentList, Option<Splits<'g>>), Fault> {
        let mut derivation = Derivation::new(self, shape, env, watcher);
        derivation.start()?;
        while let Some(ticket) = derivation.next()? {
            derivation.apply(ticket)?;
        }
        derivation.settle_all()?;
        let operations = derivation.machine.operations() - derivation.operations;
        let work = derivation.strides + RULE * derivation.rules + operations;
        let (list, splits) = (derivation.list, derivation.splits);
        self.work = work;
        Ok((list, splits))
    }
}

/// A derivation under way.
struct Derivation<'d, 'g, W> {
    graph: &'g Graph,
    shape: &'g Shape,
    prepared: Vec<Prepared>,
    machine: &'d mut Machine<'g>,
    env: Env,
    waiting: &'d mut Waiting,
    /// Modules laid down by the walk that is being taken; their rules are chosen when it is over.
    fresh: Vec<Ticket>,
    ancestry: &'d mut Ancestry,
    list: SegmentList,
    /// What a hull has besides.
    splits: Option<Splits<'g>>,
    watcher: &'d mut W,
    /// Arguments on their way into a module.
    args: Vec<Value>,
    /// Rules applied so far.
    rules: u64,
    /// Strides taken so far.
    strides: u64,
    /// Operations of the machine before.
    operations: u64,
    /// Copies that the walk may still make.
    copies: u32,
    /// Solids placed so far.
    solids: u32,
}

impl<'d, 'g, W: Watcher> Derivation<'d, 'g, W> {
    fn new(deriver: &'d mut Deriver<'g>, shape: ShapeId, env: &Env, watcher: &'d mut W) -> Self {
        let Deriver { graph, machine, waiting, ancestry, left, .. } = deriver;
        let shape = graph.shape(shape);
        let most_params = shape.modules.iter().map(|it| it.params.len()).max().unwrap_or(0);
        let priorities = prepared::priorities(shape);
        waiting.reset(most_params + shape.state.len(), priorities.len(), machine.limits().modules);
        ancestry.reset();
        let prepared = shape.modules.iter().map(|it| Prepared::new(it, shape, &priorities));
        Self {
            graph,
            shape,
            prepared: prepared.collect(),
            env: env.clone(),
            waiting,
            operations: machine.operations(),
            machine,
            fresh: Vec::new(),
            ancestry,
            // Derivations of one shape are much alike.
            list: SegmentList::with_room(left[0], left[1]),
            splits: None,
            watcher,
            args: vec![Value::Number(0.0); most_params],
            rules: 0,
            strides: 0,
            copies: 0,
            solids: 0,
        }
    }

    /// Walks the start.
    fn start(&mut self) -> Result<(), Fault> {
        let shape = self.shape;
        if let Some(rules) = &shape.splitting {
            self.begin_splits(rules)?;
        }
        let here = Here::new(Frame::START, None, None);
        let ground = Ground { number: None, route: 0, priority: 0, depth: 0 };
        self.step(&self.shape.start, ground, here, None)
    }

    /// The module that a rule is applied to next; `None` when the derivation is over.
    fn next(&mut self) -> Result<Option<Ticket>, Fault> {
        if self.graph.stops_after().is_some_and(|it| self.rules >= it) {
            return Ok(None);
        }
        let next = if self.splits.is_some() { self.next_split() } else { self.waiting.next() };
        let Some(ticket) = next else {
            return Ok(None);
        };
        let most = u64::from(self.machine.limits().rules);
        if self.rules >= most {
            let laid = self.waiting.get(ticket);
            let origin = self.shape.modules[laid.module.0 as usize].rules[laid.rule as usize].origin;
            return Err(self.led_to(ticket, limit(Limit::Rules, most, origin)));
        }
        self.rules += 1;
        Ok(Some(ticket))
    }

    /// Applies the rule of a module.
    fn apply(&mut self, ticket: Ticket) -> Result<(), Fault> {
        self.see(ticket);
        let laid = self.waiting.get(ticket);
        let (module, number) = (laid.module.0 as usize, laid.rule);
        let rule = &self.shape.modules[module].rules[number as usize];
        let ground = Ground {
            number: Some(laid.number),
            // Rules of one module lead to different stems, though they may be written alike.
            route: onwards(laid.route, u64::from(number)),
            priority: rule.priority,
            depth: laid.depth,
        };
        let here = Here::new(laid.frame.clone(), laid.material, laid.end);
        if !rule.appends {
            self.note_fork(ticket);
            self.count_replaced();
        }
        self.step(&rule.body, ground, here, Some((ticket, module, number as usize)))?;
        if rule.appends {
            self.leave(ticket, number);
            self.enlist(ticket)
        } else {
            self.waiting.forget(ticket);
            Ok(())
        }
    }

    /// Takes a walk, and chooses the rules of the modules that it laid down.
    fn step(
        &mut self,
        walk: &'g Walk,
        ground: Ground,
        mut here: Here,
        rule: Option<(Ticket, usize, usize)>,
    ) -> Result<(), Fault> {
        let (first, segments, solids) = (self.ancestry.count(), self.laid(), self.solids);
        self.copies = self.machine.limits().repeat;
        self.walk(walk, &ground, &mut here).map_err(|fault| match &rule {
            Some((ticket, ..)) => self.led_to(*ticket, fault),
            None => fault,
        })?;
        let laid = self.laid() - segments;
        for number in 0..self.fresh.len() {
            self.enlist(self.fresh[number])?;
        }
        self.fresh.clear();
        let step = Step {
            number: ground.number,
            laid: first..self.ancestry.count(),
            segments: laid as u32,
            solids: self.solids - solids,
            rule: rule.map(|it| (it.1, it.2)),
        };
        let values = |number: usize| rule.map_or(Value::Number(0.0), |it| self.waiting.value(it.0, number));
        self.watcher.applied(self.shape, &step, &values);
        Ok(())
    }

    /// How many segments, or normals that do not split, there are so far.
    fn laid(&self) -> usize {
        self.list.len() + self.splits.as_ref().map_or(0, |it| it.normals.len())
    }

    /// Lets a module wait for the rule that applies to it next; if none does it has stopped growing.
    fn enlist(&mut self, ticket: Ticket) -> Result<(), Fault> {
        let laid = self.waiting.get(ticket);
        let number = laid.module.0 as usize;
        let module = &self.shape.modules[number];
        // Most modules have one rule that always applies.
        let is_plain = module.rules.len() == 1 && module.rules[0].guard.is_none() && matches!(laid.done, Done::None);
        let chosen = if is_plain && module.choice == Choice::First {
            Some(0)
        } else {
            self.choose(ticket).map_err(|it| self.led_to(ticket, it))?
        };
        match chosen {
            Some(rule) if self.splits.is_some() => self.wait_for_split(ticket, rule),
            Some(rule) => self.waiting.wait(ticket, rule, self.prepared[number].ranks[rule as usize]),
            None => return self.settle(ticket),
        }
        Ok(())
    }

    /// Takes note that a rule was applied to a module and left it there.
    fn leave(&mut self, ticket: Ticket, rule: u32) {
        let laid = self.waiting.get_mut(ticket);
        let is_ordered = self.shape.modules[laid.module.0 as usize].choice == Choice::First;
        match &mut laid.done {
            Done::All(done) => done.push(rule),
            done if is_ordered => *done = Done::Last(rule),
            done => *done = Done::All(Box::new(vec![rule])),
        }
    }

    /// Makes expressions see what a module took along.
    fn see(&mut self, ticket: Ticket) {
        let laid = self.waiting.get(ticket);
        self.waiting.put_values(ticket, &self.prepared[laid.module.0 as usize].slots, &mut self.env.slots);
        self.env.path = laid.path;
        self.env.turn = 0;
    }
}

/// A hash of a route that goes on by a step.
fn onwards(route: u64, step: u64) -> u64 {
    (route ^ step).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
}

/// What holds for a whole walk.
#[derive(Clone, Copy, Debug)]
struct Ground {
    /// The number of the module whose rule it is.
    number: Option<u32>,
    route: u64,
    priority: i32,
    depth: u32,
}

fn limit(limit: Limit, most: u64, origin: Origin) -> Fault {
    Fault::new(FaultKind::Limit { limit, most }, origin)
}

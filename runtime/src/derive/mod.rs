//! The derivation of shapes (B08, sections 3.2.2 and 3.2.3): rules are applied to modules until none applies.
//!
//! In: a [`Shape`] of a graph and the environment of its system. Out: the [`SegmentList`] that was laid, and, through a
//! [`Watcher`], the solids that were placed. The list of modules that wait is explicit, so a derivation takes no stack.
//!
//! What becomes of a module depends only on what it took along when it was laid down: its arguments, the state, the frame, the
//! paint and its path. So the order of the derivation decides nothing but where one that is stopped stands.

mod frame;
mod record;
mod select;
mod trail;
mod waiting;
mod walker;

pub use record::{Applied, Recorder};

use glam::DAffine3;

use self::frame::Frame;
use self::trail::Ancestry;
use self::waiting::{Laid, Ticket, Waiting};
use self::walker::Here;
use crate::eval::{Env, Machine, mix};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{Choice, Graph, MaterialId, NodeId, Origin, SegmentList, Shape, ShapeId, Walk};
use crate::limits::Limits;

/// Someone who is told what happens in a derivation besides segments.
pub trait Watcher {
    /// A solid was placed.
    ///
    /// # Errors
    /// A fault, which ends the derivation.
    fn placed(&mut self, placed: Placed<'_>) -> Result<(), Fault>;

    /// A rule was applied, or the start was walked; it has numbers and values only for those who ask.
    fn applied(&mut self, step: Step<'_>);
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

/// One step of a derivation.
#[derive(Debug)]
pub struct Step<'d> {
    /// The shape.
    pub shape: &'d Shape,
    /// The module's number in the order of being laid down; none for the start.
    pub number: Option<u32>,
    /// The numbers of the modules that it laid down.
    pub laid: std::ops::Range<u32>,
    /// How many segments it laid.
    pub segments: u32,
    /// How many solids it placed.
    pub solids: u32,
    /// The module and its rule, each by number; none for the start.
    pub rule: Option<(usize, usize)>,
    /// The module's values: its parameters, then the state.
    pub values: &'d [crate::form::Value],
}

/// Derives a shape in the environment of its system.
///
/// # Errors
/// A fault in an expression, or a limit, with the modules that led there.
pub fn derive(
    graph: &Graph,
    shape: ShapeId,
    env: &Env,
    seed: u64,
    limits: &Limits,
    watcher: &mut impl Watcher,
) -> Result<SegmentList, Fault> {
    let machine = Machine::new(graph.functions(), seed, limits);
    let mut derivation = Derivation::new(graph, graph.shape(shape), env, machine, watcher);
    derivation.start()?;
    while let Some((ticket, laid)) = derivation.next()? {
        derivation.apply(ticket, laid)?;
    }
    Ok(derivation.list)
}

/// A derivation under way.
struct Derivation<'d, 'g, W> {
    graph: &'g Graph,
    shape: &'g Shape,
    /// For each module, its rules by priority.
    orders: Vec<Vec<usize>>,
    machine: Machine<'g>,
    env: Env,
    waiting: Waiting,
    /// Modules laid down by the walk that is being taken; their rules are chosen when it is over.
    fresh: Vec<Ticket>,
    ancestry: Ancestry,
    list: SegmentList,
    watcher: &'d mut W,
    /// Rules applied so far.
    rules: u64,
    /// Strides taken so far.
    strides: u64,
    /// Copies that the walk may still make.
    copies: u32,
    /// Solids placed so far.
    solids: u32,
}

impl<'d, 'g, W: Watcher> Derivation<'d, 'g, W> {
    fn new(graph: &'g Graph, shape: &'g Shape, env: &Env, machine: Machine<'g>, watcher: &'d mut W) -> Self {
        let most_params = shape.modules.iter().map(|it| it.params.len()).max().unwrap_or(0);
        let orders = shape.modules.iter().map(|module| {
            let mut order: Vec<usize> = (0..module.rules.len()).collect();
            order.sort_by_key(|it| module.rules[*it].priority);
            order
        });
        Self {
            graph,
            shape,
            orders: orders.collect(),
            env: env.clone(),
            waiting: Waiting::new(most_params + shape.state.len(), machine.limits().modules),
            machine,
            fresh: Vec::new(),
            ancestry: Ancestry::default(),
            list: SegmentList::default(),
            watcher,
            rules: 0,
            strides: 0,
            copies: 0,
            solids: 0,
        }
    }

    /// Walks the start.
    fn start(&mut self) -> Result<(), Fault> {
        let here = Here::new(Frame::START, None, None);
        let ground = Ground { number: None, route: 0, priority: 0, depth: 0 };
        self.step(&self.shape.start, ground, here, None)
    }

    /// The module that a rule is applied to next; `None` when the derivation is over.
    fn next(&mut self) -> Result<Option<(Ticket, Laid)>, Fault> {
        if self.graph.stops_after().is_some_and(|it| self.rules >= it) {
            return Ok(None);
        }
        let Some((ticket, laid)) = self.waiting.next() else {
            return Ok(None);
        };
        let most = self.machine.limits().rules;
        if self.rules >= u64::from(most) {
            let origin = self.shape.modules[laid.module.0 as usize].rules[laid.rule].origin;
            return Err(self.led_to(laid.number, ticket, limit(Limit::Rules, u64::from(most), origin)));
        }
        self.rules += 1;
        Ok(Some((ticket, laid)))
    }

    /// Applies the rule of a module.
    fn apply(&mut self, ticket: Ticket, mut laid: Laid) -> Result<(), Fault> {
        self.see(ticket, &laid);
        let rule = &self.shape.modules[laid.module.0 as usize].rules[laid.rule];
        let ground = Ground {
            number: Some(laid.number),
            // Rules of one module lead to different stems, though they may be written alike.
            route: mix(laid.route, laid.rule as u64),
            priority: rule.priority,
            depth: laid.depth,
        };
        let here = Here::new(laid.frame.clone(), laid.material, laid.end);
        self.step(&rule.body, ground, here, Some((ticket, laid.module.0 as usize, laid.rule)))?;
        if rule.appends {
            laid.done.push(laid.rule);
            self.enlist(ticket, laid)
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
        let (first, segments, solids) = (self.ancestry.count(), self.list.len(), self.solids);
        self.copies = self.machine.limits().repeat;
        if let Err(fault) = self.walk(walk, &ground, &mut here) {
            return Err(match (ground.number, &rule) {
                (Some(number), Some((ticket, ..))) => self.led_to(number, *ticket, fault),
                _ => fault,
            });
        }
        let fresh = std::mem::take(&mut self.fresh);
        for ticket in &fresh {
            if let Some(laid) = self.waiting.take(*ticket) {
                self.enlist(*ticket, laid)?;
            }
        }
        self.fresh = fresh;
        self.fresh.clear();
        self.watcher.applied(Step {
            shape: self.shape,
            number: ground.number,
            laid: first..self.ancestry.count(),
            segments: (self.list.len() - segments) as u32,
            solids: self.solids - solids,
            rule: rule.map(|it| (it.1, it.2)),
            values: rule.map_or(&[], |it| self.waiting.values(it.0)),
        });
        Ok(())
    }

    /// Lets a module wait for the rule that applies to it next; if none does it has stopped growing.
    fn enlist(&mut self, ticket: Ticket, mut laid: Laid) -> Result<(), Fault> {
        let module = &self.shape.modules[laid.module.0 as usize];
        // Most modules have one rule that always applies.
        let is_plain = module.rules.len() == 1 && module.rules[0].guard.is_none();
        let chosen = if is_plain && laid.done.is_empty() && !matches!(module.choice, Choice::Function(_)) {
            Some(0)
        } else {
            self.see(ticket, &laid);
            self.choose(&laid).map_err(|it| self.led_to(laid.number, ticket, it))?
        };
        match chosen {
            Some(rule) => {
                laid.rule = rule;
                self.waiting.put_back(ticket, laid, module.rules[rule].priority);
            }
            None => self.waiting.forget(ticket),
        }
        Ok(())
    }

    /// Makes expressions see what a module took along.
    fn see(&mut self, ticket: Ticket, laid: &Laid) {
        let params = &self.shape.modules[laid.module.0 as usize].params;
        let slots = params.iter().chain(&self.shape.state);
        for (slot, value) in slots.zip(self.waiting.values(ticket)) {
            self.env.slots[usize::from(slot.0)] = value.clone();
        }
        self.env.path = laid.path;
        self.env.turn = 0;
    }
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

//! The derivation of hulls (FG86, section 2.1): normals are split until there are enough.
//!
//! Every module stands for a normal as long as no rule has replaced it. Those that are left when the derivation ends are read as
//! normals whose length is their first parameter.

use std::collections::BTreeMap;

use glam::DVec3;

use super::frame::Frame;
use super::waiting::{Ticket, Waiting};
use super::walker::Here;
use super::{Derivation, Watcher, limit};
use crate::eval::{Formula, Path};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{MaterialId, Order, Origin, Splitting, Value};
use crate::geometry::{Family, Plane};

/// A normal of a hull: the vector from a point to the plane that it stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Normal {
    /// Where it begins, in the system's space.
    pub start: DVec3,
    /// Which way it leads: outwards, of length 1.
    pub direction: DVec3,
    /// How far: 0 or more.
    pub length: f64,
    /// Its paint.
    pub material: Option<MaterialId>,
    /// Its place in the text.
    pub origin: Origin,
}

impl Normal {
    /// The plane through its end, square to it: the hull lies behind. `None` if that is out of reach.
    pub fn plane(&self) -> Option<Plane> {
        Plane::new(self.direction, self.direction.dot(self.start) + self.length)
    }

    /// Whether direction and beginning lie in one octant (FG86, figure 3).
    pub fn is_outward(&self) -> bool {
        points_outward(self.direction, self.start)
    }
}

fn points_outward(direction: DVec3, start: DVec3) -> bool {
    (direction * start).cmpge(DVec3::ZERO).all()
}

/// The normal in a frame.
fn normal(frame: &Frame, length: f64, material: Option<MaterialId>, origin: Origin) -> Normal {
    Normal { start: frame.position, direction: frame.along(), length: length * frame.factor(), material, origin }
}

/// What a hull has under way besides what a shape has.
pub(super) struct Splits<'g> {
    rules: &'g Splitting,
    /// How many generations or splits there are to be.
    count: u64,
    /// How many splits there were.
    done: u64,
    /// What waits, by turn, but where the order is random.
    line: BTreeMap<(u64, u32), Ticket>,
    /// What waits where the order is random.
    lot: Vec<Ticket>,
    /// The path of the system, to which what is drawn for all belongs.
    path: Path,
    /// The moment of the split under way, where normals have lifetimes.
    now: f64,
    /// Modules that stand for normals.
    modules: u32,
    /// Normals that will not split.
    pub(super) normals: Vec<Normal>,
    /// For each of them the number of the module that laid it.
    parents: Vec<Option<u32>>,
    /// Modules that were replaced, by number: the one that laid each, and the normal that it stood for, if there is one.
    forks: BTreeMap<u32, (Option<u32>, Option<Normal>)>,
}

impl<'g> Splits<'g> {
    pub(super) fn new(rules: &'g Splitting, path: Path) -> Self {
        Self {
            rules,
            count: 0,
            done: 0,
            line: BTreeMap::new(),
            lot: Vec::new(),
            path,
            now: 0.0,
            modules: 0,
            normals: Vec::new(),
            parents: Vec::new(),
            forks: BTreeMap::new(),
        }
    }

    /// Takes out the module that splits next; `None` when there are enough splits. `draw` gives the number for a draw of all.
    fn next(&mut self, waiting: &Waiting, draw: impl FnOnce(u64, u64) -> f64) -> Option<Ticket> {
        if self.rules.order != Order::Parallel && self.done >= self.count {
            return None;
        }
        let next = match self.rules.order {
            Order::Random => {
                let which = (draw(self.done, self.rules.place) * self.lot.len() as f64) as usize;
                if self.lot.is_empty() { None } else { Some(self.lot.swap_remove(which.min(self.lot.len() - 1))) }
            }
            Order::Parallel => {
                let (_, ticket) = self.line.first_key_value()?;
                let generation = u64::from(waiting.get(*ticket).depth);
                if generation > self.count { None } else { self.line.pop_first().map(|it| it.1) }
            }
            Order::Oldest => self.line.pop_first().map(|it| it.1),
            Order::Lifetime => {
                let ((moment, _), ticket) = self.line.pop_first()?;
                self.now = f64::from_bits(moment);
                Some(ticket)
            }
        };
        self.done += u64::from(next.is_some());
        next
    }

    /// All planes, those that were split too.
    pub(super) fn family(&self) -> Family {
        let mut family = Family::default();
        let mut numbers: BTreeMap<u32, Option<u32>> = BTreeMap::new();
        let of = |numbers: &BTreeMap<u32, Option<u32>>, module: &Option<u32>| *numbers.get(module.as_ref()?)?;
        // Modules have greater numbers than those that laid them.
        for (module, (parent, normal)) in &self.forks {
            let parent = of(&numbers, parent);
            let number = normal.as_ref().and_then(Normal::plane).map(|it| family.add(it, parent));
            numbers.insert(*module, number.or(parent));
        }
        for (normal, parent) in self.normals.iter().zip(&self.parents) {
            if let Some(plane) = normal.plane() {
                let number = family.add(plane, of(&numbers, parent));
                family.last.push(number);
            }
        }
        family
    }

    /// Lets a module wait for its turn. `draw` gives the number for a draw of its own.
    fn wait(&mut self, ticket: Ticket, waiting: &Waiting, draw: impl FnOnce(u64) -> f64) {
        let laid = waiting.get(ticket);
        let turn = match self.rules.order {
            Order::Random => return self.lot.push(ticket),
            Order::Parallel => u64::from(laid.depth),
            Order::Oldest => 0,
            // The bits of numbers that are not negative are in the order of the numbers.
            Order::Lifetime => (self.now - libm::log(1.0 - draw(self.rules.place))).to_bits(),
        };
        self.line.insert((turn, laid.number), ticket);
    }
}

impl<'g, W: Watcher> Derivation<'_, 'g, W> {
    /// Finds how often normals are split.
    pub(super) fn begin_splits(&mut self, rules: &'g Splitting) -> Result<(), Fault> {
        let mut splits = Splits::new(rules, self.env.path);
        let mut count = [1.0];
        if let Some(code) = &rules.count {
            self.machine.read(code, &mut self.env, "derive", &mut count)?;
        }
        let [value] = count;
        if !(value >= 0.0 && value.fract() == 0.0) {
            return Err(Fault::new(FaultKind::Whole { what: "derive", value, least: 0.0 }, rules.origin));
        }
        splits.count = value as u64;
        self.splits = Some(splits);
        Ok(())
    }

    /// The module that splits next.
    pub(super) fn next_split(&mut self) -> Option<Ticket> {
        let (machine, env) = (&*self.machine, &mut self.env);
        let splits = self.splits.as_mut()?;
        (env.path, env.turn) = (splits.path, 0);
        splits.next(self.waiting, |number, place| machine.draw(env, number, place))
    }

    /// Lets a module wait until it is split.
    pub(super) fn wait_for_split(&mut self, ticket: Ticket, rule: u32) {
        self.waiting.get_mut(ticket).rule = rule;
        self.env.path = self.waiting.get(ticket).path;
        self.env.turn = 0;
        let (machine, env) = (&*self.machine, &self.env);
        if let Some(splits) = &mut self.splits {
            splits.wait(ticket, self.waiting, |place| machine.draw(env, 0, place));
        }
    }

    /// Takes note that a module is replaced, and of the normal that it stood for.
    pub(super) fn note_fork(&mut self, ticket: Ticket) {
        if self.splits.is_none() {
            return;
        }
        let laid = self.waiting.get(ticket);
        let has_length = !self.shape.modules[laid.module.0 as usize].params.is_empty();
        let length = match has_length.then(|| self.waiting.value(ticket, 0)) {
            Some(Value::Number(length)) if length >= 0.0 => Some(length),
            _ => None,
        };
        let normal = length.map(|it| normal(&laid.frame, it, laid.material, self.ancestry.origin(laid.number)));
        let parent = self.ancestry.parent(laid.number);
        if let Some(splits) = &mut self.splits {
            splits.forks.insert(laid.number, (parent, normal));
        }
    }

    /// A module has been replaced, or has become a normal.
    pub(super) fn count_replaced(&mut self) {
        if let Some(splits) = &mut self.splits {
            splits.modules = splits.modules.saturating_sub(1);
        }
    }

    /// Whether a module is to be laid down in this frame, and whether there is room.
    pub(super) fn may_lay_normal(&mut self, frame: &Frame, origin: Origin) -> Result<bool, Fault> {
        let most = self.machine.limits().planes;
        let Some(splits) = &mut self.splits else { return Ok(true) };
        if splits.rules.outward && !points_outward(frame.along(), frame.position) {
            return Ok(false);
        }
        if splits.modules as usize + splits.normals.len() >= most as usize {
            return Err(limit(Limit::Planes, u64::from(most), origin));
        }
        splits.modules += 1;
        Ok(true)
    }

    /// Lays a normal that does not split.
    pub(super) fn normal(
        &mut self,
        code: &Formula,
        origin: Origin,
        (here, parent): (&Here, Option<u32>),
    ) -> Result<(), Fault> {
        let mut length = [0.0];
        self.machine.read(code, &mut self.env, "normal", &mut length)?;
        if self.may_lay_normal(here.frame(), origin)? {
            self.push_normal(normal(here.frame(), length[0], here.material(), origin), length[0], parent)?;
        }
        Ok(())
    }

    fn push_normal(&mut self, normal: Normal, length: f64, parent: Option<u32>) -> Result<(), Fault> {
        if !(length >= 0.0 && normal.plane().is_some()) {
            return Err(Fault::new(FaultKind::Normal { length: Some(length) }, normal.origin));
        }
        self.count_replaced();
        if let Some(splits) = &mut self.splits {
            splits.normals.push(normal);
            splits.parents.push(parent);
        }
        Ok(())
    }

    /// A module to which no rule applies any more is a normal, in a hull.
    pub(super) fn settle(&mut self, ticket: Ticket) -> Result<(), Fault> {
        if self.splits.is_some() {
            let laid = self.waiting.get(ticket);
            let (origin, parent) = (self.ancestry.origin(laid.number), self.ancestry.parent(laid.number));
            let has_length = !self.shape.modules[laid.module.0 as usize].params.is_empty();
            let first = has_length.then(|| self.waiting.value(ticket, 0));
            let Some(Value::Number(length)) = first else {
                return Err(self.led_to(ticket, Fault::new(FaultKind::Normal { length: None }, origin)));
            };
            let normal = normal(&laid.frame, length, laid.material, origin);
            self.push_normal(normal, length, parent).map_err(|it| self.led_to(ticket, it))?;
        }
        self.waiting.forget(ticket);
        Ok(())
    }

    /// Makes normals of all modules that are left, in order.
    pub(super) fn settle_all(&mut self) -> Result<(), Fault> {
        let Some(splits) = &mut self.splits else { return Ok(()) };
        let mut left: Vec<Ticket> = std::mem::take(&mut splits.line).into_values().collect();
        left.append(&mut splits.lot);
        left.sort_by_key(|it| self.waiting.get(*it).number);
        left.into_iter().try_for_each(|it| self.settle(it))
    }
}

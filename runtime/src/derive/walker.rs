//! Walks, taken stride by stride.

use super::frame::Frame;
use super::waiting::{Done, Laid};
use super::{Derivation, Ground, Placed, Watcher, limit, onwards};
use crate::eval::{Formula, Path};
use crate::fault::{Fault, FaultKind, Limit};
use crate::form::{
    Bracket, MaterialId, ModuleId, Origin, Segment, Slot, StemEnd, StemStart, Stride, TransformKind, Value, Walk,
};

/// Where a walk is.
#[derive(Clone, Debug)]
pub(super) struct Here {
    frame: Frame,
    material: Option<MaterialId>,
    /// The end of the last segment laid between these brackets, or of the one that led here.
    end: Option<StemEnd>,
    /// Whether no module has been laid down there yet.
    is_free: bool,
}

impl Here {
    pub(super) fn new(frame: Frame, material: Option<MaterialId>, end: Option<StemEnd>) -> Self {
        Self { frame, material, end, is_free: true }
    }

    pub(super) fn frame(&self) -> &Frame {
        &self.frame
    }

    pub(super) fn material(&self) -> Option<MaterialId> {
        self.material
    }
}

impl<'g, W: Watcher> Derivation<'_, 'g, W> {
    /// Takes a walk.
    ///
    /// It calls itself for walks inside others, whose nesting the grammar limits.
    pub(super) fn walk(&mut self, walk: &'g Walk, ground: &Ground, here: &mut Here) -> Result<(), Fault> {
        for stride in &walk.strides {
            self.strides += 1;
            match stride {
                Stride::Transform { kind, code, origin } => self.transform(*kind, code, *origin, here)?,
                Stride::Toward { code, origin } => self.turn_toward(code, *origin, here)?,
                Stride::Calc(code) => self.machine.assign(code, &mut self.env)?,
                Stride::Paint(material) => here.material = Some(*material),
                Stride::Variant { count, origin } => {
                    let count = self.machine.count(count, &mut self.env, "variant", 1, *origin)?;
                    self.env.fold(count);
                }
                Stride::Segment { code, number, origin } => self.segment(code, *number, *origin, ground, here)?,
                Stride::Normal { code, origin } => {
                    sound(&here.frame, *origin)?;
                    self.normal(code, *origin, (here, ground.number))?;
                }
                Stride::Module { module, args, place, origin } => {
                    self.lay(*module, args, *place, *origin, ground, here)?;
                }
                Stride::Place { solid, number, origin } => {
                    sound(&here.frame, *origin)?;
                    self.solids += 1;
                    self.watcher.placed(Placed {
                        solid: *solid,
                        system_from_frame: here.frame.system_from_frame(),
                        material: here.material,
                        route: onwards(onwards(ground.route, self.env.turn), u64::from(*number)),
                        env: &self.env,
                        origin: *origin,
                    })?;
                }
                Stride::Bracket(bracket) => self.bracket(bracket, ground, here)?,
                Stride::Repeat { count, index, body, origin } => {
                    self.repeat(count, *index, body, *origin, ground, here)?;
                }
                Stride::Choice { condition, then, otherwise } => {
                    let truth = self.machine.holds(condition, &mut self.env)?;
                    self.walk(if truth { then } else { otherwise }, ground, here)?;
                }
            }
        }
        self.ask_for_strides(walk)
    }

    /// Sees to it that the derivation has not taken more strides than it may.
    fn ask_for_strides(&self, walk: &Walk) -> Result<(), Fault> {
        let most = self.machine.limits().strides;
        if self.strides + self.machine.operations() - self.operations <= most {
            return Ok(());
        }
        let origins = walk.strides.iter().filter_map(|it| it.code()).flat_map(|it| it.0.origins.first());
        Err(limit(Limit::Strides, most, origins.copied().next().unwrap_or(Origin::NONE)))
    }

    fn transform(&mut self, kind: TransformKind, code: &Formula, origin: Origin, here: &mut Here) -> Result<(), Fault> {
        let mut values = [0.0; 12];
        let count = self.machine.read(code, &mut self.env, kind.name(), &mut values)?;
        let values = &values[..count];
        if !here.frame.transform(kind, values) {
            return Err(Fault::new(FaultKind::Singular { kind, values: values.to_vec() }, origin));
        }
        Ok(())
    }

    fn turn_toward(&mut self, code: &Formula, origin: Origin, here: &mut Here) -> Result<(), Fault> {
        let mut values = [0.0; 4];
        self.machine.read(code, &mut self.env, "toward", &mut values)?;
        let [x, y, z, most] = values;
        if most >= 0.0 && here.frame.turn_toward(glam::DVec3::new(x, y, z), most) {
            Ok(())
        } else {
            Err(Fault::new(FaultKind::Toward { values: values.to_vec() }, origin))
        }
    }

    fn segment(
        &mut self,
        code: &Formula,
        number: u32,
        origin: Origin,
        ground: &Ground,
        here: &mut Here,
    ) -> Result<(), Fault> {
        let mut values = [0.0; 3];
        self.machine.read(code, &mut self.env, "segment", &mut values)?;
        let [length, r0, r1] = values;
        if !(length >= 0.0 && r0 >= 0.0 && r1 >= 0.0 && (length + r0 + r1).is_finite()) {
            return Err(Fault::new(FaultKind::Segment { values: values.to_vec() }, origin));
        }
        let start = here.frame.position;
        here.frame.advance(length);
        sound(&here.frame, origin)?;
        let factor = here.frame.factor();
        // What has no length or no surface cannot be seen.
        if here.frame.position == start || (r0 * factor == 0.0 && r1 * factor == 0.0) {
            self.watcher.skipped(origin);
            return Ok(());
        }
        let most = self.machine.limits().segments;
        if self.list.len() >= most as usize {
            return Err(limit(Limit::Segments, u64::from(most), origin));
        }
        let segment = Segment {
            start,
            end: here.frame.position,
            radii: [r0 * factor, r1 * factor],
            material: here.material,
            origin,
        };
        let begin = || StemStart {
            route: onwards(onwards(ground.route, self.env.turn), u64::from(number)),
            priority: ground.priority,
            depth: ground.depth,
            across: here.frame.across(),
        };
        here.end = Some(self.list.lay(here.end, segment, begin));
        here.is_free = true;
        Ok(())
    }

    /// Lays a module down.
    fn lay(
        &mut self,
        module: ModuleId,
        args: &Formula,
        place: u64,
        origin: Origin,
        ground: &Ground,
        here: &mut Here,
    ) -> Result<(), Fault> {
        sound(&here.frame, origin)?;
        self.machine.find(args, &mut self.env, &mut self.args)?;
        if !self.may_lay_normal(&here.frame, origin)? {
            return Ok(());
        }
        let end = here.end.filter(|it| here.is_free && self.list.is_open(*it, here.frame.position));
        here.is_free &= end.is_none();
        let turn = self.env.turn;
        let laid = Laid {
            frame: here.frame.clone(),
            path: self.env.path.joined(place, turn),
            route: onwards(onwards(ground.route, turn), place),
            material: here.material,
            end,
            module,
            number: self.ancestry.add(ground.number, module, origin),
            depth: ground.depth + 1,
            rule: 0,
            done: Done::None,
        };
        let args = &self.args[..args.code().results.len()];
        let state = self.shape.state.iter().map(|it| &self.env.slots[usize::from(it.0)]);
        let Some(ticket) = self.waiting.add(laid, args.iter().chain(state)) else {
            return Err(limit(Limit::Modules, self.waiting.most() as u64, origin));
        };
        self.fresh.push(ticket);
        Ok(())
    }

    fn bracket(&mut self, bracket: &'g Bracket, ground: &Ground, here: &Here) -> Result<(), Fault> {
        let (path, turn): (Path, u64) = (self.env.path, self.env.turn);
        let state = self.state(bracket.assigned());
        // What is laid between brackets carries on nothing outside.
        let mut inner = Here { end: None, is_free: true, frame: here.frame.clone(), material: here.material };
        self.walk(bracket.walk(), ground, &mut inner)?;
        for (slot, value) in bracket.assigned().iter().zip(state) {
            self.env.slots[usize::from(slot.0)] = value;
        }
        (self.env.path, self.env.turn) = (path, turn);
        Ok(())
    }

    /// The values of some slots.
    #[inline]
    fn state(&self, slots: &[Slot]) -> Vec<Value> {
        if slots.is_empty() {
            return Vec::new();
        }
        slots.iter().map(|it| self.env.slots[usize::from(it.0)].clone()).collect()
    }

    fn repeat(
        &mut self,
        count: &Formula,
        index: Slot,
        body: &'g Walk,
        origin: Origin,
        ground: &Ground,
        here: &mut Here,
    ) -> Result<(), Fault> {
        let count = self.machine.count(count, &mut self.env, "repeat", 0, origin)?;
        self.copies = self
            .copies
            .checked_sub(count)
            .ok_or_else(|| limit(Limit::Repeat, u64::from(self.machine.limits().repeat), origin))?;
        let turn = self.env.turn;
        for number in 0..count {
            self.strides += 1;
            self.env.turn = turn;
            self.env.turn(index, number);
            self.walk(body, ground, here)?;
        }
        self.env.turn = turn;
        Ok(())
    }
}

/// Sees to it that a frame can be computed with.
fn sound(frame: &Frame, origin: Origin) -> Result<(), Fault> {
    if frame.is_sound() { Ok(()) } else { Err(Fault::new(FaultKind::Frame, origin)) }
}

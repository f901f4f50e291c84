//! The laws of a [`Shape`], checked when the [`Graph`] it belongs to is made.

use super::graph::{Graph, GraphError};
use super::walk::{Module, Shape, Splitting, Stride, WalkRule};
use super::{Choice, Code, Origin, Slot, System};

impl Graph {
    /// Looks whether the parts of a shape fit together, and whether the slots it names are there.
    pub(super) fn check_shape(&self, shape: &Shape) -> Result<(), GraphError> {
        self.check_system_id(shape.system, Origin::NONE)?;
        let system = self.system(shape.system);
        check_slots(&shape.state, system, system.origin)?;
        shape.modules.iter().try_for_each(|it| self.check_module(it, system))?;
        if let Some(Splitting { count: Some(count), origin, .. }) = &shape.splitting {
            self.check_walk_code(count.code(), Some(1), system, *origin)?;
        }
        let mut result = Ok(());
        for walk in shape.walks() {
            walk.visit(&mut |stride| {
                if result.is_ok() {
                    result = self.check_stride(stride, shape, system);
                }
            });
        }
        result
    }

    fn check_module(&self, module: &Module, system: &System) -> Result<(), GraphError> {
        check_slots(&module.params, system, module.origin)?;
        if let Choice::Function(code) = &module.choice {
            self.check_walk_code(code, Some(1), system, module.origin)?;
        }
        for WalkRule { guard, weight, origin, .. } in &module.rules {
            guard.iter().chain(weight).try_for_each(|it| self.check_walk_code(it.code(), Some(1), system, *origin))?;
        }
        Ok(())
    }

    fn check_stride(&self, stride: &Stride, shape: &Shape, system: &System) -> Result<(), GraphError> {
        if let Some((code, results)) = stride.code() {
            let origin = code.origins.last().copied().unwrap_or(Origin::NONE);
            self.check_walk_code(code, results, system, origin)?;
        }
        match stride {
            Stride::Module { module, args, origin, .. } => match shape.modules.get(module.0 as usize) {
                Some(module) if module.params.len() == args.code().results.len() => Ok(()),
                Some(_) => Err(GraphError::Results(*origin)),
                None => Err(GraphError::Missing(*origin)),
            },
            Stride::Place { solid, origin, .. } if solid.0 as usize >= self.nodes().len() => {
                Err(GraphError::Missing(*origin))
            }
            Stride::Repeat { index, origin, .. } => check_slots(&[*index], system, *origin),
            Stride::Bracket(bracket) => check_slots(bracket.assigned(), system, Origin::NONE),
            _ => Ok(()),
        }
    }

    fn check_walk_code(
        &self,
        code: &Code,
        results: Option<usize>,
        system: &System,
        origin: Origin,
    ) -> Result<(), GraphError> {
        self.check_code(code, results, 0, origin)?;
        let slots: Vec<Slot> = code.stores().collect();
        check_slots(&slots, system, origin)
    }
}

fn check_slots(slots: &[Slot], system: &System, origin: Origin) -> Result<(), GraphError> {
    let there = |it: &Slot| usize::from(it.0) < system.slots.len();
    if slots.iter().all(there) { Ok(()) } else { Err(GraphError::Missing(origin)) }
}

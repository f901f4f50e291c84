//! Boxes of states, for whoever wants to look at them: tests, and measures of a scene.

use glam::{DAffine3, DVec3};

use super::store::Store;
use super::workshop::Workshop;
use crate::fault::Fault;
use crate::form::Scene;
use crate::geometry::Aabb;
use crate::limits::Limits;
use crate::trace::State;

/// Finds boxes of the states of a scene.
///
/// ```no_run
/// # fn look(scene: &treegen_runtime::form::Scene) -> Result<(), treegen_runtime::Fault> {
/// use treegen_runtime::{Limits, trace::cells::Boxes};
/// let boxes = Boxes::new(scene, &Limits::default())?;
/// let bounds = boxes.exact(&boxes.root())?;
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct Boxes<'s>(Store<'s>);

impl<'s> Boxes<'s> {
    /// # Errors
    /// What fails in finding the scene's own values.
    pub fn new(scene: &'s Scene, limits: &Limits) -> Result<Self, Fault> {
        Store::new(scene, limits).map(Self)
    }

    /// The state of the whole scene.
    pub fn root(&self) -> State {
        State::clone(self.0.root())
    }

    /// A box that holds all that a state stands for, whatever is drawn below it: quick to find, and perhaps several
    /// times too large.
    ///
    /// # Errors
    /// A cycle without bounds below the state, or states too deep inside one another.
    pub fn loose(&self, state: &State) -> Result<Aabb, Fault> {
        self.at(state, |shop, number| shop.loose(number).map(|it| it.bounds))
    }

    /// At least the greatest `direction · p` of all points p that a state stands for, whatever is drawn below it.
    ///
    /// # Errors
    /// As [`Boxes::loose`].
    pub fn reach(&self, state: &State, direction: DVec3) -> Result<f64, Fault> {
        self.at(state, |shop, number| shop.reach(number, direction))
    }

    /// The box that a cell has for a state in it: never too small, and seldom much larger than need be.
    ///
    /// # Errors
    /// As [`Boxes::loose`], and what fails in expanding what is below the state.
    pub fn exact(&self, state: &State) -> Result<Aabb, Fault> {
        self.at(state, |shop, number| {
            let slack = 1e-4 * shop.frame(number)?.size;
            shop.state_bounds(number, &DAffine3::IDENTITY, slack)
        })
    }

    fn at<T>(
        &self,
        state: &State,
        find: impl FnOnce(&mut Workshop<'_, 's>, u32) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let mut shop = self.0.workshop();
        let number = shop.number(state.clone());
        find(&mut shop, number)
    }
}

//! Stages: one picture of a scene after the other, drawn by scan conversion.
//!
//! **Law.** A picture is the same whatever was drawn before it. A stage keeps what does not depend on where the scene is seen from, or what
//! is as it was in the picture before: textures, maps of shadows whose texels are as large as they were, and the room in which all
//! this is worked on.

use std::sync::{Arc, Mutex};

use super::job::{self, Order, Sight};
use super::paint::Paints;
use super::tile::Desk;
use super::view::View;
use super::{Picture, RenderOptions, Watch};
use crate::fault::Fault;
use crate::form::{Camera, Scene};
use crate::scan::{Scanner, Shadows};

/// Draws one picture of a scene after the other.
#[derive(Debug)]
pub struct Stage<'s> {
    scene: &'s Scene,
    scanner: &'s Scanner,
    paints: Arc<Paints>,
    shadows: Option<Shadows>,
    desks: Mutex<Vec<Desk>>,
    picture: Option<Picture>,
}

impl<'s> Stage<'s> {
    /// A stage for a scene, which this scanner was made for.
    pub fn new(scene: &'s Scene, scanner: &'s Scanner) -> Self {
        Self {
            scene,
            scanner,
            paints: Arc::new(Paints::new(scene)),
            shadows: None,
            desks: Mutex::default(),
            picture: None,
        }
    }

    /// Draws a picture, on the threads of the rayon pool it is called in. It stands until the next one is drawn.
    ///
    /// # Errors
    /// Sizes beyond the limits, something that is nowhere, or the watch's wish to stop.
    pub fn draw(&mut self, camera: &Camera, options: &RenderOptions, watch: &dyn Watch) -> Result<&Picture, Fault> {
        let view = View::new(self.scene, options)?;
        let sight = Sight::new(self.scene, &view, camera);
        let seen = (&sight.projection(), f64::from(view.width) * f64::from(view.height));
        let shadows = Shadows::new(self.scanner, &sight.suns(), seen, self.shadows.take(), watch);
        let order = Order {
            scene: self.scene,
            view: &view,
            sight,
            paints: Arc::clone(&self.paints),
            tracer: &shadows,
            scanner: Some((self.scanner, &shadows)),
            desks: &self.desks,
            picture: self.picture.take(),
        };
        let picture = job::render(order, watch);
        self.shadows = Some(shadows);
        Ok(self.picture.insert(picture?))
    }

    /// The picture that was drawn last.
    pub(super) fn take(mut self) -> Option<Picture> {
        self.picture.take()
    }
}

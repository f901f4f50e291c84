//! What shading asks about the rest of the scene when a picture is drawn.

use crate::fault::Fault;
use crate::geometry::Aabb;
use crate::trace::{Beam, RayFault, Seen, SurfaceBeam, Tracer};

/// Light comes everywhere, and mirrors show the sky.
#[derive(Debug)]
pub(crate) struct Unshadowed;

impl Tracer for Unshadowed {
    fn look(&self, beams: &[Beam], seen: &mut Seen) -> Result<(), RayFault> {
        see_nothing(beams.len(), seen);
        Ok(())
    }

    fn look_from(&self, beams: &[SurfaceBeam], seen: &mut Seen) -> Result<(), RayFault> {
        see_nothing(beams.len(), seen);
        Ok(())
    }

    fn light(&self, beams: &[SurfaceBeam], light: &mut Vec<f64>) -> Result<(), RayFault> {
        light.clear();
        light.resize(beams.len(), 1.0);
        Ok(())
    }

    fn work(&self, beams: &[Beam], work: &mut Vec<u32>) -> Result<(), RayFault> {
        work.clear();
        work.resize(beams.len(), 0);
        Ok(())
    }

    fn finite_bounds(&self) -> Result<Aabb, Fault> {
        Ok(Aabb::EMPTY)
    }
}

fn see_nothing(rays: usize, seen: &mut Seen) {
    seen.clear();
    for _ in 0..rays {
        seen.end_ray();
    }
}

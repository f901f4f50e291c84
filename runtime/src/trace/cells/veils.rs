//! What a ray sees of the veils on its way: what stands for states that are smaller than the beam.
//!
//! Many veils may lie on one ray, each of which hardly counts. Those that look alike and lie one soon after the other are seen as one
//! fragment, where the one lies that shows most. How much they hide together stays exact.

use smallvec::SmallVec;

use super::ask::{Notes, Veil};
use super::cell::Named;
use super::ending::Ending;
use super::measure::Measuring;
use super::proxy::Proxy;
use super::resolve::{Hit, Resolver};
use crate::fault::Fault;
use crate::geometry::Ray;
use crate::trace::{Fragment, Seen, Site};

/// How much of what lies behind may be seen until nothing of it is.
const CLOSED: f64 = 1.0 / 512.0;

/// Into how many parts what is hidden is divided from front to back; what is in different ones is not seen as one.
const LAYERS: f64 = 2.0;

/// Veils that are seen as one.
#[derive(Clone, Copy)]
struct Sight {
    /// The one that shows most.
    veil: Veil,
    most: f64,
    layer: u8,
    /// What they show together, of all that the ray sees.
    part: f64,
}

impl<'g> Resolver<'_, '_, 'g> {
    /// Adds the veils before a hit; whether anything is seen behind them.
    #[cold]
    #[inline(never)]
    pub(super) fn see_veils(
        &mut self,
        notes: &Notes,
        hit: &Hit,
        measuring: Option<&Measuring>,
        seen: &mut Seen,
    ) -> Result<bool, Fault> {
        let (sights, closed) = sights(&veils(notes, hit), measuring.is_none());
        let mut open: f64 = 1.0;
        for (number, Sight { veil, part, .. }) in sights.iter().enumerate() {
            let last = closed && number + 1 == sights.len();
            let coverage = if last { 1.0 } else { (part / open).min(1.0) };
            open -= part;
            self.go(notes, veil.mark)?;
            self.see_veil(veil, coverage, hit.ray, measuring, seen)?;
        }
        Ok(!closed)
    }

    /// Adds a fragment for each paint of what a veil stands for; together they hide so much.
    fn see_veil(
        &self,
        veil: &Veil,
        coverage: f64,
        ray: &Ray,
        measuring: Option<&Measuring>,
        seen: &mut Seen,
    ) -> Result<(), Fault> {
        let Some(place) = self.place() else {
            return Ok(());
        };
        let cell = self.cell_of(place);
        let Some(part) = cell.parts.get(veil.mark.part as usize) else {
            return Ok(());
        };
        let Named::Instance(instance) = part.member.named() else {
            return Ok(());
        };
        let instance = &cell.instances[instance as usize];
        let here = self.generation_of(&place.cell);
        let model = here.model(instance.state);
        let is_closed = match measuring {
            Some(measuring) => measuring.is_closed(self.store(), here, model)?,
            None => false,
        };
        let proxy: Option<&Proxy> = match here.ending(model) {
            Some(Ending::Looks(proxy)) if !is_closed => Some(proxy),
            Some(Ending::Looks(_) | Ending::Solid(_)) | None => None,
        };
        let local = self.local(place, ray).entered(&instance.way).0;
        let mean = proxy.map_or(-local.direction, |it| it.normal(local.direction));
        let inner_from_world = instance.way.inner_from_outer.matrix3 * place.cell_from_world;
        let position = ray.at(veil.t);
        let normal = (inner_from_world.transpose() * mean).normalize();
        let unknown = [(None, 1.0)];
        let paints = proxy.map_or(&unknown[..], |it| &it.paints);
        let path = place.path_to(veil.mark.part);
        let mut before = 0.0;
        for (paint, share) in paints {
            // All shares together hide what the veil hides.
            let coverage = coverage * share;
            let of_rest = if before < 1.0 { (coverage / (1.0 - before)).min(1.0) } else { 0.0 };
            before += coverage;
            seen.push(Fragment {
                coverage: of_rest,
                spread: 1.0 - mean.length(),
                open: proxy.map_or(1.0, |it| it.open),
                material: paint.or(part.material).or(place.material),
                unknown: proxy.is_none(),
                route: place.route_to(part),
                site: Site { path: path.clone(), face: 0 },
                ..Fragment::of_surface(veil.t, position, normal, part.origin)
            });
            // What is painted in there has no one place.
            if paint.is_none() && proxy.is_some() {
                self.stand(place, veil.mark.part, (ray, veil.t), seen);
            }
        }
        Ok(())
    }
}

/// The veils before a hit, from front to back.
fn veils(notes: &Notes, hit: &Hit) -> SmallVec<[Veil; 16]> {
    let before = |it: &&Veil| it.ray == hit.number && it.t < hit.depth;
    let mut veils: SmallVec<[Veil; 16]> = notes.veils.iter().filter(before).copied().collect();
    let order = |a: &Veil, b: &Veil| {
        let path = |it: &Veil| notes.trails.path(it.mark);
        a.t.total_cmp(&b.t).then_with(|| path(a).cmp(&path(b)))
    };
    veils.sort_by(order);
    veils
}

/// What is seen of veils from front to back, and whether nothing is seen behind them. They are joined unless each is wanted by itself.
fn sights(veils: &[Veil], join: bool) -> (SmallVec<[Sight; 8]>, bool) {
    let mut sights: SmallVec<[Sight; 8]> = SmallVec::new();
    let mut open = 1.0;
    for veil in veils {
        let closed = open * (1.0 - veil.coverage) < CLOSED;
        let part = if closed { open } else { open * veil.coverage };
        let layer = ((1.0 - open + 0.5 * part) * LAYERS) as u8;
        open -= part;
        let same = |it: &&mut Sight| join && it.layer == layer && it.veil.looks == veil.looks;
        match sights.iter_mut().rev().find(same) {
            Some(sight) => {
                sight.part += part;
                if part > sight.most {
                    (sight.veil, sight.most) = (*veil, part);
                }
            }
            None => sights.push(Sight { veil: *veil, most: part, layer, part }),
        }
        if closed {
            return (sights, true);
        }
    }
    (sights, false)
}

#[cfg(test)]
mod tests {
    use super::super::ask::{Mark, NONE};
    use super::*;

    fn veil(t: f64, coverage: f64, looks: u64) -> Veil {
        Veil { ray: 0, t, coverage, looks, mark: Mark { trail: NONE, part: 0, face: 0 } }
    }

    #[test]
    fn veils_that_look_alike_are_one_and_hide_what_all_hide() {
        let (sights, closed) = sights(&[veil(1.0, 0.1, 7), veil(2.0, 0.2, 7), veil(3.0, 0.1, 7)], true);
        assert!(!closed);
        assert_eq!(sights.len(), 1);
        assert!((sights[0].part - (1.0 - 0.9 * 0.8 * 0.9)).abs() < 1e-12);
        assert_eq!(sights[0].veil.t, 2.0);
    }

    #[test]
    fn what_looks_different_or_lies_far_behind_is_apart() {
        let (apart, _) = sights(&[veil(1.0, 0.3, 7), veil(2.0, 0.3, 8), veil(3.0, 0.5, 7)], true);
        let parts: Vec<f64> = apart.iter().map(|it| it.part).collect();
        assert_eq!(parts.len(), 3);
        assert!((parts.iter().sum::<f64>() - (1.0 - 0.7 * 0.7 * 0.5)).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_seen_behind_what_hides_nearly_all() {
        let (sights, closed) = sights(&[veil(1.0, 0.9, 7), veil(2.0, 0.99, 7), veil(3.0, 0.5, 7)], true);
        assert!(closed);
        assert!((sights.iter().map(|it| it.part).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn those_who_measure_see_each_veil() {
        assert_eq!(sights(&[veil(1.0, 0.1, 7), veil(2.0, 0.1, 7)], false).0.len(), 2);
    }
}

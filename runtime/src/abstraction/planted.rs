//! What states with shapes below them amount to: found from what is really in them, since it is not known what a shape derives
//! to before it does.

use glam::DAffine3;

use super::cycles::{self, Endless, Knot, Link};
use super::entries::Circle;
use super::sketch::{Extent, Part, Sketch, What};
use super::step::{Step, Way};

/// A state with all that it expands to.
#[derive(Debug, Default)]
pub(crate) struct Plant {
    /// Its parts.
    pub(crate) sketch: Sketch,
    /// Where it leads to; parts of the sketch have numbers among these.
    pub(crate) next: Vec<Next>,
    /// The circle that its entry is in.
    pub(crate) circle: Option<Circle>,
}

/// Where a plant leads to.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "they live as long as one set of plants")]
pub(crate) enum Next {
    /// To the plant of this number.
    Plant(u32),
    /// To something that amounts to this.
    Known(Extent),
}

impl Part {
    /// One that is mapped by a known map; `None` if that is no transformation.
    pub(crate) fn mapped(map: &DAffine3, what: What) -> Option<Self> {
        let mut way = Way::default();
        way.push(Step::of_map(map)?);
        Some(Self { way, copies: 1, certain: true, what })
    }
}

/// What plants amount to, in the order given.
///
/// # Errors
/// The numbers of plants that lead to one another, the last to the first, and do not shrink on the way round.
pub(crate) fn extents(plants: &[Plant]) -> Result<Vec<Extent>, Vec<usize>> {
    let inner = |plant: &Plant| -> Vec<u32> {
        plant.next.iter().filter_map(|it| if let Next::Plant(it) = it { Some(*it) } else { None }).collect()
    };
    let next: Vec<Vec<u32>> = plants.iter().map(inner).collect();
    let mut found = vec![Extent::EMPTY; plants.len()];
    for component in cycles::components(plants.len(), 0, |node, edge| next[node as usize].get(edge).copied()) {
        let links: Vec<Vec<Link>> = component
            .iter()
            .map(|it| {
                let link = |next: &Next| match next {
                    Next::Known(extent) => Link::Outside(*extent),
                    Next::Plant(plant) => match component.iter().position(|it| it == plant) {
                        Some(number) => Link::Inside(number as u32),
                        None => Link::Outside(found[*plant as usize]),
                    },
                };
                plants[*it as usize].next.iter().map(link).collect()
            })
            .collect();
        let knots = component.iter().zip(&links).map(|(it, links)| {
            let Plant { sketch, circle, .. } = &plants[*it as usize];
            Knot { sketch, links, circle: *circle }
        });
        match cycles::extents(knots) {
            Ok(extents) => component.iter().zip(extents).for_each(|(it, extent)| found[*it as usize] = extent),
            Err(Endless { circle }) => return Err(circle.iter().map(|it| component[*it] as usize).collect()),
        }
    }
    Ok(found)
}

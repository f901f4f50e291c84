//! From the way to a hit to all that is asked about it.
//!
//! Nothing of this is kept while a ray searches: most of what it meets on the way is not what it sees in the end. Rays side
//! by side mostly see things in one cell, so what is known of the way to a cell is kept from one ray to the next.

use glam::{DAffine3, DMat3, DVec3};
use smallvec::SmallVec;

use super::ask::{Found, Mark, Trails};
use super::build::build;
use super::cell::{Cell, Leaf, Named};
use super::ray::{Inwards, Local};
use super::store::{Generation, Store};
use crate::fault::Fault;
use crate::form::MaterialId;
use crate::geometry::Ray;
use crate::trace::{Fragment, Route, Seen, Site};

/// A hit as a search leaves it.
pub(super) struct Hit<'r> {
    pub(super) ray: &'r Ray,
    pub(super) depth: f64,
    pub(super) found: Found,
}

/// Finds out about hits in one generation of cells.
pub(super) struct Resolver<'a, 's, 'g> {
    store: &'a Store<'s>,
    generation: &'g Generation,
    root: u32,
    cell_from_world: &'a Inwards,
    /// The cell that the last hit was in.
    place: Option<Place<'g>>,
}

/// A cell, and what has been collected on the way there.
struct Place<'g> {
    trail: u32,
    cell: Held<'g>,
    /// The numbers of the parts on the way.
    path: SmallVec<[u32; 12]>,
    ways: SmallVec<[Inwards; 6]>,
    material: Option<MaterialId>,
    route: Route,
    frozen: bool,
    /// From the world to the cell, but for its size.
    cell_from_world: DMat3,
}

/// A cell that is kept, or one for this place alone.
enum Held<'g> {
    Kept(&'g Cell),
    Own(Box<Cell>),
}

impl Held<'_> {
    fn cell(&self) -> &Cell {
        match self {
            Self::Kept(cell) => cell,
            Self::Own(cell) => cell,
        }
    }
}

impl<'a, 's, 'g> Resolver<'a, 's, 'g> {
    pub(super) fn new(
        store: &'a Store<'s>,
        generation: &'g Generation,
        root: u32,
        cell_from_world: &'a Inwards,
    ) -> Self {
        Self { store, generation, root, cell_from_world, place: None }
    }

    /// Forgets where the last hit was: trails are about to be made anew.
    pub(super) fn forget(&mut self) {
        self.place = None;
    }

    /// Adds what a ray sees where it has met something; nothing if it has not.
    ///
    /// # Errors
    /// What fails in expanding a state again that is not kept.
    #[inline]
    pub(super) fn see(&mut self, trails: &Trails, hit: &Hit, seen: &mut Seen) -> Result<(), Fault> {
        if hit.found.is_nothing() {
            return Ok(());
        }
        let mark = hit.found.mark();
        if self.place.as_ref().is_none_or(|it| it.trail != mark.trail) {
            self.place = Some(self.go(trails, mark)?);
        }
        if let Some(place) = &self.place {
            place.see(self.cell_from_world, mark, hit, seen);
        }
        Ok(())
    }

    /// Goes to the cell of a surface.
    fn go(&self, trails: &Trails, mark: Mark) -> Result<Place<'g>, Fault> {
        let mut path = trails.path(mark);
        path.pop();
        let mut place = Place {
            trail: mark.trail,
            cell: self.held(self.root)?,
            path: SmallVec::new(),
            ways: SmallVec::new(),
            material: None,
            route: Route::START,
            frozen: false,
            cell_from_world: DMat3::IDENTITY,
        };
        for number in &path {
            let cell = place.cell.cell();
            let Some(part) = cell.parts.get(*number as usize) else {
                break;
            };
            let Named::Instance(instance) = part.member.named() else {
                break;
            };
            let instance = &cell.instances[instance as usize];
            place.material = part.material.or(place.material);
            if !place.frozen {
                place.route = place.route.then(part.route);
                place.frozen = part.frozen;
            }
            place.cell_from_world = near_one(instance.way.inner_from_outer.matrix3 * place.cell_from_world);
            place.ways.push(instance.way);
            place.cell = self.held(instance.state)?;
        }
        place.path = path;
        Ok(place)
    }

    fn held(&self, state: u32) -> Result<Held<'g>, Fault> {
        Ok(match self.store.cell(self.generation, state)? {
            Some(cell) => Held::Kept(cell),
            None => Held::Own(Box::new(build(self.store, state)?)),
        })
    }
}

impl Place<'_> {
    #[inline]
    fn see(&self, cell_from_world: &Inwards, mark: Mark, hit: &Hit, seen: &mut Seen) {
        let cell = self.cell.cell();
        let Some(part) = cell.parts.get(mark.part as usize) else {
            return;
        };
        let Named::Leaf(leaf) = part.member.named() else {
            return;
        };
        let leaf = &cell.leaves[leaf as usize];
        let outwards = self.normal(cell_from_world, cell, leaf, mark.face, hit);
        let turned = if leaf.solid { hit.found.is_flipped() } else { outwards.dot(hit.ray.direction) > 0.0 };
        let mut path = self.path.clone();
        path.push(mark.part);
        seen.push(Fragment {
            coverage: 1.0,
            depth: hit.depth,
            position: hit.ray.at(hit.depth),
            normal: if turned { -outwards } else { outwards },
            material: part.material.or(self.material),
            route: if self.frozen { self.route } else { self.route.then(part.route) }.hash(),
            origin: part.origin,
            site: Site { path, face: mark.face },
        });
    }

    /// The normal of a leaf's face in the world: mapped by the transposed inverse of each map on the way (GT95, section 3),
    /// which is the transposed matrix of the way inwards. The frame of the first cell differs from the world's in size only.
    #[inline]
    fn normal(&self, cell_from_world: &Inwards, cell: &Cell, leaf: &Leaf, face: u8, hit: &Hit) -> DVec3 {
        let primitive = cell.primitive(leaf);
        let point = if primitive.is_flat(face) {
            DVec3::ZERO
        } else {
            let local = Local::new(hit.ray, cell_from_world);
            let local = self.ways.iter().fold(local, |local, way| local.entered(way).0);
            point_in(&local, &leaf.leaf_from_cell, hit.depth)
        };
        let normal = leaf.leaf_from_cell.matrix3.transpose() * primitive.normal(point, face);
        let normal = self.cell_from_world.transpose() * (normal / normal.abs().max_element());
        normal.normalize()
    }
}

/// A matrix in other units, so that no length on a long way is out of range.
fn near_one(matrix: DMat3) -> DMat3 {
    let size = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|it| it.abs().max_element());
    let factor = 1.0 / size[0].max(size[1]).max(size[2]);
    DMat3::from_cols(matrix.x_axis * factor, matrix.y_axis * factor, matrix.z_axis * factor)
}

/// The point at `t` in the frame of a leaf.
fn point_in(local: &Local, leaf_from_cell: &DAffine3, t: f64) -> DVec3 {
    let own = local.own(t);
    local.line(leaf_from_cell).at(if own.is_finite() { own } else { 0.0 })
}

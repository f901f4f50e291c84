//! From the way to a hit to all that is asked about it.
//!
//! Nothing of this is kept while a ray searches: most of what it meets on the way is not what it sees in the end. Rays side
//! by side mostly see things in one cell, so what is known of the way to a cell is kept from one ray to the next.

use std::sync::LazyLock;

use glam::{DAffine3, DMat3, DVec3};
use smallvec::SmallVec;

use super::ROOT;
use super::ask::{Found, Girth, Mark, Notes};
use super::cell::{Cell, ENDED, Grain, Leaf, Named, PART, Part};
use super::ending::{Ending, solid};
use super::flats::Flats;
use super::measure::Measuring;
use super::ray::{Inwards, Local};
use super::store::{Generation, Store};
use super::traverse::rough_set;
use crate::fault::Fault;
use crate::form::{MaterialId, Origin};
use crate::geometry::{Ray, Shown};
use crate::lanes::Kernel;
use crate::texture::Rough;
use crate::trace::{Fragment, Painted, Path, Route, Seen};

/// A hit as a search leaves it.
pub(super) struct Hit<'r> {
    pub(super) ray: &'r Ray,
    pub(super) girth: Girth,
    /// The ray's number in its packet.
    pub(super) number: u8,
    pub(super) depth: f64,
    pub(super) found: Found,
}

/// Finds out about hits in one generation of cells.
pub(super) struct Resolver<'a, 's, 'g> {
    store: &'a Store<'s>,
    generation: &'g Generation,
    root: Root<'a>,
    cell_from_world: &'a Inwards,
    /// The cells that the last hits were in, the last one first: rays side by side, and what they see through veils, alternate with few.
    places: [Option<Box<Place<'g>>>; KNOWN],
    /// The fragments whose normals are not done.
    flats: Flats,
}

/// So many cells are known.
const KNOWN: usize = 4;

/// Where ways begin.
#[derive(Clone, Copy)]
enum Root<'a> {
    State(u32),
    Cell(&'a Cell),
}

/// A cell, and what has been collected on the way there.
pub(super) struct Place<'g> {
    /// The trail there; none if it has been forgotten.
    trail: Option<u32>,
    pub(super) cell: Held<'g>,
    /// The numbers of the parts on the way,
    path: Path,
    /// and how many there are.
    length: usize,
    /// The ways into the cells on the way, as far as those are kept.
    ways: SmallVec<[&'g Inwards; 8]>,
    pub(super) material: Option<MaterialId>,
    /// Where that paint stands, if its look depends on it.
    standing: Option<Box<Standing>>,
    route: Route,
    frozen: bool,
    /// From the world to the cell, but for its size.
    pub(super) cell_from_world: DMat3,
}

/// The frame in which a paint stands.
#[derive(Clone)]
struct Standing {
    /// How many ways lead to the cell that it stands in.
    ways: usize,
    paint_from_cell: DAffine3,
}

impl Standing {
    /// That of the paint of a part of a cell to which so many ways lead, if its look depends on it.
    fn of(cell: &Cell, part: u32, ways: usize) -> Option<Self> {
        let paint_from_cell = *cell.paint_from_cell(part)?;
        Some(Self { ways, paint_from_cell })
    }
}

/// Where a cell is held.
pub(super) enum Held<'g> {
    /// In the generation of the rays.
    Kept(&'g Cell),
    /// In one of this place's own: it does not fit in that one.
    Apart(Box<Generation>, Which),
    /// The cell where ways begin, which is held elsewhere.
    Root,
}

/// A cell of a generation.
#[derive(Clone, Copy)]
pub(super) enum Which {
    /// That of a state, of a grain.
    Of(u32, Grain),
    /// The one that stands for a state from far away.
    EndOf(u32),
}

impl Which {
    /// The cell that a ray goes into where it is noted to have gone into a part of this number, an instance of a state.
    fn noted(number: u32, state: u32) -> Self {
        if number & ENDED == 0 { Self::Of(state, Grain::noted(number)) } else { Self::EndOf(state) }
    }

    fn state(self) -> u32 {
        match self {
            Self::Of(state, _) | Self::EndOf(state) => state,
        }
    }

    /// The same of the state where ways begin.
    fn of_root(self) -> Self {
        match self {
            Self::Of(_, grain) => Self::Of(ROOT, grain),
            Self::EndOf(_) => Self::EndOf(ROOT),
        }
    }

    /// The cell; none if there is no room for it.
    fn cell<'c>(self, store: &Store, generation: &'c Generation) -> Result<Option<&'c Cell>, Fault> {
        match self {
            Self::Of(state, grain) => store.cell(generation, state, grain),
            Self::EndOf(state) => solid(store, generation, generation.model(state)),
        }
    }

    /// The cell, if it is there.
    fn kept(self, generation: &Generation) -> Option<&Cell> {
        match self {
            Self::Of(state, grain) => generation.kept(state, grain),
            Self::EndOf(state) => match generation.ending(generation.model(state)) {
                Some(Ending::Solid(cell)) => Some(cell),
                Some(Ending::Looks(_)) | None => None,
            },
        }
    }
}

impl<'a, 's, 'g> Resolver<'a, 's, 'g> {
    /// For rays of the world through the cell of a state.
    pub(super) fn of_state(
        store: &'a Store<'s>,
        generation: &'g Generation,
        root: u32,
        cell_from_world: &'a Inwards,
    ) -> Self {
        Self {
            store,
            generation,
            root: Root::State(root),
            cell_from_world,
            places: Default::default(),
            flats: Flats::default(),
        }
    }

    /// For rays through a cell by itself.
    pub(super) fn of_cell(
        store: &'a Store<'s>,
        generation: &'g Generation,
        root: &'a Cell,
        cell_from_world: &'a Inwards,
    ) -> Self {
        Self {
            store,
            generation,
            root: Root::Cell(root),
            cell_from_world,
            places: Default::default(),
            flats: Flats::default(),
        }
    }

    /// Forgets by which trail the last hits were where they were: trails are about to be made anew.
    pub(super) fn forget(&mut self) {
        for place in self.places.iter_mut().flatten() {
            place.trail = None;
        }
    }

    /// Adds what a ray sees, from front to back: the veils on the way and where it ends.
    ///
    /// # Errors
    /// What fails in expanding a state again that is not kept.
    #[inline]
    pub(super) fn see(
        &mut self,
        notes: &Notes,
        hit: &Hit,
        measuring: Option<&Measuring>,
        seen: &mut Seen,
    ) -> Result<(), Fault> {
        if !notes.veils.is_empty() && !self.see_veils(notes, hit, measuring, seen)? {
            return Ok(());
        }
        if hit.found.is_nothing() {
            return Ok(());
        }
        let mark = hit.found.mark();
        self.go(notes, mark)?;
        if let Some(place) = self.places[0].take() {
            self.see_surface(&place, mark, hit, seen);
            self.places[0] = Some(place);
        }
        Ok(())
    }

    /// Gives all normals that are not done the length 1 and their direction, several at once.
    ///
    /// [`Resolver::see`] leaves that to whoever has let some rays see.
    pub(super) fn straighten<K: Kernel>(&mut self, kernel: K, seen: &mut Seen) {
        self.flats.straighten(kernel, seen.fragments_mut());
    }

    /// A ray in the frame of a place.
    pub(super) fn local(&self, place: &Place, ray: &Ray) -> Local {
        let mut local = Local::new(ray, self.cell_from_world);
        self.go_in(place, place.length, |way| local = local.entered(way).0);
        local
    }

    /// Goes the first so many ways to a place, from the outermost.
    #[inline]
    fn go_in(&self, place: &Place, count: usize, enter: impl FnMut(&Inwards)) {
        match place.ways.get(..count) {
            Some(ways) => ways.iter().copied().for_each(enter),
            None => self.go_by_path(place.path.parts().take(count), enter),
        }
    }

    /// The same where cells on the way are not kept.
    #[cold]
    fn go_by_path(&self, path: impl Iterator<Item = u32>, mut enter: impl FnMut(&Inwards)) {
        let mut held = self.held_root().ok();
        for number in path {
            let Some(here) = held else {
                break;
            };
            let Some((way, state)) = self.cell_in(&here).way_into(number & PART) else {
                break;
            };
            enter(way);
            held = self.inside(here, Which::noted(number, state)).ok();
        }
    }

    /// Where states and cells are kept.
    pub(super) fn store(&self) -> &'a Store<'s> {
        self.store
    }

    /// Where the last hit was.
    pub(super) fn place(&self) -> Option<&Place<'g>> {
        self.places[0].as_deref()
    }

    #[inline(always)]
    pub(super) fn cell_of<'p>(&'p self, place: &'p Place) -> &'p Cell {
        self.cell_in(&place.cell)
    }

    #[inline(always)]
    fn cell_in<'p>(&'p self, held: &'p Held) -> &'p Cell {
        match (held, self.root) {
            (Held::Kept(cell), _) => cell,
            // It is held because its cell is there.
            (Held::Apart(generation, which), _) => which.kept(generation).unwrap_or(&NO_CELL),
            (Held::Root, Root::Cell(cell)) => cell,
            // Ways that begin at a state hold its cell.
            (Held::Root, Root::State(_)) => &NO_CELL,
        }
    }

    /// The generation in which states have the numbers that a cell gives them.
    pub(super) fn generation_of<'p>(&'p self, held: &'p Held) -> &'p Generation {
        match held {
            Held::Kept(_) | Held::Root => self.generation,
            Held::Apart(generation, _) => generation,
        }
    }

    /// Goes to the cell of a surface, if the last one was not in the same.
    #[inline(always)]
    pub(super) fn go(&mut self, notes: &Notes, mark: Mark) -> Result<(), Fault> {
        if self.place().is_some_and(|it| it.trail == Some(mark.trail)) { Ok(()) } else { self.go_on(notes, mark) }
    }

    /// Goes to another cell.
    fn go_on(&mut self, notes: &Notes, mark: Mark) -> Result<(), Fault> {
        let is_there = |it: &Place| it.trail == Some(mark.trail) || notes.trails.leads(mark.trail, &it.path, it.length);
        let known = self.places.iter().position(|it| it.as_deref().is_some_and(is_there));
        // It becomes the first, and those before it move back; the one that was seen the longest time ago gives its room to one that is new.
        for number in 1..=known.unwrap_or(KNOWN - 1) {
            self.places.swap(0, number);
        }
        if known.is_none() {
            let mut way = notes.trails.path(mark);
            way.pop();
            let found = self.find(&way, mark.trail)?;
            match &mut self.places[0] {
                Some(place) => **place = found,
                place => *place = Some(Box::new(found)),
            }
        } else if let Some(place) = &mut self.places[0] {
            place.trail = Some(mark.trail);
        }
        Ok(())
    }

    /// Where a way of these parts leads, which is a trail of this number.
    fn find(&self, way: &[u32], trail: u32) -> Result<Place<'g>, Fault> {
        let mut place = Place {
            trail: Some(trail),
            cell: self.held_root()?,
            path: Path::default(),
            length: 0,
            ways: SmallVec::new(),
            material: None,
            standing: None,
            route: Route::START,
            frozen: false,
            cell_from_world: DMat3::IDENTITY,
        };
        for (depth, number) in way.iter().enumerate() {
            let cell = self.cell_of(&place);
            let Some(part) = cell.parts.get((number & PART) as usize) else {
                break;
            };
            let Named::Instance(instance) = part.member.named() else {
                break;
            };
            let instance = &cell.instances[instance as usize];
            let state = instance.state;
            let (route, frozen) =
                if place.frozen { (place.route, true) } else { (place.route.then(part.route), part.frozen) };
            let material = part.material.or(place.material);
            let standing = part.material.is_some().then(|| Standing::of(cell, number & PART, depth));
            let cell_from_world = near_one(instance.way.matrix_after(&place.cell_from_world));
            if place.ways.len() == depth
                && let Held::Kept(cell) = place.cell
                && let Some((way, _)) = cell.way_into(number & PART)
            {
                place.ways.push(way);
            }
            if let Some(standing) = standing {
                place.standing = standing.map(Box::new);
            }
            (place.material, place.route, place.frozen) = (material, route, frozen);
            place.cell_from_world = cell_from_world;
            place.cell = self.inside(place.cell, Which::noted(*number, state))?;
        }
        place.length = way.len();
        place.path = Path::way(way);
        Ok(place)
    }

    /// Adds the surface where a ray ends.
    #[inline]
    fn see_surface(&mut self, place: &Place, mark: Mark, hit: &Hit, seen: &mut Seen) {
        let cell = self.cell_of(place);
        let Some(part) = cell.parts.get(mark.part as usize) else {
            return;
        };
        let mut undone = None;
        let (normal, spread, face) = match part.member.named() {
            Named::Leaf(leaf) => {
                let leaf = &cell.leaves[leaf as usize];
                match Self::flat_normal(place, cell, leaf, mark.face).or_else(|| self.round_normal(place, leaf, hit)) {
                    Some(outwards) => {
                        undone = Some(leaf.solid.then(|| hit.found.is_flipped()));
                        (outwards, 0.0, u32::from(mark.face))
                    }
                    None => {
                        let (normal, face) = self.shaped_normal(place, (leaf, part), mark, hit);
                        (normal, 0.0, face)
                    }
                }
            }
            // The closed box that stands for an instance inside a Boolean.
            _ => (-hit.ray.direction.normalize(), 0.5, 0),
        };
        // Filled where it lies: what is written in parts and then moved is waited for.
        let fragment = seen.add(Fragment::of_surface(hit.depth, hit.ray.at(hit.depth), normal, Origin::NONE));
        fragment.origin = part.origin;
        fragment.spread = spread;
        fragment.material = part.material.or(place.material);
        fragment.route = place.route_to(part);
        fragment.site.path.lead(&place.path, mark.part);
        fragment.site.face = face;
        if place.standing.is_some() || !cell.painted.is_empty() {
            self.stand(place, mark.part, (hit.ray, hit.depth), seen);
        }
        if !cell.barks.is_empty() {
            self.stand_on_stem(place, mark.part, (hit.ray, hit.depth), seen);
        }
        if let Some(turned) = undone {
            self.flats.add(seen.fragments().len() - 1, hit.ray.direction, turned);
        }
    }

    /// Tells the last fragment where it is on the rind of its stem, if its look depends on that.
    #[inline]
    fn stand_on_stem(&self, place: &Place, number: u32, at: (&Ray, f64), seen: &mut Seen) {
        let cell = self.cell_of(place);
        let (Some(bark), Some(part)) = (cell.bark(number), cell.parts.get(number as usize)) else {
            return;
        };
        if let Named::Leaf(leaf) = part.member.named()
            && self.store.expander.is_on_stems(part.material.or(place.material))
        {
            let leaf_from_cell = cell.leaves[leaf as usize].leaf_from_cell;
            let standing = Standing { ways: place.length, paint_from_cell: leaf_from_cell };
            seen.paint_on_stem(self.painted(place, &standing, at).on(&bark.rind));
        }
    }

    /// Tells the last fragment where it is in the frame in which its paint stands, if its look depends on that.
    #[inline]
    pub(super) fn stand(&self, place: &Place, part: u32, at: (&Ray, f64), seen: &mut Seen) {
        let cell = self.cell_of(place);
        if place.standing.is_none() && cell.painted.is_empty() {
            return;
        }
        let own = cell.parts.get(part as usize).is_some_and(|it| it.material.is_some());
        let of_part = || Standing::of(cell, part, place.length);
        let standing = if own { of_part() } else { place.standing.as_deref().cloned() };
        if let Some(standing) = standing {
            seen.paint(self.painted(place, &standing, at));
        }
    }

    /// The place of a ray at `t` in the frame in which a paint stands.
    #[cold]
    #[inline(never)]
    fn painted(&self, place: &Place, standing: &Standing, (ray, t): (&Ray, f64)) -> Painted {
        let mut local = Local::new(ray, self.cell_from_world);
        let mut matrix = self.cell_from_world.inner_from_outer.matrix3;
        self.go_in(place, standing.ways, |way| {
            local = local.entered(way).0;
            matrix = way.inner_from_outer.matrix3 * matrix;
        });
        Painted {
            position: point_in(&local, &standing.paint_from_cell, t),
            paint_from_world: standing.paint_from_cell.matrix3 * matrix,
        }
    }

    /// A vector along the normal of a flat face of a convex primitive in the world, outwards. The frames of such primitives are such that nothing here is out of
    /// range ([`LeafShape::Convex`](super::cell::LeafShape::Convex), [`near_one`]).
    #[inline(always)]
    pub(super) fn flat_normal(place: &Place, cell: &Cell, leaf: &Leaf, face: u8) -> Option<DVec3> {
        let normal = cell.convex(leaf)?.flat_normal(u32::from(face))?;
        Some(outwards(place, leaf, normal))
    }

    /// The same where a ray meets any face of a convex primitive.
    #[inline(always)]
    pub(super) fn round_normal(&self, place: &Place, leaf: &Leaf, hit: &Hit) -> Option<DVec3> {
        let convex = self.cell_of(place).convex(leaf)?;
        let point = point_in(&self.local(place, hit.ray), &leaf.leaf_from_cell, hit.depth);
        Some(outwards(place, leaf, convex.normal(u32::from(hit.found.mark().face), point)))
    }

    /// The normal in the world where a ray meets any other surface, on the side that is seen, and the face.
    #[inline(never)]
    pub(super) fn shaped_normal(
        &self,
        place: &Place,
        (leaf, part): (&Leaf, &Part),
        mark: Mark,
        hit: &Hit,
    ) -> (DVec3, u32) {
        let cell = self.cell_of(place);
        // What is cut by others is not carved.
        let cut = place.frozen || part.frozen;
        let rough = if cut { None } else { rough_set(&self.store.roughs, cell, leaf, place.material) };
        let girth = if cut { Girth::NONE } else { hit.girth };
        let width = |center| self.local(place, hit.ray).width_at(girth, &leaf.leaf_from_cell, center);
        let shown = cell.shown(leaf, width);
        let line = || line_in(&self.local(place, hit.ray), leaf, hit.depth);
        let face = cell.face(leaf, shown, mark.face, rough, line);
        let outwards = self.normal(place, cell, (leaf, face), (shown, rough), hit);
        let turned = if leaf.solid { hit.found.is_flipped() } else { outwards.dot(hit.ray.direction) > 0.0 };
        (if turned { -outwards } else { outwards }, face)
    }

    /// The normal of a leaf's face in the world: mapped by the transposed inverse of each map on the way (GT95, section 3),
    /// which is the transposed matrix of the way inwards. The frame of the first cell differs from the world's in size only.
    #[inline]
    fn normal(
        &self,
        place: &Place,
        cell: &Cell,
        (leaf, face): (&Leaf, u32),
        (shown, rough): (Option<Shown<'_>>, Option<&Rough>),
        hit: &Hit,
    ) -> DVec3 {
        let normal = cell.with_primitive(leaf, |primitive| {
            let point = if primitive.is_flat(face) && rough.is_none() {
                DVec3::ZERO
            } else {
                point_in(&self.local(place, hit.ray), &leaf.leaf_from_cell, hit.depth)
            };
            let normal = shown.map_or_else(|| primitive.normal(point, face), |it| it.normal(face));
            rough.map_or(normal, |it| it.normal(normal, point))
        });
        let normal = transposed(&leaf.leaf_from_cell.matrix3, normal);
        transposed(&place.cell_from_world, normal * (1.0 / normal.abs().max_element())).normalize()
    }

    fn held_root(&self) -> Result<Held<'g>, Fault> {
        match self.root {
            Root::State(state) => self.inside(Held::Root, Which::Of(state, Grain::Fine)),
            Root::Cell(_) => Ok(Held::Root),
        }
    }

    /// A cell inside another.
    fn inside(&self, outer: Held<'g>, which: Which) -> Result<Held<'g>, Fault> {
        let outer = match outer {
            Held::Apart(outer, _) => outer,
            Held::Kept(_) | Held::Root => match which.cell(self.store, self.generation)? {
                Some(cell) => return Ok(Held::Kept(cell)),
                None => return self.apart(self.generation, which),
            },
        };
        if which.cell(self.store, &outer)?.is_some() {
            return Ok(Held::Apart(outer, which));
        }
        self.apart(&outer, which)
    }

    /// A cell for which there is no room in a generation.
    fn apart(&self, outer: &Generation, which: Which) -> Result<Held<'g>, Fault> {
        let apart = Box::new(outer.apart(which.state()));
        let which = which.of_root();
        which.cell(self.store, &apart)?;
        Ok(Held::Apart(apart, which))
    }
}

impl Place<'_> {
    /// The numbers of the parts on the way to the cell.
    #[inline(always)]
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The numbers of the parts on the way to a part.
    #[inline(always)]
    pub(super) fn path_to(&self, part: u32) -> Path {
        self.path.to(part)
    }

    /// A hash of the whole route to a part.
    pub(super) fn route_to(&self, part: &Part) -> u64 {
        if self.frozen { self.route } else { self.route.then(part.route) }.hash()
    }
}

/// For ways that begin nowhere.
pub(super) static NO_CELL: LazyLock<Cell> = LazyLock::new(Cell::default);

/// A matrix in other units where they are needed, so that no length on a long way is out of range.
fn near_one(matrix: DMat3) -> DMat3 {
    let size = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|it| it.abs().max_element());
    let size = size[0].max(size[1]).max(size[2]);
    if (1e-60..1e60).contains(&size) {
        return matrix;
    }
    let factor = 1.0 / size;
    DMat3::from_cols(matrix.x_axis * factor, matrix.y_axis * factor, matrix.z_axis * factor)
}

/// A normal in the frame of a leaf as a vector of the world.
#[inline(always)]
fn outwards(place: &Place, leaf: &Leaf, normal: DVec3) -> DVec3 {
    transposed(&place.cell_from_world, transposed(&leaf.leaf_from_cell.matrix3, normal))
}

/// A vector mapped by a transposed matrix.
#[inline(always)]
fn transposed(matrix: &DMat3, vector: DVec3) -> DVec3 {
    DVec3::new(matrix.x_axis.dot(vector), matrix.y_axis.dot(vector), matrix.z_axis.dot(vector))
}

/// A ray in the frame of a leaf, and `t` there.
fn line_in(local: &Local, leaf: &Leaf, t: f64) -> (Ray, f64) {
    (local.line(&leaf.leaf_from_cell), local.own(t))
}

/// The point at `t` in the frame of a leaf.
fn point_in(local: &Local, leaf_from_cell: &DAffine3, t: f64) -> DVec3 {
    let own = local.own(t);
    local.line(leaf_from_cell).at(if own.is_finite() { own } else { 0.0 })
}

//! The reference walker: ray tracing of a cyclic CSG graph by the book (GT95, section 3).
//!
//! A ray is passed from node to node. S-nodes select, C-nodes calculate, T-nodes map the ray and add their matrix to a chain, operator
//! nodes combine the intervals that their operands give, primitives give theirs, each with the chain on which it was reached.
//! Nothing is kept from one ray to the next, nothing is culled, and every recursion is followed to its end, however wide a
//! beam. It is slow, and the oracle of the fast tracer's tests.

use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DAffine3;
use smallvec::SmallVec;

use super::chain::{Chain, Standing};
use super::{Bark, Beam, Fragment, RayFault, Route, Seen, Site, SurfaceBeam, Tracer, shapes, walk};
use crate::derive::Placed;
use crate::eval::{Env, Machine, trail_step};
use crate::fault::{Fault, FaultKind, Limit, TrailStep};
use crate::form::{Graph, MaterialId, Node, NodeId, Origin, Scene, Select, Stem};
use crate::geometry::{Aabb, Hide, Intervals, Joints, Part, Primitive, Ray, Rind};
use crate::limits::Limits;
use crate::texture::Roughs;

/// Numbers on the way to a primitive that count as a step: they are kept with each of its surfaces.
const PLACES: u64 = 16;

/// Traces rays through a scene by the book.
#[derive(Debug)]
pub struct Reference<'s> {
    scene: &'s Scene,
    /// The reliefs of its materials.
    hides: Box<[Option<Arc<Hide>>]>,
    /// How the surfaces of its materials are carved.
    roughs: Roughs,
    limits: Limits,
    /// Work of all rays so far: primitives that were met, and operations.
    work: AtomicU64,
}

impl<'s> Reference<'s> {
    /// A walker through a scene.
    pub fn new(scene: &'s Scene, limits: &Limits) -> Self {
        Self {
            scene,
            hides: scene.hides(),
            roughs: Roughs::new(&scene.materials, scene.seed),
            limits: *limits,
            work: AtomicU64::new(0),
        }
    }

    /// Everything on a line: t from -inf to inf.
    fn walk(&self, ray: &Ray, from: Option<&Site>) -> Result<Walked, Fault> {
        let graph = &self.scene.graph;
        let mut walk = Walk {
            graph,
            scene: self.scene,
            hides: &self.hides,
            roughs: &self.roughs,
            machine: Machine::new(graph.functions(), self.scene.seed, &self.limits),
            limits: &self.limits,
            from,
            surfaces: Vec::new(),
            selected: 0,
            steps: 0,
        };
        let env = walk.machine.root(graph)?;
        let here = Here {
            ray: *ray,
            chain: Rc::new(Chain::World),
            material: None,
            standing: None,
            route: Route::START,
            frozen: false,
            env,
            site: SmallVec::new(),
            depth: 0,
            booleans: 0,
        };
        let line = walk.pass(graph.system(graph.root()).start, here)?;
        let work = walk.steps + walk.machine.operations();
        if self.work.fetch_add(work, Ordering::Relaxed).saturating_add(work) > self.limits.work {
            return Err(limit(Limit::Work, self.limits.work, Origin::NONE));
        }
        Ok(Walked { line, surfaces: walk.surfaces, selected: walk.selected })
    }

    fn see(&self, beam: &Beam, from: Option<&Site>, seen: &mut Seen) -> Result<(), Fault> {
        let ray = &beam.ray;
        let Walked { line, surfaces, .. } = self.walk(ray, from)?;
        if let Some((t, surface, flipped)) = line.first_after(beam.bias(from)) {
            let surface = &surfaces[surface as usize];
            seen.push(surface.fragment(ray, t, flipped, &self.roughs));
            surface.standing.iter().for_each(|it| seen.paint(it.painted(t)));
            if let Some(rind) = &surface.rind {
                let standing = Standing { ray: surface.ray, chain: Rc::clone(&surface.chain) };
                seen.paint_on_stem(standing.painted(t).on(rind));
            }
        }
        seen.end_ray();
        Ok(())
    }

    fn see_all<'r>(
        &self,
        beams: impl Iterator<Item = (&'r Beam, Option<&'r Site>)>,
        seen: &mut Seen,
    ) -> Result<(), RayFault> {
        seen.clear();
        for (number, (beam, from)) in beams.enumerate() {
            self.see(beam, from, seen).map_err(|fault| RayFault { ray: number, fault })?;
        }
        Ok(())
    }
}

impl Tracer for Reference<'_> {
    fn look(&self, beams: &[Beam], seen: &mut Seen) -> Result<(), RayFault> {
        self.see_all(beams.iter().map(|it| (it, None)), seen)
    }

    fn look_from(&self, beams: &[SurfaceBeam], seen: &mut Seen) -> Result<(), RayFault> {
        self.see_all(beams.iter().map(|it| (&it.beam, Some(&it.from))), seen)
    }

    fn light(&self, beams: &[SurfaceBeam], light: &mut Vec<f64>) -> Result<(), RayFault> {
        light.clear();
        for (number, it) in beams.iter().enumerate() {
            let walked = self.walk(&it.beam.ray, Some(&it.from));
            let Walked { line, .. } = walked.map_err(|fault| RayFault { ray: number, fault })?;
            light.push(if line.first_after(it.beam.bias(Some(&it.from))).is_some() { 0.0 } else { 1.0 });
        }
        Ok(())
    }

    fn work(&self, beams: &[Beam], work: &mut Vec<u32>) -> Result<(), RayFault> {
        work.clear();
        for (number, beam) in beams.iter().enumerate() {
            let walked = self.walk(&beam.ray, None).map_err(|fault| RayFault { ray: number, fault })?;
            work.push(walked.selected);
        }
        Ok(())
    }

    fn finite_bounds(&self) -> Result<Aabb, Fault> {
        // What a box is does not depend on how rays are traced, and going through every copy by the book would take for ever.
        super::cells::finite_bounds(self.scene, &self.limits)
    }
}

/// What a line meets in a scene.
struct Walked {
    line: Line,
    surfaces: Vec<Surface>,
    /// How many S-nodes it went through.
    selected: u32,
}

/// What a line meets below a node.
struct Line {
    /// Where it is inside, each end with the surface it crosses there.
    inside: Intervals<u32>,
    /// Where it crosses surfaces without an inside.
    crossings: Vec<(f64, u32)>,
}

impl Line {
    fn empty() -> Self {
        Self { inside: Intervals::empty(), crossings: Vec::new() }
    }

    /// The first surface after `start`, and whether it is one that a difference turned inside out.
    fn first_after(&self, start: f64) -> Option<(f64, u32, bool)> {
        let ends =
            self.inside.as_slice().iter().flat_map(|it| [it.near, it.far]).map(|it| (it.t, it.surface, it.flipped));
        let crossings = self.crossings.iter().map(|(t, surface)| (*t, *surface, false));
        let visible = ends.chain(crossings).filter(|it| it.0 > start && it.0.is_finite());
        // Surfaces are numbered in the order written, and of two at one place the first written is seen.
        visible.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }
}

/// A primitive's surface that the line met.
struct Surface {
    primitive: Primitive,
    origin: Origin,
    material: Option<MaterialId>,
    standing: Option<Rc<Standing>>,
    /// The rind of a segment of a stem, if its look depends on that.
    rind: Option<Rind>,
    route: Route,
    /// The ray in the primitive's frame.
    ray: Ray,
    chain: Rc<Chain>,
    site: Site,
    /// Whether it is the surface of a hull that its material may carve.
    carved: bool,
}

impl Surface {
    fn fragment(&self, world_ray: &Ray, t: f64, flipped: bool, roughs: &Roughs) -> Fragment {
        let mut own = self.primitive.normal(self.ray.at(t), self.site.face);
        if let Some(rough) = roughs.of(self.material).filter(|_| self.carved) {
            own = rough.normal(own, self.ray.at(t));
        }
        let mut normal = self.chain.normal_to_world(own).normalize();
        let against = !self.primitive.is_solid() && normal.dot(world_ray.direction) > 0.0;
        if flipped || against {
            normal = -normal;
        }
        Fragment {
            material: self.material,
            route: self.route.hash(),
            site: self.site.clone(),
            ..Fragment::of_surface(t, world_ray.at(t), normal, self.origin)
        }
    }
}

/// Where a ray is in the graph, and what it brings along.
#[derive(Clone)]
struct Here {
    /// The ray in the frame of this place.
    ray: Ray,
    chain: Rc<Chain>,
    material: Option<MaterialId>,
    /// Where that paint stands, if its look depends on it.
    standing: Option<Rc<Standing>>,
    route: Route,
    /// Whether the route has ended, since a Boolean is one solid.
    frozen: bool,
    env: Env,
    /// The numbers of the operands and copies on the way.
    site: SmallVec<[u32; 12]>,
    /// How many modules and systems it is inside.
    depth: u32,
    /// How many Booleans it is inside.
    booleans: u32,
}

impl Here {
    fn step(&mut self, number: u64) {
        if !self.frozen {
            self.route = self.route.then(Route::step(number));
        }
    }

    fn operand(&self, number: usize) -> Self {
        let mut here = self.clone();
        here.site.push(number as u32);
        here
    }
}

/// The walk of one ray through the graph.
struct Walk<'w, 's> {
    graph: &'s Graph,
    scene: &'s Scene,
    hides: &'w [Option<Arc<Hide>>],
    roughs: &'w Roughs,
    machine: Machine<'s>,
    limits: &'w Limits,
    /// The surface that the ray starts on.
    from: Option<&'w Site>,
    surfaces: Vec<Surface>,
    selected: u32,
    /// Primitives met so far, with the numbers on the way to each, which are kept with its surfaces.
    steps: u64,
}

impl Walk<'_, '_> {
    /// Passes the ray to a node.
    fn pass(&mut self, node: NodeId, mut here: Here) -> Result<Line, Fault> {
        let graph = self.graph;
        let mut node = node;
        loop {
            match graph.node(node) {
                Node::Empty => return Ok(Line::empty()),
                Node::Primitive { kind, code, origin } => {
                    let values = self.machine.primitive(*kind, code, &mut here.env)?;
                    return match graph.primitive(*kind, &values) {
                        Some(primitive) => self.primitive(&primitive, None, *origin, &here),
                        None => {
                            let kind = FaultKind::Primitive { kind: *kind, values: values.to_vec() };
                            Err(Fault::new(kind, *origin))
                        }
                    };
                }
                Node::Transform { kind, code, body, origin } => {
                    let inner_from_outer = self.machine.transform(*kind, code, &mut here.env, *origin)?.inverse();
                    here.ray = here.ray.mapped(&inner_from_outer);
                    here.chain = Rc::new(Chain::Transform { inner_from_outer, outer: Rc::clone(&here.chain) });
                    node = *body;
                }
                Node::Calc { code, body, .. } => {
                    self.machine.calculate(code, &mut here.env)?;
                    node = *body;
                }
                Node::Paint { material, body } => {
                    here.material = Some(*material);
                    here.standing = self.standing(*material, &here);
                    node = *body;
                }
                Node::Variant { count, body, origin } => {
                    let count = self.machine.whole(count, &mut here.env, "variant", 1, *origin)?;
                    here.env.fold(count);
                    node = *body;
                }
                Node::Choice { condition, then, otherwise } => {
                    node = if self.machine.truth(condition, &mut here.env)? { *then } else { *otherwise };
                }
                Node::Repeat { count, index, body, origin } => {
                    let count = self.machine.whole(count, &mut here.env, "repeat", 0, *origin)?;
                    let mut lines = Vec::new();
                    for number in 0..count {
                        let mut copy = here.operand(number as usize);
                        copy.env.turn(*index, number);
                        copy.step(walk::COPY ^ u64::from(number));
                        lines.push(self.pass(*body, copy)?);
                    }
                    return Ok(union(lines));
                }
                Node::Union(operands) => {
                    let mut lines = Vec::new();
                    for (number, operand) in operands.iter().enumerate() {
                        let mut copy = here.operand(number);
                        copy.step(walk::OPERAND ^ number as u64);
                        lines.push(self.pass(*operand, copy)?);
                    }
                    return Ok(union(lines));
                }
                Node::Intersect(_) | Node::Difference(..) if self.goes_through(&here) => return Ok(Line::empty()),
                Node::Intersect(operands) => return self.intersect(operands, &here),
                Node::Difference(first, others) => return self.subtract(*first, others, &here),
                Node::Call(call) => {
                    here.env = self.machine.enter(graph, call, &mut here.env)?;
                    here.step(call.place);
                    let select = graph.select(call.select);
                    let step = trail_step(graph, select, &here.env, call.origin);
                    return self.deeper(here, step, |walk, here| walk.select(select, here));
                }
                Node::System(call) => {
                    here.env = self.machine.enter_system(graph, call, &mut here.env)?;
                    here.step(call.place);
                    let system = graph.system(call.system);
                    let step = TrailStep { name: system.name.clone(), values: Vec::new(), origin: call.origin };
                    return self.deeper(here, step, |walk, here| walk.pass(system.start, here));
                }
                Node::Shape(shape) => {
                    let (seed, limits) = (self.machine.seed(), self.limits);
                    let mut taker = Parts { walk: self, here: &here, lines: Vec::new() };
                    shapes::parts(graph, *shape, &here.env, seed, limits, &mut taker)?;
                    return Ok(union(taker.lines));
                }
            }
        }
    }

    /// Goes into a module or system; a fault inside is told with the way to it.
    fn deeper(
        &mut self,
        mut here: Here,
        step: TrailStep,
        go: impl FnOnce(&mut Self, Here) -> Result<Line, Fault>,
    ) -> Result<Line, Fault> {
        here.depth += 1;
        let result = if here.depth > self.limits.depth {
            Err(limit(Limit::Depth, self.limits.depth.into(), step.origin))
        } else {
            go(self, here)
        };
        result.map_err(|fault| fault.reached_through(step))
    }

    fn select(&mut self, select: &Select, mut here: Here) -> Result<Line, Fault> {
        self.selected += 1;
        let chosen = self.machine.choose(self.graph, select, &mut here.env)?;
        here.step(walk::CHOICE ^ chosen as u64);
        self.pass(select.rules[chosen].body, here)
    }

    fn intersect(&mut self, operands: &[NodeId], here: &Here) -> Result<Line, Fault> {
        let mut result: Option<Intervals<u32>> = None;
        for (number, operand) in operands.iter().enumerate() {
            let inside = self.solid_operand(*operand, number, here)?;
            result = Some(match result {
                None => inside,
                Some(before) => before.intersection(&inside, before.rounding(&inside)),
            });
        }
        Ok(Line { inside: result.unwrap_or_else(Intervals::empty), crossings: Vec::new() })
    }

    fn subtract(&mut self, first: NodeId, others: &[NodeId], here: &Here) -> Result<Line, Fault> {
        let mut result = self.solid_operand(first, 0, here)?;
        for (number, operand) in others.iter().enumerate() {
            let inside = self.solid_operand(*operand, number + 1, here)?;
            result = result.difference(&inside, result.rounding(&inside));
        }
        Ok(Line { inside: result, crossings: Vec::new() })
    }

    /// An operand of `&` or `\`: it must have an inside.
    fn solid_operand(&mut self, operand: NodeId, number: usize, here: &Here) -> Result<Intervals<u32>, Fault> {
        let mut here = here.operand(number);
        here.frozen = true;
        here.booleans += 1;
        if here.booleans > self.limits.booleans {
            return Err(limit(Limit::Booleans, self.limits.booleans.into(), Origin::NONE));
        }
        let line = self.pass(operand, here)?;
        match line.crossings.first() {
            None => Ok(line.inside),
            Some((_, surface)) => {
                let surface = &self.surfaces[*surface as usize];
                Err(Fault::new(FaultKind::Open(surface.primitive.kind()), surface.origin))
            }
        }
    }

    /// Whether the ray starts on a part of what is here, and goes through the whole of it.
    fn goes_through(&self, here: &Here) -> bool {
        self.from.is_some_and(|it| it.is_through() && it.path.starts_with(&here.site))
    }

    /// Whether the ray starts in one of these operands at a place, and goes through the solid there.
    fn goes_into(&self, site: &[u32], operands: Range<usize>) -> bool {
        let Some(from) = self.from.filter(|it| it.is_through() && it.path.starts_with(site)) else { return false };
        from.path.part(site.len()).is_some_and(|it| operands.contains(&(it as usize)))
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        bark: Option<&Bark>,
        origin: Origin,
        here: &Here,
    ) -> Result<Line, Fault> {
        let rind = bark.map(|it| it.rind);
        self.steps += 1 + here.site.len() as u64 / PLACES;
        if self.steps > self.limits.steps {
            return Err(limit(Limit::Steps, self.limits.steps, Origin::NONE));
        }
        if self.goes_through(here) {
            return Ok(Line::empty());
        }
        let from = self.from.filter(|it| it.path.parts().eq(here.site.iter().copied())).map(|it| it.face);
        let mut line = Line::empty();
        if primitive.is_solid() {
            let mut chords = match bark.and_then(Bark::relief) {
                Some(relief) => relief.chords(&here.ray, from),
                None => primitive.chords(&here.ray, from),
            };
            // What is cut by others is not carved; neither is what the ray starts on, since that lies below its planes.
            if let Some(set) = primitive.hull().filter(|_| !here.frozen && from.is_none())
                && let Some(rough) = self.roughs.of(here.material)
            {
                chords = chords.into_iter().filter_map(|it| rough.left(&set.whole(), &here.ray, it)).collect();
            }
            line.inside = Intervals::of_chords(&chords, |it| self.surface((primitive, rind), origin, here, it.face));
        }
        for crossing in primitive.crossings(&here.ray, from) {
            line.crossings.push((crossing.t, self.surface((primitive, rind), origin, here, crossing.face)));
        }
        Ok(line)
    }

    /// Where a paint stands, if its look depends on that.
    fn standing(&self, material: MaterialId, here: &Here) -> Option<Rc<Standing>> {
        let standing = || Rc::new(Standing { ray: here.ray, chain: Rc::clone(&here.chain) });
        self.scene.is_painted_in_place(material).then(standing)
    }

    /// Notes a surface that was met, and gives it a number.
    fn surface(
        &mut self,
        (primitive, rind): (&Primitive, Option<Rind>),
        origin: Origin,
        here: &Here,
        face: u32,
    ) -> u32 {
        self.surfaces.push(Surface {
            primitive: primitive.clone(),
            origin,
            material: here.material,
            standing: here.standing.clone(),
            rind,
            route: here.route,
            ray: here.ray,
            chain: Rc::clone(&here.chain),
            site: Site { path: here.site.iter().copied().collect(), face },
            carved: primitive.hull().is_some() && !here.frozen,
        });
        self.surfaces.len() as u32 - 1
    }
}

/// Passes the ray to the parts of a shape.
struct Parts<'p, 'w, 's> {
    walk: &'p mut Walk<'w, 's>,
    here: &'p Here,
    lines: Vec<Line>,
}

impl Parts<'_, '_, '_> {
    /// Where the next part is.
    fn next(&self, system_from_part: &DAffine3, material: Option<MaterialId>, route: Route) -> Here {
        let mut here = self.here.operand(self.lines.len());
        let inner_from_outer = system_from_part.inverse();
        here.ray = here.ray.mapped(&inner_from_outer);
        here.chain = Rc::new(Chain::Transform { inner_from_outer, outer: Rc::clone(&here.chain) });
        if let Some(material) = material {
            // A paint that a walk gives stands where the plant does.
            here.material = Some(material);
            here.standing = self.walk.standing(material, self.here);
        }
        if !here.frozen {
            here.route = here.route.then(route);
        }
        here
    }
}

impl shapes::Taker for Parts<'_, '_, '_> {
    fn placed(&mut self, placed: Placed<'_>) -> Result<(), Fault> {
        let (system_from_frame, route) = shapes::way(&placed);
        let mut here = self.next(&system_from_frame, placed.material, route);
        here.env = placed.env.clone();
        let line = self.walk.pass(placed.solid, here)?;
        self.lines.push(line);
        Ok(())
    }

    fn stem(&mut self, stem: &Stem, joints: &Joints) -> Result<(), Fault> {
        let first = self.lines.len();
        shapes::each_part(self, stem, joints)?;
        if self.walk.goes_into(&self.here.site, first..self.lines.len()) {
            // A ray that goes through a part of it goes through all.
            self.lines[first..].fill_with(Line::empty);
        }
        Ok(())
    }

    fn part(&mut self, part: Part, route: Route) -> Result<(), Fault> {
        let here = self.next(&part.stem_from_part, part.material, route);
        let on_stems = here.material.is_some_and(|it| self.walk.scene.is_painted_on_stems(it));
        let hide = here.material.and_then(|it| self.walk.hides.get(it.0 as usize)?.clone());
        let bark = part.rind.filter(|_| on_stems).map(|rind| Bark { rind, hide });
        let line = self.walk.primitive(&part.primitive, bark.as_ref(), part.origin, &here)?;
        self.lines.push(line);
        Ok(())
    }

    fn hull(&mut self, hull: shapes::Hull) -> Result<(), Fault> {
        let here = self.next(&DAffine3::IDENTITY, hull.material, Route::START);
        let line = self.walk.primitive(&hull.primitive, None, hull.origin, &here)?;
        self.lines.push(line);
        Ok(())
    }
}

fn limit(limit: Limit, most: u64, origin: Origin) -> Fault {
    Fault::new(FaultKind::Limit { limit, most }, origin)
}

fn union(lines: Vec<Line>) -> Line {
    let inside: Vec<Intervals<u32>> = lines.iter().map(|it| it.inside.clone()).collect();
    Line {
        inside: Intervals::union_of(&inside, 0.0),
        crossings: lines.into_iter().flat_map(|it| it.crossings).collect(),
    }
}

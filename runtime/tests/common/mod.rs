//! Scenes built by hand for the tests of the runtime.
#![allow(clippy::expect_used, clippy::panic, reason = "a test that cannot go on has failed")]
#![allow(dead_code, reason = "each test program uses its own part of this")]

use glam::DVec3;
use treegen_runtime::form::{
    Background, BinaryOp, Call, Choice, Code, Draw, Graph, ImageSettings, MaterialId, Node, NodeId, Op, Origin,
    PrimitiveKind, Reg, Rule, Scene, Select, SelectId, Slot, System, SystemId, TransformKind, Value,
};
use treegen_runtime::geometry::Ray;
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::trace::{Beam, Fragment, Seen, Tracer};

/// A code that gives these numbers.
pub(crate) fn numbers(values: &[f64]) -> Code {
    Code {
        ops: values.iter().enumerate().map(|(n, it)| Op::Constant(Reg(n as u16), Value::Number(*it))).collect(),
        origins: values.iter().map(|_| Origin::NONE).collect(),
        registers: values.len() as u16,
        results: (0..values.len() as u16).map(Reg).collect(),
    }
}

/// The code `slot op number`.
pub(crate) fn slot_and(slot: Slot, op: BinaryOp, number: f64) -> Code {
    let (a, b, c) = (Reg(0), Reg(1), Reg(2));
    let ops = Box::new([Op::Load(a, slot), Op::Constant(b, Value::Number(number)), Op::Binary(c, op, a, b)]);
    Code { origins: Box::new([Origin::NONE; 3]), registers: 3, results: Box::new([c]), ops }
}

/// The code `random(low, high)`, followed by more numbers.
pub(crate) fn random(low: f64, high: f64, place: u64) -> Code {
    let (a, b, c) = (Reg(0), Reg(1), Reg(2));
    let ops = Box::new([
        Op::Constant(a, Value::Number(low)),
        Op::Constant(b, Value::Number(high)),
        Op::Draw { to: c, draw: Draw::Uniform, args: Box::new([a, b]), place },
    ]);
    Code { origins: Box::new([Origin::NONE; 3]), registers: 3, results: Box::new([c]), ops }
}

/// Builds graphs node by node.
#[derive(Default)]
pub(crate) struct Builder {
    pub(crate) nodes: Vec<Node>,
    pub(crate) selects: Vec<Select>,
}

impl Builder {
    pub(crate) fn add(&mut self, node: Node) -> NodeId {
        self.nodes.push(node);
        NodeId(self.nodes.len() as u32 - 1)
    }

    pub(crate) fn primitive(&mut self, kind: PrimitiveKind, params: &[f64]) -> NodeId {
        // Every primitive has a place of its own, so that pictures can be compared by it.
        let start = self.nodes.len() as u32;
        self.add(Node::Primitive { kind, code: numbers(params), origin: Origin { file: 0, start, end: start + 1 } })
    }

    pub(crate) fn transform(&mut self, kind: TransformKind, params: &[f64], body: NodeId) -> NodeId {
        self.add(Node::Transform { kind, code: numbers(params), body, origin: Origin::NONE })
    }

    pub(crate) fn transform_by(&mut self, kind: TransformKind, code: Code, body: NodeId) -> NodeId {
        self.add(Node::Transform { kind, code, body, origin: Origin::NONE })
    }

    pub(crate) fn union(&mut self, operands: &[NodeId]) -> NodeId {
        self.add(Node::Union(operands.into()))
    }

    pub(crate) fn paint(&mut self, material: u32, body: NodeId) -> NodeId {
        self.add(Node::Paint { material: MaterialId(material), body })
    }

    /// A call of a module of one parameter.
    pub(crate) fn call(&mut self, select: u32, args: Code) -> NodeId {
        let place = self.nodes.len() as u64 + 1;
        self.add(Node::Call(Call { select: SelectId(select), args, place, origin: Origin::NONE }))
    }

    /// A module of one parameter (slot 0) with two rules: `stop` when it is 0, else `go`.
    pub(crate) fn module(&mut self, stop: NodeId, go: NodeId) -> u32 {
        let guard = Some(slot_and(Slot(0), BinaryOp::LessEqual, 0.0));
        let rule = |guard, body| Rule { label: None, guard, weight: None, body, origin: Origin::NONE };
        self.selects.push(Select {
            module: format!("M{}", self.selects.len()),
            system: SystemId(0),
            params: vec![Slot(0)],
            choice: Choice::First,
            rules: vec![rule(guard, stop), rule(None, go)],
            proxy: None,
            origin: Origin::NONE,
        });
        self.selects.len() as u32 - 1
    }

    /// The scene that shows `start`, with one slot `c`.
    pub(crate) fn scene(self, start: NodeId) -> Scene {
        let system = System {
            name: "scene".into(),
            slots: vec!["c".into(), "i".into()],
            formals: Vec::new(),
            lets: Code::default(),
            vars: Code::default(),
            start,
            origin: Origin::NONE,
        };
        let graph = Graph::new(self.nodes, self.selects, vec![system], Vec::new(), SystemId(0));
        scene_of(graph.expect("the parts fit together"))
    }
}

/// A scene with a graph and nothing else.
pub(crate) fn scene_of(graph: Graph) -> Scene {
    Scene {
        graph,
        seed: 1,
        materials: Vec::new(),
        textures: Vec::new(),
        camera: None,
        suns: Vec::new(),
        sky: None,
        image: ImageSettings { background: Background::Sky, ..ImageSettings::default() },
    }
}

/// The Sierpinski tetrahedron of an order (GT95, figure 2).
pub(crate) fn sierpinski(order: f64) -> Scene {
    let mut b = Builder::default();
    let stop = b.primitive(PrimitiveKind::Tetrahedron, &[]);
    let mut parts = Vec::new();
    for [x, y, z] in [[0.5, 0.5, 0.5], [-0.5, -0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5]] {
        let call = b.call(0, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
        let scaled = b.transform(TransformKind::UScale, &[0.5], call);
        parts.push(b.transform(TransformKind::Move, &[x, y, z], scaled));
    }
    let go = b.union(&parts);
    b.module(stop, go);
    let start = b.call(0, numbers(&[order]));
    b.scene(start)
}

/// The Menger sponge of an order: of each 27 cubes 20.
pub(crate) fn menger(order: f64) -> Scene {
    let mut b = Builder::default();
    let stop = b.primitive(PrimitiveKind::Box, &[]);
    let mut parts = Vec::new();
    for index in 0..27 {
        let place = [index % 3, index / 3 % 3, index / 9].map(|it| f64::from(it - 1));
        if place.iter().filter(|it| **it == 0.0).count() < 2 {
            let call = b.call(0, slot_and(Slot(0), BinaryOp::Subtract, 1.0));
            let scaled = b.transform(TransformKind::UScale, &[1.0 / 3.0], call);
            parts.push(b.transform(TransformKind::Move, &place.map(|it| it * 2.0 / 3.0), scaled));
        }
    }
    let go = b.union(&parts);
    b.module(stop, go);
    let start = b.call(0, numbers(&[order]));
    b.scene(start)
}

/// Numbers for scenes made at random: a sequence of its own for each seed.
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A scene made at random: modules that name each other through nested rotated, scaled, sheared and mirrored unions, intersections
/// and differences, to a small order.
pub(crate) fn random_scene(seed: u64) -> Scene {
    let mut dice = Dice(seed);
    let mut b = Builder::default();
    let modules = 1 + dice.below(3) as u32;
    for _ in 0..modules {
        let stop = random_solid(&mut dice, &mut b, 2, None);
        let mut calls = 3;
        let go = random_union(&mut dice, &mut b, modules, &mut calls);
        b.module(stop, go);
    }
    let order = dice.below(5) as f64;
    let start = b.call(0, numbers(&[order]));
    b.scene(start)
}

fn random_union(dice: &mut Dice, b: &mut Builder, modules: u32, calls: &mut u32) -> NodeId {
    let count = 1 + dice.below(3);
    let parts: Vec<NodeId> = (0..count).map(|_| random_solid(dice, b, 2, Some((modules, &mut *calls)))).collect();
    b.union(&parts)
}

fn random_solid(dice: &mut Dice, b: &mut Builder, height: u32, mut modules: Option<(u32, &mut u32)>) -> NodeId {
    let inner = |dice: &mut Dice, b: &mut Builder, modules: &mut Option<(u32, &mut u32)>| {
        let again = modules.as_mut().map(|(count, calls)| (*count, &mut **calls));
        random_solid(dice, b, height - 1, again)
    };
    let body = match dice.below(if height == 0 { 2 } else { 6 }) {
        0 => {
            let kinds = [
                (PrimitiveKind::Sphere, vec![]),
                (PrimitiveKind::Cylinder, vec![]),
                (PrimitiveKind::Box, vec![]),
                (PrimitiveKind::Tetrahedron, vec![]),
                (PrimitiveKind::Cone, vec![dice.between(0.2, 1.0), dice.between(0.0, 1.0)]),
                (PrimitiveKind::Torus, vec![dice.between(0.1, 0.6)]),
                (PrimitiveKind::Ellipsoid, vec![dice.between(0.3, 1.0), 1.0, dice.between(0.3, 1.0)]),
            ];
            let (kind, params) = &kinds[dice.below(kinds.len())];
            b.primitive(*kind, params)
        }
        1 => match &mut modules {
            Some((count, calls)) if **calls > 0 => {
                **calls -= 1;
                let select = dice.below(*count as usize) as u32;
                b.call(select, slot_and(Slot(0), BinaryOp::Subtract, 1.0))
            }
            _ => b.primitive(PrimitiveKind::Sphere, &[]),
        },
        2 | 3 => {
            let parts = [inner(dice, b, &mut modules), inner(dice, b, &mut modules)];
            b.union(&parts)
        }
        4 => {
            let parts = [inner(dice, b, &mut modules), inner(dice, b, &mut modules)];
            b.add(Node::Intersect(parts.into()))
        }
        _ => {
            let (first, other) = (inner(dice, b, &mut modules), inner(dice, b, &mut modules));
            b.add(Node::Difference(first, [other].into()))
        }
    };
    random_transform(dice, b, body)
}

fn random_transform(dice: &mut Dice, b: &mut Builder, body: NodeId) -> NodeId {
    let mut angle = || dice.between(-180.0, 180.0);
    let angles = [angle(), angle()];
    let turned = match dice.below(5) {
        0 => b.transform(TransformKind::RotX, &angles[..1], body),
        1 => b.transform(TransformKind::Rotate, &[1.0, 0.3, -0.5, angles[0]], body),
        2 => b.transform(TransformKind::Mirror, &[0.2, 1.0, 0.4], body),
        3 => b.transform(TransformKind::ZShear, &[dice.between(-0.5, 0.5), dice.between(-0.5, 0.5)], body),
        _ => body,
    };
    let scaled = match dice.below(3) {
        0 => b.transform(TransformKind::UScale, &[dice.between(0.4, 0.8)], turned),
        1 => {
            let factors = [dice.between(0.3, 0.8), dice.between(0.3, 0.8), dice.between(0.3, 0.8)];
            b.transform(TransformKind::Scale, &factors, turned)
        }
        _ => b.transform_by(TransformKind::UScale, random(0.4, 0.7, dice.next()), turned),
    };
    let offset = [dice.between(-0.6, 0.6), dice.between(-0.6, 0.6), dice.between(-0.6, 0.6)];
    b.transform(TransformKind::Move, &offset, scaled)
}

/// Gives the nodes that a node names other numbers.
pub(crate) fn rename(node: &mut Node, renamed: &[NodeId]) {
    let new = |id: &mut NodeId| *id = renamed[id.0 as usize];
    match node {
        Node::Empty | Node::Primitive { .. } | Node::Call(_) | Node::System(_) | Node::Shape(_) => {}
        Node::Transform { body, .. }
        | Node::Calc { body, .. }
        | Node::Paint { body, .. }
        | Node::Variant { body, .. }
        | Node::Repeat { body, .. } => new(body),
        Node::Choice { then, otherwise, .. } => [then, otherwise].into_iter().for_each(new),
        Node::Union(operands) | Node::Intersect(operands) => operands.iter_mut().for_each(new),
        Node::Difference(first, others) => {
            new(first);
            others.iter_mut().for_each(new);
        }
    }
}

/// A bundle of rays that fills a square around the origin, seen along a direction off every axis.
pub(crate) fn ray_bundle(side: u32, half_width: f64) -> Vec<Ray> {
    let forward = DVec3::new(-0.53, 0.71, -0.29).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let at = |it: u32| (f64::from(it) + 0.5) / f64::from(side) * 2.0 - 1.0;
    let mut rays = Vec::new();
    for row in 0..side {
        for column in 0..side {
            let aside = (right * at(column) + up * at(row)) * half_width;
            // Not quite parallel, so that no two rays have one direction.
            let direction = forward + aside * 0.03;
            rays.push(Ray { origin: aside - forward * 9.0, direction });
        }
    }
    rays
}

/// What one ray saw.
pub(crate) type Sample = Vec<Fragment>;

/// What a tracer sees.
pub(crate) fn look(tracer: &dyn Tracer, rays: &[Ray]) -> Vec<Sample> {
    let mut seen = Seen::default();
    let beams: Vec<Beam> = rays.iter().copied().map(Beam::thin).collect();
    tracer.look(&beams, &mut seen).expect("these scenes have no faults");
    seen.rays().map(<[Fragment]>::to_vec).collect()
}

/// Whether the reference itself sees the same from a hair's breadth beside each ray: only there a difference counts.
pub(crate) fn is_steady(reference: &Reference, ray: &Ray) -> bool {
    let beside = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let mut rays = vec![*ray];
    rays.extend(beside.map(|it| Ray { origin: ray.origin + it * 4e-6, ..*ray }));
    let seen = look(reference, &rays);
    let what = |it: &Sample| it.first().map(|it| (it.origin, it.route, it.site.clone()));
    seen.iter().all(|it| what(it) == what(&seen[0]))
}

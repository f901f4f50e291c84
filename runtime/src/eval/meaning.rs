//! What the nodes of a graph mean in an environment: the numbers of a T-node, the rule of an S-node, the environment below a call.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use smallvec::SmallVec;

use super::operation;
use super::path::mix;
use super::{Env, Machine, Path, angle, quick};
use crate::fault::{Fault, FaultKind, Limit, TrailStep};
use crate::form::{
    Call, Choice, Code, Graph, Origin, PrimitiveKind, Reg, Select, Slot, System, SystemCall, TransformKind, Value,
};

/// The numbers a code gives.
pub(crate) type Numbers = SmallVec<[f64; 12]>;

impl Env {
    /// Goes into a copy of a `repeat`.
    #[inline]
    pub(crate) fn turn(&mut self, index: Slot, number: u32) {
        quick::put(&mut self.slots[usize::from(index.0)], false, f64::from(number));
        self.turn = mix(self.turn, u64::from(number) + 1);
    }

    /// Goes below `variant(count)`: the path becomes one of so many.
    pub(crate) fn fold(&mut self, count: u32) {
        let number = mix(mix(self.path.0, self.path.1), self.turn) % u64::from(count.max(1));
        self.path = Path::default().joined(0x7661_7269_616e_7400, number);
        self.turn = 0;
    }
}

// These take the environment to change it only where a code assigns, which only those of C-nodes do.
impl Machine<'_> {
    /// All results of a code, which are numbers.
    pub(crate) fn numbers(&mut self, code: &Code, env: &mut Env, operation: &'static str) -> Result<Numbers, Fault> {
        self.run_here(code, env)?;
        code.results.iter().map(|it| self.number(code, *it, operation)).collect()
    }

    pub(super) fn number(&self, code: &Code, result: Reg, operation: &'static str) -> Result<f64, Fault> {
        match self.result(result) {
            Value::Number(number) => Ok(*number),
            other => operation::number(other, operation).map_err(|it| it.at(last(code))),
        }
    }

    /// The truth of a code's one result.
    #[inline]
    pub(crate) fn truth(&mut self, code: &Code, env: &mut Env) -> Result<bool, Fault> {
        self.run_here(code, env)?;
        let truth = |it: &Reg| operation::truth(self.result(*it)).map_err(|it| it.at(last(code)));
        code.results.first().map_or(Ok(false), truth)
    }

    /// Goes below a C-node.
    #[inline]
    pub(crate) fn calculate(&mut self, code: &Code, env: &mut Env) -> Result<(), Fault> {
        self.run_here(code, env)
    }

    /// A whole number that is at least `least` and at most `most`.
    pub(crate) fn whole(
        &mut self,
        code: &Code,
        env: &mut Env,
        what: &'static str,
        least: u32,
        origin: Origin,
    ) -> Result<u32, Fault> {
        let value = self.numbers(code, env, what)?.first().copied().unwrap_or(0.0);
        whole(value, what, least, self.limits().repeat, origin).map_err(|it| of_value(code, it))
    }

    /// The matrix of a T-node: it maps points of the frame below to the frame above.
    ///
    /// # Errors
    /// When it has no inverse.
    pub(crate) fn transform(
        &mut self,
        kind: TransformKind,
        code: &Code,
        env: &mut Env,
        origin: Origin,
    ) -> Result<DAffine3, Fault> {
        let values = self.numbers(code, env, kind.name())?;
        matrix(kind, &values)
            .filter(|it| it.is_finite() && it.inverse().is_finite())
            .ok_or_else(|| Fault::new(FaultKind::Singular { kind, values: values.to_vec() }, origin))
    }

    /// The numbers of a primitive.
    pub(crate) fn primitive(&mut self, kind: PrimitiveKind, code: &Code, env: &mut Env) -> Result<Numbers, Fault> {
        self.numbers(code, env, kind.name())
    }

    /// The environment in which a module's rules stand.
    pub(crate) fn enter(&mut self, graph: &Graph, call: &Call, env: &mut Env) -> Result<Env, Fault> {
        let args = self.run(&call.args, env)?;
        let mut inner = env.clone();
        for (slot, value) in graph.select(call.select).params.iter().zip(args) {
            inner.slots[usize::from(slot.0)] = value;
        }
        inner.path = env.path.joined(call.place, env.turn);
        inner.turn = 0;
        Ok(inner)
    }

    /// Which of its rules an S-node selects.
    pub(crate) fn choose(&mut self, graph: &Graph, select: &Select, env: &mut Env) -> Result<usize, Fault> {
        match &select.choice {
            Choice::First => {
                for (number, rule) in select.rules.iter().enumerate() {
                    if rule.guard.as_ref().map_or(Ok(true), |it| self.truth(it, env))? {
                        return Ok(number);
                    }
                }
                Err(no_rule(graph, select, env))
            }
            Choice::Weighted(place) => self.choose_by_weight(graph, select, env, *place),
            Choice::Function(code) => {
                let number = self.run(code, env)?.first().cloned().unwrap_or(Value::Number(0.0));
                match number {
                    Value::Number(it) if it.fract() == 0.0 && it >= 1.0 && it <= select.rules.len() as f64 => {
                        Ok(it as usize - 1)
                    }
                    number => {
                        let origin = code.origins.last().copied().unwrap_or(select.origin);
                        let (module, rules) = (select.module.clone(), select.rules.len());
                        Err(Fault::new(FaultKind::NoSuchRule { module, number, rules }, origin))
                    }
                }
            }
        }
    }

    fn choose_by_weight(&mut self, graph: &Graph, select: &Select, env: &mut Env, place: u64) -> Result<usize, Fault> {
        let mut weights = Vec::new();
        for (number, rule) in select.rules.iter().enumerate() {
            if rule.guard.as_ref().map_or(Ok(true), |it| self.truth(it, env))? {
                let weight = match &rule.weight {
                    Some(code) => self.numbers(code, env, "@")?.first().copied().unwrap_or(0.0),
                    None => 1.0,
                };
                weights.push((number, weight));
            }
        }
        if weights.is_empty() {
            return Err(no_rule(graph, select, env));
        }
        drawn(&weights, self.draw(env, 0, place)).ok_or_else(|| {
            let weights = weights.iter().map(|it| it.1).collect();
            Fault::new(FaultKind::Weights { module: select.module.clone(), weights }, select.origin)
        })
    }

    /// The environment in which a system starts.
    pub(crate) fn enter_system(&mut self, graph: &Graph, call: &SystemCall, env: &mut Env) -> Result<Env, Fault> {
        let args = self.run(&call.args, env)?;
        let path = match &call.seed {
            None => env.path.joined(call.place, env.turn),
            Some(seed) => Path::from_seed(self.numbers(seed, env, "seed")?.first().copied().unwrap_or(0.0)),
        };
        let system = graph.system(call.system);
        let mut inner = Env { slots: vec![Value::Number(0.0); system.slots.len()], path, turn: 0 };
        let mut given = vec![false; system.slots.len()];
        for (slot, value) in call.given.iter().zip(args) {
            inner.slots[usize::from(slot.0)] = value;
            given[usize::from(slot.0)] = true;
        }
        self.fill(system, inner, &given).map_err(|it| given_by(call, system, it))
    }

    /// The environment in which the graph starts.
    pub(crate) fn root(&mut self, graph: &Graph) -> Result<Env, Fault> {
        let system = graph.system(graph.root());
        let slots = vec![Value::Number(0.0); system.slots.len()];
        let given = vec![false; system.slots.len()];
        self.fill(system, Env { slots, path: Path::default(), turn: 0 }, &given)
    }

    /// Gives the formals that were not given their defaults, looks at the ranges, and finds `let`s and state.
    fn fill(&mut self, system: &System, mut env: Env, given: &[bool]) -> Result<Env, Fault> {
        for formal in &system.formals {
            let slot = usize::from(formal.slot.0);
            if let (false, Some(default)) = (given[slot], &formal.default)
                && let Some(value) = self.run(default, &mut env)?.into_iter().next()
            {
                env.slots[slot] = value;
            }
            if let Some(check) = &formal.check {
                self.run(check, &mut env)?;
            }
        }
        self.run(&system.lets, &mut env)?;
        self.run(&system.vars, &mut env)?;
        Ok(env)
    }
}

/// Which of some numbered weights a uniform number from 0 to 1 falls to; one of 0 never wins. `None` if they cannot be drawn
/// from.
pub(crate) fn drawn(weights: &[(usize, f64)], uniform: f64) -> Option<usize> {
    let largest = weights.iter().fold(0.0, |largest: f64, it| if it.1 > largest { it.1 } else { largest });
    if !largest.is_finite() || largest <= 0.0 || weights.iter().any(|it| it.1.is_nan() || it.1 < 0.0) {
        return None;
    }
    // Divided by the largest, so that no sum overflows or vanishes.
    let total: f64 = weights.iter().map(|it| it.1 / largest).sum();
    let mut rest = uniform * total;
    let mut chosen = None;
    for (number, weight) in weights.iter().filter(|it| it.1 > 0.0) {
        chosen = Some(*number);
        rest -= weight / largest;
        if rest < 0.0 {
            break;
        }
    }
    chosen
}

/// The whole number that a value is: at least `least` and at most `most`.
pub(super) fn whole(value: f64, what: &'static str, least: u32, most: u32, origin: Origin) -> Result<u32, Fault> {
    let number = value as u32;
    if f64::from(number) == value && (least..=most).contains(&number) {
        return Ok(number);
    }
    if value.fract() != 0.0 || value < f64::from(least) {
        return Err(Fault::new(FaultKind::Whole { what, value, least: f64::from(least) }, origin));
    }
    Err(Fault::new(FaultKind::Limit { limit: Limit::Repeat, most: u64::from(most) }, origin))
}

/// Of a number that is not whole the place is that of the number.
pub(super) fn of_value(code: &Code, fault: Fault) -> Fault {
    let place = code.results.first().and_then(|it| code.origin_of(*it)).filter(|it| *it != Origin::NONE);
    match (&fault.kind, place) {
        (FaultKind::Whole { .. }, Some(origin)) => Fault { origin, ..fault },
        _ => fault,
    }
}

/// Of an argument outside its range the place is the argument's.
fn given_by(call: &SystemCall, system: &System, fault: Fault) -> Fault {
    let FaultKind::Range { name, value, low, high, .. } = &fault.kind else { return fault };
    let is_it = |it: &Slot| system.slots.get(usize::from(it.0)).is_some_and(|it| **it == **name);
    let Some(number) = call.given.iter().position(is_it) else { return fault };
    let place = call.args.results.get(number).and_then(|it| call.args.origin_of(*it)).unwrap_or(call.origin);
    let kind = FaultKind::Range { name: Arc::clone(name), value: *value, low: *low, high: *high, range: fault.origin };
    Fault { kind, origin: place, ..fault }
}

/// The place of the last operation of a code.
fn last(code: &Code) -> Origin {
    code.origins.last().copied().unwrap_or(Origin::NONE)
}

/// The step of a fault's trail that stands for an S-node in an environment.
pub(crate) fn trail_step(graph: &Graph, select: &Select, env: &Env, origin: Origin) -> TrailStep {
    TrailStep { name: select.module.clone(), values: told(graph, select, env), origin }
}

/// What tells an S-node from another one of its module: its parameters with their values, and what its choice reads besides.
fn told(graph: &Graph, select: &Select, env: &Env) -> Vec<(String, Value)> {
    let names = &graph.system(select.system).slots;
    let slots = select.told().into_iter().map(|it| usize::from(it.0));
    slots.filter_map(|it| Some((names.get(it)?.clone(), env.slots.get(it)?.clone()))).collect()
}

fn no_rule(graph: &Graph, select: &Select, env: &Env) -> Fault {
    let values = told(graph, select, env);
    Fault::new(FaultKind::NoRule { module: select.module.clone(), values }, select.origin)
}

/// The matrix of a kind of transformation; `None` where the numbers make none.
pub(crate) fn matrix(kind: TransformKind, values: &[f64]) -> Option<DAffine3> {
    let linear = |x: [f64; 3], y: [f64; 3], z: [f64; 3]| {
        DAffine3::from_mat3(DMat3::from_cols(DVec3::from(x), DVec3::from(y), DVec3::from(z)))
    };
    let affine = match (kind, values) {
        (TransformKind::Move, [x, y, z]) => DAffine3::from_translation(DVec3::new(*x, *y, *z)),
        (TransformKind::RotX, [angle]) => {
            let (s, c) = angle::sin_cos(*angle);
            linear([1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c])
        }
        (TransformKind::RotY, [angle]) => {
            let (s, c) = angle::sin_cos(*angle);
            linear([c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c])
        }
        (TransformKind::RotZ, [angle]) => {
            let (s, c) = angle::sin_cos(*angle);
            linear([c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0])
        }
        (TransformKind::Rotate, [x, y, z, angle]) => DAffine3::from_mat3(rotation(unit(*x, *y, *z)?, *angle)),
        (TransformKind::Scale, [x, y, z]) => DAffine3::from_scale(DVec3::new(*x, *y, *z)),
        (TransformKind::UScale, [factor]) => DAffine3::from_scale(DVec3::splat(*factor)),
        (TransformKind::Mirror, [x, y, z]) => {
            let n = unit(*x, *y, *z)?;
            let column = |axis: DVec3| axis - n * (2.0 * n.dot(axis));
            DAffine3::from_mat3(DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z)))
        }
        (TransformKind::ZShear, [dx, dy]) => linear([1.0, 0.0, *dx], [0.0, 1.0, *dy], [0.0, 0.0, 1.0]),
        (TransformKind::Matrix, [a, b, c, x, d, e, f, y, g, h, i, z]) => {
            let mut affine = linear([*a, *d, *g], [*b, *e, *h], [*c, *f, *i]);
            affine.translation = DVec3::new(*x, *y, *z);
            affine
        }
        _ => return None,
    };
    Some(affine)
}

/// The direction of a vector; `None` when it has none.
pub(crate) fn unit(x: f64, y: f64, z: f64) -> Option<DVec3> {
    let vector = DVec3::new(x, y, z);
    // Scaled first, so that no square overflows or vanishes.
    let largest = vector.abs().max_element();
    (largest > 0.0 && largest.is_finite()).then(|| (vector / largest).normalize())
}

/// The rotation by an angle in degrees about a unit axis (Rodrigues).
pub(crate) fn rotation(axis: DVec3, degrees: f64) -> DMat3 {
    rotation_by(axis, angle::sin_cos(degrees))
}

/// The same by an angle of which sine and cosine are known.
pub(crate) fn rotation_by(axis: DVec3, (s, c): (f64, f64)) -> DMat3 {
    let column = |v: DVec3| v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

impl TransformKind {
    /// Its name in the language.
    pub fn name(self) -> &'static str {
        match self {
            Self::Move => "move",
            Self::RotX => "rotx",
            Self::RotY => "roty",
            Self::RotZ => "rotz",
            Self::Rotate => "rotate",
            Self::Scale => "scale",
            Self::UScale => "uscale",
            Self::Mirror => "mirror",
            Self::ZShear => "zshear",
            Self::Matrix => "matrix",
        }
    }
}

impl PrimitiveKind {
    /// Its name in the language.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
            Self::Box => "box",
            Self::Tetrahedron => "tetrahedron",
            Self::Torus => "torus",
            Self::Triangle => "triangle",
            Self::HalfSpace => "halfspace",
            Self::Ellipsoid => "ellipsoid",
            Self::Hyperboloid => "hyperboloid",
            Self::Paraboloid => "paraboloid",
            Self::Quadric => "quadric",
            Self::Segment => "segment",
            Self::Hull => "hull",
            Self::Mesh { .. } => "mesh",
        }
    }
}

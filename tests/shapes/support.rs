//! Programs derived, for these tests.

use glam::DVec3;
use treegen_runtime::derive::{Deriver, Placed, Recorder, Step, Watcher};
use treegen_runtime::form::{Scene, Segment, SegmentList, Shape, Value};
use treegen_runtime::trace::find_shape;
use treegen_runtime::{Fault, Limits};

use crate::common::scene;

/// What the first shape of a program derives to.
pub(crate) struct Derived {
    pub(crate) list: SegmentList,
    /// Each rule that was applied, in order: `module(values)`, or `label` where the rule has one.
    pub(crate) steps: Vec<String>,
    /// Where solids were placed, in order.
    pub(crate) solids: Vec<DVec3>,
}

struct Watch<'s> {
    scene: &'s Scene,
    recorder: Recorder,
    solids: Vec<DVec3>,
}

impl Watcher for Watch<'_> {
    fn placed(&mut self, placed: Placed<'_>) -> Result<(), Fault> {
        self.solids.push(placed.system_from_frame.translation);
        Ok(())
    }

    fn applied(&mut self, shape: &Shape, step: &Step, values: &dyn Fn(usize) -> Value) {
        self.recorder.applied(shape, step, values);
    }
}

/// Derives the first shape of a program, under these limits.
pub(crate) fn derived_within(text: &str, limits: &Limits) -> Result<Derived, Fault> {
    let scene = scene(text);
    let found = find_shape(&scene, &Limits::default(), None).expect("the scene expands").expect("there is a shape");
    let mut watch = Watch { scene: &scene, recorder: Recorder::default(), solids: Vec::new() };
    let list = Deriver::new(&scene.graph, scene.seed, limits).derive(found.shape, &found.env, &mut watch)?;
    let shape = watch.scene.graph.shape(found.shape);
    let steps = watch.recorder.steps.iter().filter_map(|it| {
        let (module, rule) = it.step.rule?;
        let module = &shape.modules[module];
        if let Some(label) = &module.rules[rule].label {
            return Some(label.clone());
        }
        let values = it.values[..module.params.len()].iter().map(number).collect::<Vec<String>>();
        Some(if values.is_empty() { module.name.clone() } else { format!("{}({})", module.name, values.join(", ")) })
    });
    Ok(Derived { steps: steps.collect(), list, solids: watch.solids })
}

/// Derives the first shape of a program.
pub(crate) fn derived(text: &str) -> Derived {
    derived_within(text, &Limits::default()).unwrap_or_else(|fault| panic!("{fault:?}"))
}

/// The fault that a derivation ends with.
pub(crate) fn fault(text: &str) -> Fault {
    fault_within(text, &Limits::default())
}

/// The same under these limits.
pub(crate) fn fault_within(text: &str, limits: &Limits) -> Fault {
    match derived_within(text, limits) {
        Ok(_) => panic!("this should not come to its end:\n{text}"),
        Err(fault) => fault,
    }
}

fn number(value: &Value) -> String {
    match value {
        Value::Number(it) => it.to_string(),
        other => format!("{other:?}"),
    }
}

impl Derived {
    /// All segments, stem after stem.
    pub(crate) fn segments(&self) -> Vec<&Segment> {
        self.list.stems().iter().flat_map(|it| self.list.segments(it)).collect()
    }

    /// Where segments end, rounded.
    pub(crate) fn ends(&self) -> Vec<[f64; 3]> {
        self.segments().iter().map(|it| rounded(it.end)).collect()
    }

    /// How many segments each stem has.
    pub(crate) fn stems(&self) -> Vec<u32> {
        self.list.stems().iter().map(|it| it.count()).collect()
    }

    /// The first radius of each segment.
    pub(crate) fn radii(&self) -> Vec<f64> {
        self.segments().iter().map(|it| it.radii[0]).collect()
    }
}

/// A point, without the noise of arithmetic.
pub(crate) fn rounded(point: DVec3) -> [f64; 3] {
    point.to_array().map(|it| (it * 1e9).round() / 1e9 + 0.0)
}

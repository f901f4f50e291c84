//! What can go wrong once a program runs: facts without words.

use std::sync::Arc;

use crate::form::{Origin, PrimitiveKind, SelectId, TransformKind, Value};

/// A rule that failed, or a limit that was met.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// What went wrong.
    pub kind: FaultKind,
    /// Where in the text.
    pub origin: Origin,
    /// The rules that led there, the outermost first; of a long trail only its two ends.
    pub trail: Vec<TrailStep>,
}

/// One rule on the way to a [`Fault`].
#[derive(Clone, Debug, PartialEq)]
pub struct TrailStep {
    /// The module or system.
    pub name: String,
    /// Its parameters with their values.
    pub values: Vec<(String, Value)>,
    /// Where it was called.
    pub origin: Origin,
}

/// The kinds of [`Fault`].
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// No rule of a module applies to these values of its parameters.
    NoRule {
        /// The module.
        module: String,
        /// Its parameters.
        values: Vec<(String, Value)>,
    },
    /// A selection function gave something that is no rule's number.
    NoSuchRule {
        /// The module.
        module: String,
        /// What it gave.
        number: Value,
        /// How many rules there are.
        rules: usize,
    },
    /// Weights that cannot be drawn from: a negative one, one that is no number, or all 0.
    Weights {
        /// The module.
        module: String,
        /// The weights of the rules whose guards hold.
        weights: Vec<f64>,
    },
    /// An index that is not in its list.
    Index {
        /// The index.
        index: f64,
        /// How long the list is.
        length: usize,
    },
    /// An operation whose result is no number, or infinite without an infinite operand.
    NotANumber {
        /// The operation, as the program writes it: `/`, `sqrt`.
        operation: &'static str,
        /// What it was given.
        operands: Vec<Value>,
    },
    /// An operation on values of types that it does not take.
    Type {
        /// The operation.
        operation: &'static str,
        /// What it was given.
        operands: Vec<Value>,
    },
    /// A value outside its range.
    Range {
        /// The name of the parameter.
        name: Arc<str>,
        /// Its value.
        value: f64,
        /// The least it may be.
        low: f64,
        /// The most.
        high: f64,
        /// Where the range is written, if the fault's place is that of the value.
        range: Origin,
    },
    /// A number that should be whole and at least so much.
    Whole {
        /// What it is for: `repeat`, `variant`.
        what: &'static str,
        /// The number.
        value: f64,
        /// The least it may be.
        least: f64,
    },
    /// A transformation that flattens space, or is no number.
    Singular {
        /// Which.
        kind: TransformKind,
        /// Its numbers.
        values: Vec<f64>,
    },
    /// A primitive that these numbers do not make.
    Primitive {
        /// Which.
        kind: PrimitiveKind,
        /// Its numbers.
        values: Vec<f64>,
    },
    /// A segment whose length or radius is negative or infinite.
    Segment {
        /// Its length, its radius at the start and at the end.
        values: Vec<f64>,
    },
    /// A normal whose length is negative or infinite.
    Normal {
        /// Its length; none for a module that is left and has none.
        length: Option<f64>,
    },
    /// A hull that has no end and is not cut by another solid.
    OpenHull {
        /// A direction in which it goes on; none if it has no plane at all.
        direction: Option<[f64; 3]>,
    },
    /// `toward` with a direction that is none, or an angle that is negative.
    Toward {
        /// The direction's three numbers and the angle.
        values: Vec<f64>,
    },
    /// A walk that has gone too far away, or become too large or too small, to compute with.
    Frame,
    /// A cycle of rules that comes back to where it was without an end.
    Endless {
        /// The S-node that came back.
        select: SelectId,
        /// Its module.
        module: String,
        /// The way round, which begins and ends there.
        cycle: Vec<TrailStep>,
    },
    /// A surface without an inside below `&` or `\`.
    Open(PrimitiveKind),
    /// Nothing that is shown has a mesh.
    NoMesh,
    /// A limit was met.
    Limit {
        /// Which.
        limit: Limit,
        /// Its value.
        most: u64,
    },
    /// The program was told to stop.
    Interrupted,
}

/// What has a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Limit {
    /// Modules and systems inside one another.
    Depth,
    /// Functions inside one another.
    Calls,
    /// Operations of one evaluation.
    Operations,
    /// Copies of one `repeat`.
    Repeat,
    /// Elements of one list.
    List,
    /// Nodes of the graph, or parts of one state.
    Nodes,
    /// Rules applied in one derivation.
    Rules,
    /// Modules laid down in one derivation and not replaced yet.
    Modules,
    /// Segments of one derivation.
    Segments,
    /// Planes of one hull.
    Planes,
    /// Strides of one derivation's walks, and the operations of their expressions.
    Strides,
    /// Steps of one ray through the scene.
    Steps,
    /// Steps of all rays of a picture, and what is made for them.
    Work,
    /// Booleans inside one another, on one ray.
    Booleans,
    /// Intervals on one ray.
    Intervals,
    /// Primitives of an exported scene.
    Primitives,
    /// Triangles of a mesh that is written.
    Triangles,
    /// Triangles of the meshes that are read.
    MeshTriangles,
    /// Cells of all solid textures.
    Cells,
    /// Pixels of a picture.
    Pixels,
    /// Samples of a pixel.
    Samples,
}

impl Fault {
    /// A fault with no trail yet.
    pub fn new(kind: FaultKind, origin: Origin) -> Self {
        Self { kind, origin, trail: Vec::new() }
    }

    /// The same fault, met through one more rule on the outside.
    ///
    /// Of a long trail the innermost steps and the outermost are kept.
    #[must_use]
    pub fn reached_through(mut self, step: TrailStep) -> Self {
        /// How many steps from each end are kept.
        const KEPT: usize = 16;
        if self.trail.len() >= 2 * KEPT {
            self.trail.remove(KEPT - 1);
        }
        self.trail.insert(0, step);
        self
    }
}

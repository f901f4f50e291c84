//! The cyclic CSG graph (GT95, section 2.2).

use std::sync::Arc;

use super::{Code, Function, FunctionId, MaterialId, Op, Origin, PrimitiveKind, Shape, ShapeId, Slot};
use crate::geometry::{Primitive, Triangles};

/// Names a node of a [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// Names an S-node of a [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SelectId(pub u32);

/// Names a system of a [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SystemId(pub u32);

/// A cyclic CSG graph: a set of rewriting systems, kept as a graph instead of being derived.
///
/// The nodes by themselves have no cycles: a node names only nodes before it. Cycles run through [`Node::Call`], which
/// goes to an S-node ([`Select`]), and [`Node::System`], which goes to another system's start. So a traversal that bounds
/// its visits to those two terminates.
///
/// Its tables are shared by all its clones.
#[derive(Clone, Debug)]
pub struct Graph {
    nodes: Arc<Vec<Node>>,
    selects: Arc<Vec<Select>>,
    systems: Arc<Vec<System>>,
    functions: Arc<Vec<Function>>,
    shapes: Arc<Vec<Shape>>,
    /// Each is there once, however many graphs and primitives share it.
    meshes: Vec<Arc<Triangles>>,
    /// See [`Graph::is_unclipped`].
    unclipped: Arc<[bool]>,
    root: SystemId,
    stops_after: Option<u64>,
}

/// A node of a [`Graph`].
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// Nothing at all.
    Empty,
    /// A primitive solid; the code gives its parameters.
    Primitive {
        /// Which.
        kind: PrimitiveKind,
        /// Its parameters.
        code: Code,
        /// Its place in the text.
        origin: Origin,
    },
    /// A T-node: maps what is below it.
    Transform {
        /// How.
        kind: TransformKind,
        /// The numbers of the transformation.
        code: Code,
        /// What is mapped.
        body: NodeId,
        /// Its place in the text.
        origin: Origin,
    },
    /// A C-node: assigns to slots, for what is below it and nothing else.
    Calc {
        /// The assignments.
        code: Code,
        /// Where they hold.
        body: NodeId,
        /// Its place in the text.
        origin: Origin,
    },
    /// Gives a material to what is below it and has none of its own.
    Paint {
        /// Which.
        material: MaterialId,
        /// What is painted.
        body: NodeId,
    },
    /// Folds the path to so many values.
    Variant {
        /// How many: one whole number, at least 1.
        count: Code,
        /// What sees the folded path.
        body: NodeId,
        /// Its place in the text.
        origin: Origin,
    },
    /// The union of so many copies, each with its number in a slot. The number joins the place of the draws and the path of the
    /// calls below.
    Repeat {
        /// How many: one whole number, at least 0.
        count: Code,
        /// Where each finds its number, from 0.
        index: Slot,
        /// What is repeated.
        body: NodeId,
        /// Its place in the text.
        origin: Origin,
    },
    /// One of two, by a condition.
    Choice {
        /// The condition: one truth value.
        condition: Code,
        /// What stands here when it holds.
        then: NodeId,
        /// What stands here when it does not.
        otherwise: NodeId,
    },
    /// An operator node: the union of its operands.
    Union(Box<[NodeId]>),
    /// An operator node: what lies in all its operands.
    Intersect(Box<[NodeId]>),
    /// An operator node: what lies in the first and in none of the others.
    Difference(NodeId, Box<[NodeId]>),
    /// A module: binds the S-node's parameters and goes there.
    Call(Call),
    /// A system used as a solid.
    System(Box<SystemCall>),
    /// What a shape derives to, in the environment of its system.
    Shape(ShapeId),
}

/// The kinds of T-node, each with the numbers its code gives. Angles are in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TransformKind {
    /// x, y, z
    Move,
    /// angle
    RotX,
    /// angle
    RotY,
    /// angle
    RotZ,
    /// axis x, y, z; angle
    Rotate,
    /// x, y, z
    Scale,
    /// factor
    UScale,
    /// normal of the plane through the origin: x, y, z
    Mirror,
    /// dz/dx, dz/dy
    ZShear,
    /// three rows of four
    Matrix,
}

impl TransformKind {
    /// How many numbers it takes.
    pub fn params(self) -> usize {
        match self {
            Self::RotX | Self::RotY | Self::RotZ | Self::UScale => 1,
            Self::ZShear => 2,
            Self::Move | Self::Scale | Self::Mirror => 3,
            Self::Rotate => 4,
            Self::Matrix => 12,
        }
    }
}

/// A module laid down by a rule: `S(c - 1)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Call {
    /// Its S-node.
    pub select: SelectId,
    /// Its arguments, one for each parameter. All are found before any is bound.
    pub args: Code,
    /// The call's place, which joins the path.
    pub place: u64,
    /// Its place in the text.
    pub origin: Origin,
}

/// A system called with its arguments: `Elm(seed: 3)`.
#[derive(Clone, Debug, PartialEq)]
pub struct SystemCall {
    /// Which system.
    pub system: SystemId,
    /// The arguments given.
    pub args: Code,
    /// For each of them, the slot of the formal it is for.
    pub given: Vec<Slot>,
    /// `seed:`, one number: begins a new path.
    pub seed: Option<Code>,
    /// The call's place, which joins the path unless there is a seed.
    pub place: u64,
    /// Its place in the text.
    pub origin: Origin,
}

/// An S-node: all rules of one module.
#[derive(Clone, Debug, PartialEq)]
pub struct Select {
    /// The module's name.
    pub module: String,
    /// The system it belongs to.
    pub system: SystemId,
    /// Where its parameters are bound.
    pub params: Vec<Slot>,
    /// How one of the rules is chosen.
    pub choice: Choice,
    /// Its rules in the order written.
    pub rules: Vec<Rule>,
    /// What stands for it where detail ends.
    pub proxy: Option<NodeId>,
    /// The place of the module's first rule in the text.
    pub origin: Origin,
}

impl Select {
    /// The slots whose values tell people where they are: its parameters, and what the choice among its rules reads besides.
    pub fn told(&self) -> Vec<Slot> {
        let mut slots = self.params.clone();
        let function = if let Choice::Function(code) = &self.choice { Some(code) } else { None };
        let of_rules = self.rules.iter().flat_map(|it| it.guard.iter().chain(&it.weight));
        for op in function.into_iter().chain(of_rules).flat_map(|it| &it.ops) {
            if let Op::Load(_, slot) = op
                && !slots.contains(slot)
            {
                slots.push(*slot);
            }
        }
        slots
    }
}

/// How an S-node chooses.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    /// The first rule whose guard holds.
    First,
    /// One of those whose guard holds, in proportion to its weight. The place is that of the draw.
    Weighted(u64),
    /// The rule of the number that the function gives, counted from 1.
    Function(Code),
}

/// One rule of an S-node.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// Its label, if it has one.
    pub label: Option<String>,
    /// When it applies: one truth value. None: always.
    pub guard: Option<Code>,
    /// Its weight: one number. None: 1.
    pub weight: Option<Code>,
    /// Its successor.
    pub body: NodeId,
    /// Its place in the text.
    pub origin: Origin,
}

/// A rewriting system: how its slots are laid out and filled, and where it starts.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// Its name.
    pub name: String,
    /// A name for each slot, as the program calls it.
    pub slots: Vec<String>,
    /// Its formal parameters.
    pub formals: Vec<Formal>,
    /// Stores its `let`s, each after those it reads.
    pub lets: Code,
    /// Stores the first values of its `var`s.
    pub vars: Code,
    /// Its axiom.
    pub start: NodeId,
    /// Its place in the text.
    pub origin: Origin,
}

/// A formal parameter of a [`System`].
#[derive(Clone, Debug, PartialEq)]
pub struct Formal {
    /// Where it is kept.
    pub slot: Slot,
    /// Its value when a call gives none: one result. It reads no slot.
    pub default: Option<Code>,
    /// Looks whether the value lies in the formal's range.
    pub check: Option<Code>,
}

/// What is wrong with the parts of a [`Graph`] built by hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraphError {
    /// A node names one that does not stand before it.
    NodeOrder(NodeId),
    /// Something names a node, S-node, system, function, shape, module, slot or register that is not there.
    Missing(Origin),
    /// A code does not give as many results as are needed.
    Results(Origin),
    /// A jump does not go forward, or goes past the end.
    Jump(Origin),
    /// A function assigns a slot.
    Assigns(Origin),
    /// There are more nodes than a number of 32 bits counts.
    TooLarge,
}

impl Graph {
    /// A graph of these parts, which starts at the system `root` (a scene is a system without formals).
    ///
    /// # Errors
    /// When the parts do not fit together; see [`GraphError`].
    pub fn new(
        nodes: Vec<Node>,
        selects: Vec<Select>,
        systems: Vec<System>,
        functions: Vec<Function>,
        root: SystemId,
    ) -> Result<Self, GraphError> {
        Self::with_shapes(nodes, selects, systems, functions, Vec::new(), Vec::new(), root)
    }

    /// The same with shapes, which its [`Node::Shape`]s name, and meshes, which its primitives do.
    ///
    /// # Errors
    /// When the parts do not fit together; see [`GraphError`].
    pub fn with_shapes(
        nodes: Vec<Node>,
        selects: Vec<Select>,
        systems: Vec<System>,
        functions: Vec<Function>,
        shapes: Vec<Shape>,
        meshes: Vec<Arc<Triangles>>,
        root: SystemId,
    ) -> Result<Self, GraphError> {
        let graph = Self {
            nodes: table(nodes),
            selects: table(selects),
            systems: table(systems),
            functions: table(functions),
            shapes: table(shapes),
            meshes,
            unclipped: Arc::default(),
            root,
            stops_after: None,
        };
        graph.check()?;
        let unclipped = graph.find_unclipped();
        Ok(Self { unclipped, ..graph })
    }

    /// The graph with other nodes, S-nodes, systems and functions in the places of its own, where there are some; as it is when they do not
    /// fit together.
    pub(crate) fn with_parts(
        &self,
        nodes: Option<Vec<Node>>,
        selects: Option<Vec<Select>>,
        systems: Option<Vec<System>>,
        functions: Option<Vec<Function>>,
    ) -> Self {
        let graph = Self {
            nodes: nodes.map_or_else(|| Arc::clone(&self.nodes), table),
            selects: selects.map_or_else(|| Arc::clone(&self.selects), table),
            systems: systems.map_or_else(|| Arc::clone(&self.systems), table),
            functions: functions.map_or_else(|| Arc::clone(&self.functions), table),
            ..self.clone()
        };
        if graph.check().is_err() {
            return self.clone();
        }
        let unclipped = graph.find_unclipped();
        Self { unclipped, ..graph }
    }

    /// The same graph, in which every derivation of a shape stops after so many rules: young plants.
    #[must_use]
    pub fn stopping_after(self, rules: u64) -> Self {
        Self { stops_after: Some(rules), ..self }
    }

    /// After how many rules derivations stop, if they do not come to their end.
    pub fn stops_after(&self) -> Option<u64> {
        self.stops_after
    }

    /// Where the graph starts.
    pub fn root(&self) -> SystemId {
        self.root
    }

    /// All nodes, in an order in which each stands after those it names.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// All S-nodes.
    pub fn selects(&self) -> &[Select] {
        &self.selects
    }

    /// All systems.
    pub fn systems(&self) -> &[System] {
        &self.systems
    }

    /// All functions.
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// All shapes.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// All meshes.
    pub fn meshes(&self) -> &[Arc<Triangles>] {
        &self.meshes
    }

    /// The primitive of a kind with these parameters; `None` when they make none.
    pub fn primitive(&self, kind: PrimitiveKind, params: &[f64]) -> Option<Primitive> {
        match kind {
            PrimitiveKind::Mesh { mesh, .. } => Some(Primitive::of_mesh(mesh, self.meshes.get(mesh.0 as usize)?)),
            _ => Primitive::new(kind, params),
        }
    }

    /// A node. Ids come from the graph itself, so it is there.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// An S-node.
    pub fn select(&self, id: SelectId) -> &Select {
        &self.selects[id.0 as usize]
    }

    /// A system.
    pub fn system(&self, id: SystemId) -> &System {
        &self.systems[id.0 as usize]
    }

    /// A shape.
    pub fn shape(&self, id: ShapeId) -> &Shape {
        &self.shapes[id.0 as usize]
    }

    /// Whether a shape is seen somewhere without an intersection or difference that cuts it.
    pub fn is_unclipped(&self, id: ShapeId) -> bool {
        self.unclipped[id.0 as usize]
    }

    /// A function.
    pub fn function(&self, id: FunctionId) -> &Function {
        &self.functions[id.0 as usize]
    }
}

/// A table without room to grow: a program may have a million nodes.
fn table<T>(mut all: Vec<T>) -> Arc<Vec<T>> {
    all.shrink_to_fit();
    Arc::new(all)
}

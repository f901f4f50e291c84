//! Lowering: from the checked program to the graph that the runtime draws.
//!
//! Only what is shown is lowered, in the order in which it is first needed. Types, constants and places are settled by now, so all
//! that can go wrong here is that something grows beyond its limit.

pub(crate) mod code;
mod solid;
mod system;
mod walk;

use std::collections::HashMap;

use treegen_grammar::Span;
use treegen_runtime::eval::Place;
use treegen_runtime::form::{self, Graph, Node, NodeId, Origin, SelectId};

use crate::problem::Problem;
use crate::program::{MaterialId, ModuleId, Program, SystemId};
use crate::words;
use code::{Functions, Values};

/// How many nodes a graph may have.
pub(crate) const MAX_NODES: usize = 1_000_000;

/// The graph of a program, and the materials that it paints with: number n of the scene is the n-th of these.
pub(crate) struct Lowered {
    pub(crate) graph: Graph,
    pub(crate) materials: Vec<MaterialId>,
}

/// The place of a piece of text, as the runtime carries it.
pub(crate) fn origin(span: Span) -> Origin {
    Origin { file: span.file.0, start: span.start, end: span.end }
}

/// Lowers what a program shows. `functions` go on from those that constants needed.
pub(crate) fn lower(program: &Program, values: Values<'_>, functions: Functions) -> Result<Lowered, Problem> {
    let mut lowering = Lowering {
        program,
        values,
        functions,
        nodes: Vec::new(),
        selects: Vec::new(),
        systems: Vec::new(),
        shapes: Vec::new(),
        module_ids: HashMap::new(),
        system_ids: HashMap::new(),
        material_ids: HashMap::new(),
        materials: Vec::new(),
        work: Vec::new(),
        overflow: None,
    };
    let root = lowering.root();
    lowering.finish(root)
}

/// What is still to be lowered.
#[derive(Clone, Copy)]
enum Work {
    Module(ModuleId, SelectId),
    System(SystemId, form::SystemId),
}

/// What is known while a program is lowered.
struct Lowering<'a> {
    program: &'a Program,
    values: Values<'a>,
    functions: Functions,
    nodes: Vec<Node>,
    /// Places are reserved when something is first named, and filled when its turn comes.
    selects: Vec<Option<form::Select>>,
    systems: Vec<Option<form::System>>,
    shapes: Vec<form::Shape>,
    module_ids: HashMap<ModuleId, SelectId>,
    system_ids: HashMap<SystemId, form::SystemId>,
    material_ids: HashMap<MaterialId, form::MaterialId>,
    materials: Vec<MaterialId>,
    work: Vec<Work>,
    /// Where something first grew beyond its limit.
    overflow: Option<Span>,
}

impl Lowering<'_> {
    /// The system in which everything starts: the scene, or one that calls the last system.
    fn root(&mut self) -> form::SystemId {
        let program = self.program;
        if let Some(scene) = &program.scene {
            return self.system_id(scene.system);
        }
        let root = form::SystemId(self.systems.len() as u32);
        self.systems.push(None);
        let Some(shown) = program.last_system else { return root };
        let span = program.systems[shown.index()].name_span;
        let call = form::SystemCall {
            system: self.system_id(shown),
            args: form::Code::default(),
            given: Vec::new(),
            seed: None,
            place: Place::file().definition("show", "0").call(0),
            origin: origin(span),
        };
        let start = self.node(Node::System(Box::new(call)), span);
        self.systems[root.0 as usize] = Some(form::System {
            name: "scene".to_owned(),
            slots: Vec::new(),
            formals: Vec::new(),
            lets: form::Code::default(),
            vars: form::Code::default(),
            start,
            origin: origin(span),
        });
        root
    }

    /// Lowers everything that is needed, and puts the graph together.
    fn finish(mut self, root: form::SystemId) -> Result<Lowered, Problem> {
        let mut next = 0;
        while let Some(work) = self.work.get(next).copied() {
            next += 1;
            match work {
                Work::Module(module, id) => {
                    let select = self.select(module);
                    self.selects[id.0 as usize] = Some(select);
                }
                Work::System(system, id) => {
                    let system = self.system(system);
                    self.systems[id.0 as usize] = Some(system);
                }
            }
            if self.overflow.is_some() {
                break;
            }
        }
        self.functions.settle(self.program, self.values);
        if let Some(span) = self.overflow.or(self.functions.overflow) {
            return Err(words::values::too_large(span));
        }
        let selects = self.selects.into_iter().flatten().collect();
        let systems = self.systems.into_iter().flatten().collect();
        let functions = self.functions.into_table();
        let graph =
            Graph::with_shapes(self.nodes, selects, systems, functions, self.shapes, self.program.meshes.clone(), root);
        match graph {
            Ok(graph) => Ok(Lowered { graph, materials: self.materials }),
            Err(error) => Err(words::values::no_graph(&error)),
        }
    }

    /// Adds a node.
    fn node(&mut self, node: Node, span: Span) -> NodeId {
        if self.nodes.len() >= MAX_NODES {
            self.overflow.get_or_insert(span);
            return NodeId(0);
        }
        self.nodes.push(node);
        NodeId(self.nodes.len() as u32 - 1)
    }

    fn select_id(&mut self, module: ModuleId) -> SelectId {
        if let Some(id) = self.module_ids.get(&module) {
            return *id;
        }
        let id = SelectId(self.selects.len() as u32);
        self.selects.push(None);
        self.module_ids.insert(module, id);
        self.work.push(Work::Module(module, id));
        id
    }

    fn system_id(&mut self, system: SystemId) -> form::SystemId {
        if let Some(id) = self.system_ids.get(&system) {
            return *id;
        }
        let id = form::SystemId(self.systems.len() as u32);
        self.systems.push(None);
        self.system_ids.insert(system, id);
        self.work.push(Work::System(system, id));
        id
    }

    fn material_id(&mut self, material: MaterialId) -> form::MaterialId {
        let materials = &mut self.materials;
        *self.material_ids.entry(material).or_insert_with(|| {
            materials.push(material);
            form::MaterialId(materials.len() as u32 - 1)
        })
    }
}

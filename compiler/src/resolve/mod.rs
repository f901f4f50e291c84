//! Names: from trees to the resolved program.
//!
//! In come the trees of all files, out goes a [`Program`] in which every name stands for what it means, and the problems found. First
//! all names are declared ([`declare`]), so that a use may stand before the definition; then bodies are resolved. What is wrong becomes
//! an `Error` of the program, so one mistake makes one message.

mod arguments;
mod calc;
mod call;
mod chain;
mod declare;
mod expr;
mod named;
mod names;
mod records;
mod scope;
mod system;
mod unfound;
mod walk;

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use treegen_grammar::ast::ItemKind;
use treegen_grammar::{FileId, Span};

use crate::load::Unit;
use crate::loader::Loader;
use crate::meshes::Meshes;
use crate::problem::Problem;
use crate::program::{Def, DefId, DefKind, ModuleId, Program, SlotId, SystemId};
use crate::settings::Override;
use crate::sources::Sources;
use names::Names;
use scope::Scope;

/// How many names of values one system may have: slots are numbered with 16 bits.
pub(crate) const MAX_SLOTS: usize = u16::MAX as usize;

/// What names are resolved from.
pub(crate) struct Input<'a> {
    /// The trees of all files.
    pub(crate) units: &'a [Unit],
    /// Their texts.
    pub(crate) sources: &'a Sources,
    /// New defaults from outside.
    pub(crate) overrides: &'a [Override],
    /// The moment of the frame in seconds.
    pub(crate) time: f64,
    /// Brings the files of meshes.
    pub(crate) loader: &'a dyn Loader,
    /// How many triangles all meshes may have.
    pub(crate) most_triangles: u64,
}

/// Resolves all names of a program.
pub(crate) fn resolve(input: &Input<'_>, problems: &mut Vec<Problem>) -> Program {
    let units = input.units;
    let is_partial = units.first().is_some_and(|it| it.unread.ends_early || !it.unread.pieces.is_empty());
    let end = units.first().and_then(|it| it.tree.items.last()).map_or(0, |it| it.span.end);
    let mut resolver = Resolver {
        units,
        sources: input.sources,
        overrides: input.overrides,
        problems,
        time: input.time,
        program: Program { is_partial, end, ..Program::default() },
        files: Vec::new(),
        systems: Vec::new(),
        labels: Vec::new(),
        unknown: BTreeSet::new(),
        unfound: Vec::new(),
        hiding: HashSet::new(),
        slots_full: false,
        has_default: HashSet::new(),
        uneven: HashSet::new(),
        meshes: Meshes::new(input.loader, input.sources, input.most_triangles),
    };
    for number in 0..units.len() {
        resolver.declare_file(FileId(number as u32));
    }
    for number in 0..units.len() {
        resolver.resolve_file(FileId(number as u32));
    }
    resolver.show_unused();
    resolver.program.meshes = resolver.meshes.into_meshes();
    resolver.program
}

/// What is known while names are resolved.
struct Resolver<'a> {
    units: &'a [Unit],
    sources: &'a Sources,
    overrides: &'a [Override],
    problems: &'a mut Vec<Problem>,
    time: f64,
    program: Program,
    /// The names of each file.
    files: Vec<Names>,
    /// The names of each system.
    systems: Vec<Names>,
    /// The rules' labels of each module.
    labels: Vec<Vec<Option<Arc<str>>>>,
    /// Unknown names that were reported, with their file and system: each is reported once.
    unknown: BTreeSet<(FileId, Option<SystemId>, String)>,
    /// Those of them that nothing looks like.
    unfound: Vec<unfound::Unfound>,
    /// Names that hide a built-in one that is meant somewhere: each is told of once.
    hiding: HashSet<DefId>,
    slots_full: bool,
    /// The formals that a call need not give.
    has_default: HashSet<DefId>,
    /// The modules whose rules do not agree in how many parameters they have: no call of one is wrong for that.
    uneven: HashSet<ModuleId>,
    meshes: Meshes<'a>,
}

impl Resolver<'_> {
    /// Makes a definition.
    fn define(&mut self, name: &str, span: Span, kind: DefKind) -> DefId {
        let exempt = name.starts_with('_') || matches!(kind, DefKind::Parameter | DefKind::Scene);
        self.program.defs.push(Def { name: name.to_owned(), span, kind, uses: Vec::new(), broken: false, exempt });
        DefId(self.program.defs.len() as u32 - 1)
    }

    /// Takes note of a problem inside a definition.
    fn report(&mut self, scope: &Scope, problem: Problem) {
        self.break_def(scope.def);
        self.problems.push(problem);
    }

    fn break_def(&mut self, def: DefId) {
        self.program.defs[def.index()].broken = true;
    }

    /// Whether a part of an item could not be read.
    fn is_unread(&self, item: Span) -> bool {
        self.units.get(item.file.0 as usize).is_some_and(|it| it.unread.touches(item))
    }

    /// Makes a slot of a system.
    fn slot(&mut self, system: SystemId, def: DefId) -> SlotId {
        let slots = &mut self.program.systems[system.index()].slots;
        if slots.len() < MAX_SLOTS {
            slots.push(def);
            return slots.len() as SlotId - 1;
        }
        if !self.slots_full {
            self.slots_full = true;
            let span = self.program.def(def).span;
            self.problems.push(crate::words::files::too_many("names of values in one system", MAX_SLOTS, span));
        }
        0
    }

    /// Resolves what stands in a file's items.
    fn resolve_file(&mut self, file: FileId) {
        let units = self.units;
        let Some(unit) = units.get(file.0 as usize) else { return };
        // Which declared item is next, for each kind; an item that was declared twice has a second entry that nobody reaches.
        let mut declared: HashMap<Span, DefId> = HashMap::new();
        for (id, def) in self.program.defs.iter().enumerate() {
            if def.span.file == file {
                declared.insert(def.span, DefId(id as u32));
            }
        }
        for item in &unit.tree.items {
            let def = |span: Span| declared.get(&span).copied();
            match &item.kind {
                ItemKind::Use { .. } | ItemKind::Enum { .. } | ItemKind::Error => {}
                ItemKind::Param(formal) => self.resolve_param(file, def(formal.name.span), formal),
                ItemKind::Let(it) => self.resolve_file_let(file, def(it.name.span), it),
                ItemKind::Fn(it) => self.resolve_fn(Scope::file(file), def(it.name.span), it),
                ItemKind::Texture { name, fields } => self.resolve_texture(file, def(name.span), name, fields),
                ItemKind::Material { name, fields } => self.resolve_material(file, def(name.span), name, fields),
                ItemKind::System(system) => self.resolve_system(file, def(system.name.span), system, item.span),
                ItemKind::Scene(scene) if file == FileId::MAIN => self.resolve_scene(file, scene, item.span),
                ItemKind::Scene(_) => {}
            }
        }
    }
}

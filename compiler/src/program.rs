//! The resolved program: what [`resolve`](crate::resolve) makes of the trees, and types, constants and lowering read.
//!
//! Every name stands for what it means; whatever could not be resolved is an `Error` about which a problem was reported
//! already, so nobody says anything more about it. Places of draws and calls are counted here, in the order of the text.

use std::sync::Arc;

use treegen_grammar::Span;
use treegen_grammar::ast::{BinaryOp, CutOp, SystemKind, UnaryOp};
use treegen_runtime::form::{Builtin, Draw, Order, PrimitiveKind, TransformKind};
use treegen_runtime::geometry::Triangles;

use crate::builtin::WalkWord;
use crate::vocabulary::Vocabulary;

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub(crate) struct $name(pub(crate) u32);

        impl $name {
            /// Its place in the program's table.
            pub(crate) fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}

ids! {
    /// Names a definition of any kind: a node of the graph of who uses whom.
    DefId,
    /// Names a file's `let` or `param`.
    GlobalId,
    /// Names a function of a file or a system.
    FunctionId,
    /// Names an `enum`.
    EnumId,
    /// Names a material.
    MaterialId,
    /// Names a system.
    SystemId,
    /// Names a module.
    ModuleId,
    /// Names a `calc` definition.
    CalcId,
}

/// A whole program.
#[derive(Debug, Default)]
pub(crate) struct Program {
    pub(crate) defs: Vec<Def>,
    pub(crate) globals: Vec<Global>,
    pub(crate) functions: Vec<Function>,
    pub(crate) enums: Vec<Enum>,
    pub(crate) textures: Vec<Record>,
    pub(crate) materials: Vec<Record>,
    pub(crate) systems: Vec<System>,
    pub(crate) modules: Vec<Module>,
    pub(crate) calcs: Vec<CalcDef>,
    /// The main file's scene.
    pub(crate) scene: Option<Scene>,
    /// The last system of the main file: it is shown when there is no scene.
    pub(crate) last_system: Option<SystemId>,
    /// The meshes that its primitives name.
    pub(crate) meshes: Vec<Arc<Triangles>>,
    /// Whether a part of the main file could not be read, so that it may have more than is here.
    pub(crate) is_partial: bool,
    /// Where the last item of the main file ends, in bytes.
    pub(crate) end: u32,
}

/// A definition, whatever its kind: its name, its place, and which definitions it uses.
#[derive(Debug)]
pub(crate) struct Def {
    pub(crate) name: String,
    pub(crate) span: Span,
    pub(crate) kind: DefKind,
    /// What stands in it, in order; one name may stand here several times.
    pub(crate) uses: Vec<DefId>,
    /// A problem was reported in it, so it has no value and nobody looks for further ones.
    pub(crate) broken: bool,
    /// Whether nobody minds if it is never used.
    pub(crate) exempt: bool,
}

/// The kinds of [`Def`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DefKind {
    Use,
    Param(GlobalId),
    FileLet(GlobalId),
    Function(FunctionId),
    Enum,
    /// Its number among the textures.
    Texture(u32),
    Material(MaterialId),
    System(SystemId),
    Formal,
    Let,
    Var,
    Calc(CalcId),
    Module(ModuleId),
    /// A parameter of a rule or function.
    Parameter,
    /// A C-node's `let`.
    Local,
    /// The name that counts a `repeat`.
    Index,
    Scene,
}

impl DefKind {
    /// What it is called in messages.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Use => "used file",
            Self::Param(_) => "param",
            Self::FileLet(_) | Self::Let | Self::Local => "let",
            Self::Function(_) => "function",
            Self::Enum => "enum",
            Self::Texture(_) => "texture",
            Self::Material(_) => "material",
            Self::System(_) => "system",
            Self::Formal => "formal parameter",
            Self::Var => "var",
            Self::Calc(_) => "calc",
            Self::Module(_) => "module",
            Self::Parameter => "parameter",
            Self::Index => "counter",
            Self::Scene => "scene",
        }
    }
}

/// A file's `let` or `param`.
#[derive(Debug)]
pub(crate) struct Global {
    /// What stands in the program when a value from outside takes its place.
    pub(crate) written: Option<Expr>,
    pub(crate) value: Expr,
    pub(crate) range: Option<Range>,
}

/// `low..high`
#[derive(Debug)]
pub(crate) struct Range {
    pub(crate) low: Expr,
    pub(crate) high: Expr,
}

/// A function.
#[derive(Debug)]
pub(crate) struct Function {
    pub(crate) def: DefId,
    /// The system whose slots it reads.
    pub(crate) system: Option<SystemId>,
    pub(crate) params: Vec<String>,
    pub(crate) body: Expr,
}

/// An `enum`.
#[derive(Debug)]
pub(crate) struct Enum {
    pub(crate) name: String,
    pub(crate) cases: Vec<String>,
}

/// A `texture`, a `material`, or a record of a scene: its fields as they stand, once checked for names.
#[derive(Debug)]
pub(crate) struct Record {
    pub(crate) def: DefId,
    pub(crate) name: String,
    pub(crate) span: Span,
    pub(crate) fields: Vec<Field>,
}

/// One field of a [`Record`].
#[derive(Debug)]
pub(crate) struct Field {
    pub(crate) name: &'static str,
    pub(crate) span: Span,
    pub(crate) value: FieldValue,
}

/// What stands in a field.
#[derive(Debug)]
pub(crate) enum FieldValue {
    Expr(Expr),
    /// One of the field's own words.
    Word(&'static str),
    /// A texture, by its number.
    Texture(u32),
    /// A system's call.
    Surface,
    Error,
}

/// A system.
#[derive(Debug)]
pub(crate) struct System {
    pub(crate) def: DefId,
    pub(crate) kind: SystemKind,
    pub(crate) name: String,
    pub(crate) name_span: Span,
    /// A definition for each slot.
    pub(crate) slots: Vec<DefId>,
    pub(crate) formals: Vec<Formal>,
    pub(crate) lets: Vec<Init>,
    pub(crate) vars: Vec<Init>,
    pub(crate) start: Option<Solid>,
    /// How normals split, where `derive` or `prune` says so.
    pub(crate) splitting: Splitting,
}

/// How the normals of a hull split: `derive` and `prune`.
#[derive(Debug)]
pub(crate) struct Splitting {
    pub(crate) order: Order,
    /// How often; once if it does not say.
    pub(crate) count: Option<Expr>,
    pub(crate) outward: bool,
    /// The place of the order's own draws.
    pub(crate) place: u64,
    /// Where that stands.
    pub(crate) span: Span,
}

/// Names a slot of a system while it is checked.
pub(crate) type SlotId = u32;

/// A formal parameter.
#[derive(Debug)]
pub(crate) struct Formal {
    pub(crate) def: DefId,
    pub(crate) name: String,
    pub(crate) slot: SlotId,
    pub(crate) default: Option<Expr>,
    /// What stands in the program when a default from outside takes its place.
    pub(crate) written: Option<Expr>,
    pub(crate) range: Option<Range>,
}

/// A slot's first value: a system's `let` or `var`.
#[derive(Debug)]
pub(crate) struct Init {
    pub(crate) def: DefId,
    pub(crate) slot: SlotId,
    pub(crate) value: Expr,
}

/// A module: all rules of one name.
#[derive(Debug)]
pub(crate) struct Module {
    pub(crate) def: DefId,
    pub(crate) name: String,
    pub(crate) system: SystemId,
    /// Its parameters' slots; the names are those of the first rule.
    pub(crate) params: Vec<SlotId>,
    pub(crate) rules: Vec<Rule>,
    pub(crate) select: Option<Expr>,
    /// Where draws among weighted rules have their place.
    pub(crate) weights_place: u64,
    pub(crate) proxy: Option<Solid>,
}

/// A rule.
#[derive(Debug)]
pub(crate) struct Rule {
    pub(crate) label: Option<Arc<str>>,
    pub(crate) span: Span,
    pub(crate) priority: Option<i64>,
    /// Whether its successor is added to the module (`+>`) and does not stand in its place.
    pub(crate) appends: bool,
    pub(crate) guard: Option<Box<Expr>>,
    pub(crate) weight: Option<Box<Expr>>,
    pub(crate) body: Solid,
}

/// A `calc` definition.
#[derive(Debug)]
pub(crate) struct CalcDef {
    pub(crate) def: DefId,
    pub(crate) system: SystemId,
    pub(crate) steps: Vec<Step>,
}

/// One step of a C-node.
#[derive(Debug)]
pub(crate) enum Step {
    /// A `let`, or an assignment to a `var`.
    Store {
        slot: SlotId,
        value: Expr,
        /// The place of the name.
        span: Span,
    },
    /// Runs a `calc` definition.
    Run { calc: CalcId, place: u64, span: Span },
}

/// The main file's scene.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) def: DefId,
    pub(crate) records: Vec<Record>,
    pub(crate) shows: Vec<Solid>,
    /// The slots of the scene, which is itself a system.
    pub(crate) system: SystemId,
    pub(crate) span: Span,
}

/// A solid, or a walk.
#[derive(Debug)]
pub(crate) struct Solid {
    pub(crate) span: Span,
    pub(crate) kind: SolidKind,
}

/// The kinds of [`Solid`]. Of one that is small there may be very many, so what is large stands elsewhere.
#[derive(Debug)]
pub(crate) enum SolidKind {
    Error,
    Nothing,
    Union(Vec<Solid>),
    Cut {
        first: Box<Solid>,
        rest: Vec<(CutOp, Solid)>,
    },
    /// Prefix operators and what they act on. At least one operator.
    Chain {
        prefixes: Vec<Prefix>,
        body: Box<Solid>,
    },
    Primitive {
        kind: PrimitiveKind,
        args: Box<[Expr]>,
        flat: bool,
    },
    Module {
        module: ModuleId,
        args: Box<[Expr]>,
        place: u64,
    },
    System {
        system: SystemId,
        args: Box<[(usize, Expr)]>,
        seed: Option<Box<Expr>>,
        place: u64,
    },
    Repeat {
        count: Box<Expr>,
        index: SlotId,
        body: Box<Solid>,
    },
    Choice {
        branches: Vec<(Expr, Solid)>,
        otherwise: Option<Box<Solid>>,
    },
    /// Something that is checked and cannot be drawn yet.
    Later(Box<Later>),
    /// The terms of a walk.
    Walk(Vec<Stride>),
}

/// What cannot be drawn yet.
#[derive(Debug)]
pub(crate) struct Later {
    /// Its name.
    pub(crate) what: &'static str,
    /// Its arguments with the types they must have.
    pub(crate) args: Vec<(Expr, &'static str, crate::fields::FieldType)>,
    /// What it acts on or reads.
    pub(crate) parts: Vec<Solid>,
}

/// One term of a walk.
#[derive(Debug)]
pub(crate) enum Stride {
    Prefix(Prefix),
    Word(WalkWord, Box<[Expr]>, Span),
    Solid(Solid),
    Bracket(Solid),
}

/// An operator of a chain.
#[derive(Debug)]
pub(crate) struct Prefix {
    pub(crate) span: Span,
    pub(crate) kind: PrefixKind,
}

/// The kinds of [`Prefix`].
#[derive(Debug)]
pub(crate) enum PrefixKind {
    Error,
    Transform { kind: TransformKind, args: Box<[Expr]>, flat: bool },
    Paint(MaterialId),
    Calc(Vec<Step>),
    Variant(Box<Expr>),
    Later(Box<Later>),
}

/// An expression.
#[derive(Debug)]
pub(crate) struct Expr {
    pub(crate) span: Span,
    pub(crate) kind: ExprKind,
}

/// The kinds of [`Expr`].
#[derive(Debug)]
pub(crate) enum ExprKind {
    Error,
    Number(f64),
    Text(Arc<str>),
    Bool(bool),
    Case(EnumId, u32),
    /// A rule of the module that is selected from, counted from 1.
    Rule(u32),
    Global(GlobalId),
    Slot(SlotId),
    /// A parameter of the function around.
    Param(u16),
    If {
        branches: Box<[(Expr, Expr)]>,
        otherwise: Box<Expr>,
    },
    Binary {
        first: Box<Expr>,
        rest: Box<[(BinaryOp, Span, Expr)]>,
    },
    Power(Box<[Expr]>),
    Unary {
        ops: Box<[UnaryOp]>,
        operand: Box<Expr>,
    },
    Postfix {
        base: Box<Expr>,
        links: Box<[Link]>,
    },
    Vector(Box<[Expr]>),
    List(Box<[Expr]>),
    Builtin(Builtin, Box<[Expr]>),
    Draw {
        draw: Draw,
        args: Box<[Expr]>,
        place: u64,
    },
    Call {
        function: FunctionId,
        args: Box<[Expr]>,
        place: u64,
    },
}

/// What follows a value.
#[derive(Debug)]
pub(crate) enum Link {
    Index(Expr, Span),
    /// The part's number and its place.
    Part(u8, Span),
}

impl Program {
    /// A definition.
    pub(crate) fn def(&self, id: DefId) -> &Def {
        &self.defs[id.index()]
    }

    /// The names of its enums and their values.
    pub(crate) fn vocabulary(&self) -> Vocabulary {
        Vocabulary { enums: self.enums.iter().map(|it| (it.name.clone(), it.cases.clone())).collect() }
    }

    /// The name of a system's slot.
    pub(crate) fn slot_name(&self, system: SystemId, slot: SlotId) -> &str {
        let def = self.systems[system.index()].slots.get(slot as usize);
        def.map_or("", |it| self.def(*it).name.as_str())
    }
}

//! The tree that a source file is read into.
//!
//! It mirrors the text: names are not resolved, a transformation and a module look alike, and a field may have a name
//! that no record knows. What the parser could not read stands as [`ItemKind::Error`], [`MemberKind::Error`],
//! [`TermKind::Error`] or [`ExprKind::Error`], and the mistake itself is in the list of [`SyntaxError`]s beside the tree.
//!
//! **Height.** Everything that can be long in a program (operands of one level, terms of a chain, elements of a list,
//! branches of an `else if`, indices after a value) is one flat node with a `Vec`, so the height of a tree grows with its
//! nesting only, and the parser limits that ([`MAX_NESTING`]). So a walk over the tree, and dropping it, may recurse.
//!
//! **Size.** There may be a million of most nodes, so what few of a kind have (a guard, the name of an argument) stands elsewhere.
//!
//! [`SyntaxError`]: crate::SyntaxError
//! [`MAX_NESTING`]: crate::MAX_NESTING

use std::sync::Arc;

use crate::Span;

/// A name with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    /// The letters. Wherever a name stands in a file, it shares them.
    pub text: Arc<str>,
    /// Where it stands.
    pub span: Span,
}

/// A source file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct File {
    /// What stands in it, in order.
    pub items: Vec<Item>,
    /// Every comment (`//`, `/* */`, and `///`), in order, for tools that must keep them.
    pub comments: Vec<Comment>,
}

/// A comment, kept beside the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comment {
    /// Its text with its marks, without the line's end.
    pub span: Span,
    /// Whether it describes what follows (`///`).
    pub doc: bool,
}

/// Something at the top level of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// The lines of the `///` comment above it, without marks, joined by line feeds; empty when there is none.
    pub doc: String,
    /// From its first word to its `;` or `}`.
    pub span: Span,
    /// What it is.
    pub kind: ItemKind,
}

/// The kinds of [`Item`].
#[derive(Clone, Debug, PartialEq)]
pub enum ItemKind {
    /// `use "trees/elm.tg" as trees;`
    Use {
        /// The text between the quotes, escapes resolved.
        path: String,
        /// Where the quoted text stands, quotes and all.
        path_span: Span,
        /// The name after `as`.
        alias: Option<Name>,
    },
    /// `param height = 3 in 1..9;`
    Param(Formal),
    /// `let x = 1;`
    Let(Let),
    /// `fn f(a, b) = a + b;`
    Fn(Fn),
    /// `enum Kind { leaf, bud }`
    Enum {
        /// Its name.
        name: Name,
        /// Its values.
        cases: Vec<Name>,
    },
    /// `texture Bark { ... }`
    Texture {
        /// Its name.
        name: Name,
        /// Its fields.
        fields: Record,
    },
    /// `material Bark { ... }`
    Material {
        /// Its name.
        name: Name,
        /// Its fields.
        fields: Record,
    },
    /// `csg Tree(order = 3) { ... }`
    System(System),
    /// `scene { ... }`
    Scene(Scene),
    /// What could not be read.
    Error,
}

/// `{ name: value, ... }`
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Its fields in order.
    pub fields: Vec<Field>,
    /// Braces and all.
    pub span: Span,
}

/// One field of a [`Record`].
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Its name.
    pub name: Name,
    /// Its value.
    pub value: Expr,
}

/// `name = default in low..high`: a `param`, or a formal parameter of a system.
#[derive(Clone, Debug, PartialEq)]
pub struct Formal {
    /// Its name.
    pub name: Name,
    /// The value it has unless given another.
    pub default: Option<Expr>,
    /// The values it may have, both ends included.
    pub range: Option<Box<Range>>,
}

/// `low..high`
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// The least.
    pub low: Expr,
    /// The most.
    pub high: Expr,
}

/// `let name = value;`
#[derive(Clone, Debug, PartialEq)]
pub struct Let {
    /// Its name.
    pub name: Name,
    /// Its value.
    pub value: Expr,
}

/// `fn name(a, b) = body;`
#[derive(Clone, Debug, PartialEq)]
pub struct Fn {
    /// Its name.
    pub name: Name,
    /// Its parameters.
    pub params: Vec<Name>,
    /// What it gives.
    pub body: Expr,
}

/// A rewriting system.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// What its successors are.
    pub kind: SystemKind,
    /// Its name.
    pub name: Name,
    /// Its formal parameters.
    pub formals: Vec<Formal>,
    /// What stands between its braces.
    pub members: Vec<Member>,
}

/// The kinds of [`System`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SystemKind {
    /// Expressions over solids (GT95).
    Csg,
    /// Walks that lay down segments (B08).
    Shape,
    /// Walks that lay down half-spaces (FG86).
    Hull,
}

/// Something inside a system's braces.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// The `///` comment above it, as in [`Item::doc`].
    pub doc: String,
    /// From its first word to its `;` or `}`.
    pub span: Span,
    /// What it is.
    pub kind: MemberKind,
}

/// The kinds of [`Member`].
#[derive(Clone, Debug, PartialEq)]
pub enum MemberKind {
    /// `let x = 1;`
    Let(Let),
    /// `fn f(a) = a;`
    Fn(Fn),
    /// `var a = 1, b = 2;`
    Var(Vec<Let>),
    /// `calc finer { n = n - 1 }`
    Calc {
        /// Its name.
        name: Name,
        /// What it does.
        calc: Calc,
    },
    /// `select M by expr;`
    Select {
        /// The module.
        module: Name,
        /// Which of its rules.
        by: Expr,
    },
    /// `start successor;`
    Start(Solid),
    /// `derive parallel 3;`
    Derive {
        /// The order of derivation.
        order: Name,
        /// How far.
        count: Option<Expr>,
    },
    /// `prune outward;`
    Prune(Name),
    /// `proxy M -> successor;`
    Proxy {
        /// The module.
        module: Name,
        /// What stands for it where detail ends.
        solid: Solid,
    },
    /// `priority 2 { rules }`
    Priority {
        /// The smaller, the earlier.
        number: Expr,
        /// The rules of the group; each is a [`MemberKind::Rule`] or a [`MemberKind::Error`].
        rules: Vec<Member>,
    },
    /// A rule.
    Rule(Rule),
    /// What could not be read.
    Error,
}

/// `label: Module(params) if guard @ weight -> successor;`
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// The name before the colon.
    pub label: Option<Box<Name>>,
    /// The module it is for.
    pub module: Name,
    /// Its names for the module's parameters.
    pub params: Box<[Name]>,
    /// When it applies.
    pub guard: Option<Box<Expr>>,
    /// How likely it is.
    pub weight: Option<Box<Expr>>,
    /// Whether the successor stands in the predecessor's place or is added to it.
    pub arrow: Arrow,
    /// What becomes of the module.
    pub successor: Solid,
}

/// The two arrows of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrow {
    /// `->`
    Replace,
    /// `+>`
    Append,
}

/// A successor: an expression over solids, or a walk.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Where it stands.
    pub span: Span,
    /// What it is.
    pub kind: SolidKind,
}

/// The kinds of [`Solid`].
#[derive(Clone, Debug, PartialEq)]
pub enum SolidKind {
    /// `a | b | c`: two operands or more.
    Union(Vec<Solid>),
    /// `a & b \ c`: operators of one level, taken from the left. At least one follows the first.
    Cut {
        /// The first operand.
        first: Box<Solid>,
        /// The others, each with the operator before it.
        rest: Vec<(CutOp, Solid)>,
    },
    /// Terms side by side: prefix operators and what they act on, or a walk. At least one.
    Chain(Vec<Term>),
}

/// The operators of [`SolidKind::Cut`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CutOp {
    /// `&`
    Intersect,
    /// `\`
    Subtract,
}

/// One link of a chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Where it stands.
    pub span: Span,
    /// What it is.
    pub kind: TermKind,
}

/// The kinds of [`Term`].
#[derive(Clone, Debug, PartialEq)]
pub enum TermKind {
    /// `sphere`, `move(1, 2, 3)`, `trees.Elm(seed: 2)`: a transformation, a module, a primitive, a system.
    Call {
        /// What is called.
        path: Path,
        /// Its arguments; `None` when there are no parentheses.
        args: Option<Box<[Arg]>>,
    },
    /// `( solid )`
    Group(Box<Solid>),
    /// `{ n = n - 1 }`
    Calc(Calc),
    /// `[ walk ]`
    Bracket(Box<Solid>),
    /// `repeat n as i { solid }`
    Repeat {
        /// How often.
        count: Box<Expr>,
        /// The name that counts from 0.
        index: Option<Name>,
        /// What is repeated.
        body: Box<Solid>,
    },
    /// `if a { x } else if b { y } else { z }`
    Choice {
        /// Conditions in order, each with what stands there when it is the first to hold.
        branches: Vec<(Expr, Solid)>,
        /// What stands there when none holds.
        otherwise: Option<Box<Solid>>,
    },
    /// What could not be read.
    Error,
}

/// `name` or `file.name`
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// The part before the dot.
    pub qualifier: Option<Box<Name>>,
    /// The name itself.
    pub name: Name,
}

impl Path {
    /// Where it stands.
    pub fn span(&self) -> Span {
        self.qualifier.as_ref().map_or(self.name.span, |it| it.span.to(self.name.span))
    }
}

/// An argument. Those with names come last (the checker says so when they don't).
#[derive(Clone, Debug, PartialEq)]
pub struct Arg {
    /// The name before the colon.
    pub name: Option<Box<Name>>,
    /// Its value.
    pub value: Expr,
}

/// A C-node: `{ let a = 1; n = n - a; finer }`
#[derive(Clone, Debug, PartialEq)]
pub struct Calc {
    /// What it does, in order.
    pub steps: Vec<Step>,
    /// Braces and all.
    pub span: Span,
}

/// One step of a [`Calc`].
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// `let name = value`
    Let(Let),
    /// `name = value`
    Assign(Let),
    /// `name`: runs a `calc` definition.
    Run(Name),
    /// What could not be read.
    Error(Span),
}

/// `scene { ... }`
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// What stands between its braces.
    pub members: Vec<SceneMember>,
}

/// Something inside a scene's braces.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneMember {
    /// `camera { ... }`
    Record {
        /// The word before the brace.
        name: Name,
        /// Its fields.
        fields: Record,
    },
    /// `show solid;`
    Show(Solid),
    /// What could not be read.
    Error(Span),
}

/// An expression over values.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// Where it stands.
    pub span: Span,
    /// What it is.
    pub kind: ExprKind,
}

/// The kinds of [`Expr`].
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// `12`
    Number(f64),
    /// `"bark.png"`, escapes resolved.
    Text(Arc<str>),
    /// `true`
    Bool(bool),
    /// `n`
    Name(Arc<str>),
    /// `if a then x else if b then y else z`
    If {
        /// Conditions in order, each with its value.
        branches: Box<[(Expr, Expr)]>,
        /// The value when none holds.
        otherwise: Box<Expr>,
    },
    /// `a + b - c`, `a and b`, `a < b`: operators of one level, taken from the left. A comparison has one only.
    Binary {
        /// The first operand.
        first: Box<Expr>,
        /// The others, each with the operator before it and that operator's place.
        rest: Box<[(BinaryOp, Span, Expr)]>,
    },
    /// `a ^ b ^ c`, taken from the right.
    Power(Box<[Expr]>),
    /// `- - not a`: the operators from the left, at least one.
    Unary {
        /// The operators.
        ops: Box<[UnaryOp]>,
        /// What they act on.
        operand: Box<Expr>,
    },
    /// `a[0].x(b)`: what follows a value, from the left, at least one.
    Postfix {
        /// The value.
        base: Box<Expr>,
        /// What follows it.
        links: Box<[Link]>,
    },
    /// `(a, b, c)`: two parts or more.
    Vector(Box<[Expr]>),
    /// `[a, b, c]`
    List(Box<[Expr]>),
    /// What could not be read.
    Error,
}

/// What may follow a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Link {
    /// `[index]`
    Index(Box<Expr>, Span),
    /// `.x`, `.leaf`
    Part(Name),
    /// `(a, b: c)`
    Call(Box<[Arg]>, Span),
}

/// Operators before a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UnaryOp {
    /// `-`
    Negate,
    /// `not`
    Not,
}

/// Operators between two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it")]
pub enum BinaryOp {
    Or,
    And,
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Add,
    Subtract,
    Multiply,
    Divide,
    Remainder,
}

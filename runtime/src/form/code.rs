//! Compiled expressions: small programs for a register machine.
//!
//! The machine that runs them is [`eval`](crate::eval). A [`Code`] is a straight list of operations with forward jumps only,
//! so it always ends; loops are left to the graph, and recursion to [`Op::Call`], whose depth is limited.

use super::{Origin, Value};

/// Names a register of one run of a [`Code`]. Registers hold what is being computed and are gone when the run ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Reg(pub u16);

/// Names a slot of an environment: a formal, a `let`, a `var`, a module's parameter, a C-node's `let`, a `repeat`'s index.
///
/// Each system lays out its own slots ([`System`](super::System) tells which are what). In a [`Function`] the
/// slots are those of the system that calls it: a function of a file never names any.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Slot(pub u16);

/// Names a function of a [`Graph`](super::Graph).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FunctionId(pub u32);

/// A compiled expression, or a list of assignments.
///
/// Written as: for each operand its operations, then the operation itself. `results` are the registers that hold what it was
/// made for, in order: one for an expression, one for each argument of a call, none for a C-node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Code {
    /// What to do, in order.
    pub ops: Box<[Op]>,
    /// For each operation, the text it comes from: a fault shows it.
    pub origins: Box<[Origin]>,
    /// How many registers a run needs; every register named is below.
    pub registers: u16,
    /// Where the results are.
    pub results: Box<[Reg]>,
}

/// One operation. The first register named is the one it writes.
#[derive(Clone, Debug, PartialEq)]
pub enum Op {
    /// A value known when the program was compiled.
    Constant(Reg, Value),
    /// What a slot holds.
    Load(Reg, Slot),
    /// Puts a register into a slot: the assignment of a C-node.
    Store(Slot, Reg),
    /// A parameter of the function that is running, counted from 0.
    Param(Reg, u16),
    /// Another register's value.
    Copy(Reg, Reg),
    /// An operator with one operand.
    Unary(Reg, UnaryOp, Reg),
    /// An operator with two operands.
    Binary(Reg, BinaryOp, Reg, Reg),
    /// A vector of numbers (2 to 4).
    Vector(Reg, Box<[Reg]>),
    /// A list.
    List(Reg, Box<[Reg]>),
    /// `list[index]`
    Index(Reg, Reg, Reg),
    /// `list[index]`, of the list that a slot holds.
    Element(Reg, Slot, Reg),
    /// `vector.x`, with 0 for x, 1 for y, 2 for z, 3 for the fourth.
    Part(Reg, Reg, u8),
    /// A built-in function.
    Builtin(Reg, Builtin, Box<[Reg]>),
    /// A function of the program. The place joins that of every draw inside.
    Call {
        /// Where the result goes.
        to: Reg,
        /// Which function.
        function: FunctionId,
        /// Its arguments.
        args: Box<[Reg]>,
        /// The call's place (see [`Draw`]).
        place: u64,
    },
    /// A random draw.
    Draw {
        /// Where the result goes.
        to: Reg,
        /// From which distribution.
        draw: Draw,
        /// Its parameters.
        args: Box<[Reg]>,
        /// The draw's place (see [`Draw`]).
        place: u64,
    },
    /// Opens a place: draws and calls up to the matching [`Op::Leave`] are inside it too. It stands around what a `calc`
    /// definition did in the C-node that runs it.
    Enter(u64),
    /// Closes the place opened last.
    Leave,
    /// Goes on at the operation of this number, which is further on.
    Jump(u32),
    /// Goes on at the operation of this number if the register holds `true`, else with the next.
    JumpIf(Reg, u32),
    /// Goes on at the operation of this number if the register holds `false`, else with the next.
    JumpUnless(Reg, u32),
    /// A fault unless the register's number lies within (low, high), both included: a formal's or `param`'s range.
    Check {
        /// What is looked at.
        value: Reg,
        /// The least it may be.
        low: Reg,
        /// The most.
        high: Reg,
        /// Its name, for the message.
        name: std::sync::Arc<str>,
    },
}

/// Operators with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UnaryOp {
    /// `-a`, of numbers and vectors.
    Negate,
    /// `not a`
    Not,
}

/// Operators with two operands. (`and`, `or` and `if` are jumps, since they look at no more than they need.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BinaryOp {
    /// `a == b`, of anything with its own type.
    Equal,
    /// `a != b`
    NotEqual,
    /// `a < b`
    Less,
    /// `a <= b`
    LessEqual,
    /// `a > b`
    Greater,
    /// `a >= b`
    GreaterEqual,
    /// `a + b`, of numbers or of vectors.
    Add,
    /// `a - b`, of numbers or of vectors.
    Subtract,
    /// `a * b`, of numbers, or of a vector and a number either way round.
    Multiply,
    /// `a / b`, of numbers, or of a vector by a number.
    Divide,
    /// `a % b`, with the sign of b.
    Remainder,
    /// `a ^ b`
    Power,
}

/// Functions every program knows. Angles are in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the language reference describes them by these names")]
pub enum Builtin {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Sqrt,
    Exp,
    Ln,
    Abs,
    Floor,
    Ceil,
    Round,
    Min,
    Max,
    Clamp,
    Mix,
    Dot,
    Cross,
    Norm,
    Unit,
    Count,
    /// `rand(key)`: a hash of its argument and the program's seed to [0, 1).
    Rand,
    /// `noise(p)`: gradient noise of a number or vector, about -1 to 1.
    Noise,
}

/// Random draws.
///
/// A draw is a pure function of the program's seed, the path, its place in the source, and the indices of the `repeat`s
/// around it. A **place** is a hash of names and counts (the system, the rule or definition, which draw or call in there), so
/// comments, layout and rules added elsewhere change no draw. See [`Place`](crate::eval::Place).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Draw {
    /// `random(low, high)`, uniform.
    Uniform,
    /// `gauss(mean, sigma)`: the normal distribution cut off at 3 sigma.
    Gauss,
    /// `chance(p)`: true with probability p.
    Chance,
}

/// A function of the program.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// How many parameters it has.
    pub params: u16,
    /// What it gives: one result.
    pub code: Code,
    /// Where it is defined.
    pub origin: Origin,
}

impl Code {
    /// The slots it assigns.
    pub fn stores(&self) -> impl Iterator<Item = Slot> {
        self.ops.iter().filter_map(|it| if let Op::Store(slot, _) = it { Some(*slot) } else { None })
    }

    /// The text that a register's last value comes from.
    pub(crate) fn origin_of(&self, reg: Reg) -> Option<Origin> {
        let writes = |it: &Op| {
            let only_reads = matches!(it, Op::Store(..) | Op::JumpIf(..) | Op::JumpUnless(..) | Op::Check { .. });
            !only_reads && it.registers().first() == Some(&reg)
        };
        self.ops.iter().rposition(writes).and_then(|it| self.origins.get(it)).copied()
    }
}

impl Op {
    /// The registers it names.
    pub(super) fn registers(&self) -> Vec<Reg> {
        let with = |to: &Reg, args: &[Reg]| std::iter::once(*to).chain(args.iter().copied()).collect();
        match self {
            Self::Constant(to, _) | Self::Load(to, _) | Self::Store(_, to) | Self::Param(to, _) => vec![*to],
            Self::Copy(to, a) | Self::Unary(to, _, a) | Self::Part(to, a, _) | Self::Element(to, _, a) => vec![*to, *a],
            Self::Binary(to, _, a, b) | Self::Index(to, a, b) => vec![*to, *a, *b],
            Self::Vector(to, args) | Self::List(to, args) | Self::Builtin(to, _, args) => with(to, args),
            Self::Call { to, args, .. } | Self::Draw { to, args, .. } => with(to, args),
            Self::Enter(_) | Self::Leave | Self::Jump(_) => vec![],
            Self::JumpIf(reg, _) | Self::JumpUnless(reg, _) => vec![*reg],
            Self::Check { value, low, high, .. } => vec![*value, *low, *high],
        }
    }

    /// Where it may jump to.
    pub(crate) fn target(&self) -> Option<u32> {
        match self {
            Self::Jump(target) | Self::JumpIf(_, target) | Self::JumpUnless(_, target) => Some(*target),
            _ => None,
        }
    }
}

impl Builtin {
    /// Its name in the language.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Tan => "tan",
            Self::Asin => "asin",
            Self::Acos => "acos",
            Self::Atan => "atan",
            Self::Atan2 => "atan2",
            Self::Sqrt => "sqrt",
            Self::Exp => "exp",
            Self::Ln => "ln",
            Self::Abs => "abs",
            Self::Floor => "floor",
            Self::Ceil => "ceil",
            Self::Round => "round",
            Self::Min => "min",
            Self::Max => "max",
            Self::Clamp => "clamp",
            Self::Mix => "mix",
            Self::Dot => "dot",
            Self::Cross => "cross",
            Self::Norm => "norm",
            Self::Unit => "unit",
            Self::Count => "count",
            Self::Rand => "rand",
            Self::Noise => "noise",
        }
    }
}

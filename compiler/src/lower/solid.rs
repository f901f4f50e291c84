//! Solids become nodes: operators T-, C- and paint nodes, expressions operator nodes (GT95, section 2.2).

use treegen_grammar::Span;
use treegen_grammar::ast::CutOp;
use treegen_runtime::form::{self, Code, Node, NodeId, Reg, Slot};

use super::code::Coder;
use super::{Lowering, origin};
use crate::builtin::{self, Group};
use crate::program::{Expr, Prefix, PrefixKind, Solid, SolidKind, Step, SystemId};

impl Lowering<'_> {
    /// The node of a solid in a system.
    pub(super) fn solid(&mut self, system: SystemId, solid: &Solid) -> NodeId {
        let span = solid.span;
        let node = match &solid.kind {
            SolidKind::Union(_) => return self.union(system, solid),
            SolidKind::Cut { .. } => return self.cut(system, solid),
            SolidKind::Chain { prefixes, body } => {
                let body = self.solid(system, body);
                return prefixes.iter().rev().fold(body, |body, it| self.prefix(it, body));
            }
            SolidKind::Primitive { kind, args, flat } => {
                let groups = builtin::PRIMITIVES.iter().find(|it| it.kind == *kind).map_or(&[][..], |it| it.groups);
                Node::Primitive { kind: *kind, code: self.numbers(args, groups, *flat), origin: origin(span) }
            }
            SolidKind::Module { module, args, place } => {
                let (select, args) = (self.select_id(*module), self.values_of(args));
                Node::Call(form::Call { select, args, place: *place, origin: origin(span) })
            }
            SolidKind::System { system, args, seed, place } => {
                self.system_call(*system, args, seed.as_deref(), *place, span)
            }
            SolidKind::Repeat { count, index, body } => {
                let body = self.solid(system, body);
                Node::Repeat { count: self.value_of(count), index: Slot(*index as u16), body, origin: origin(span) }
            }
            SolidKind::Choice { branches, otherwise } => {
                let mut rest = match otherwise {
                    Some(otherwise) => self.solid(system, otherwise),
                    None => self.node(Node::Empty, span),
                };
                for (condition, then) in branches.iter().rev() {
                    let then = self.solid(system, then);
                    let condition = self.value_of(condition);
                    rest = self.node(Node::Choice { condition, then, otherwise: rest }, span);
                }
                return rest;
            }
            // What is wrong or cannot be drawn yet was reported, and nothing is lowered then.
            SolidKind::Error | SolidKind::Nothing | SolidKind::Later(_) | SolidKind::Walk(_) => Node::Empty,
        };
        self.node(node, span)
    }

    /// The operands of a union and of the unions in it, without those that are nothing.
    fn union(&mut self, system: SystemId, solid: &Solid) -> NodeId {
        let mut operands = Vec::new();
        let mut stack = vec![solid];
        while let Some(next) = stack.pop() {
            match &next.kind {
                SolidKind::Union(inner) => stack.extend(inner.iter().rev()),
                SolidKind::Nothing => {}
                _ => operands.push(self.solid(system, next)),
            }
        }
        self.union_of(operands, solid.span)
    }

    /// The union of some nodes.
    pub(super) fn union_of(&mut self, operands: Vec<NodeId>, span: Span) -> NodeId {
        match operands.as_slice() {
            [] => self.node(Node::Empty, span),
            [only] => *only,
            _ => self.node(Node::Union(operands.into_boxed_slice()), span),
        }
    }

    /// `a & b \ c & d \ e` is what lies in a, b and d, and neither in c nor in e.
    fn cut(&mut self, system: SystemId, solid: &Solid) -> NodeId {
        let (mut kept, mut taken) = (Vec::new(), Vec::new());
        let mut stack = vec![(CutOp::Intersect, solid)];
        while let Some((op, next)) = stack.pop() {
            match (op, &next.kind) {
                (CutOp::Intersect, SolidKind::Cut { first, rest }) => {
                    stack.extend(rest.iter().rev().map(|(op, it)| (*op, it)));
                    stack.push((CutOp::Intersect, first));
                }
                (CutOp::Intersect, _) => kept.push(next),
                (CutOp::Subtract, SolidKind::Union(operands)) => {
                    stack.extend(operands.iter().rev().map(|it| (CutOp::Subtract, it)));
                }
                (CutOp::Subtract, SolidKind::Nothing) => {}
                (CutOp::Subtract, _) => taken.push(next),
            }
        }
        let kept: Vec<NodeId> = kept.into_iter().map(|it| self.solid(system, it)).collect();
        let taken: Vec<NodeId> = taken.into_iter().map(|it| self.solid(system, it)).collect();
        let first = match kept.as_slice() {
            [only] => *only,
            _ => self.node(Node::Intersect(kept.into_boxed_slice()), solid.span),
        };
        if taken.is_empty() {
            return first;
        }
        self.node(Node::Difference(first, taken.into_boxed_slice()), solid.span)
    }

    /// The node of an operator above what it acts on.
    fn prefix(&mut self, prefix: &Prefix, body: NodeId) -> NodeId {
        let at = origin(prefix.span);
        let node = match &prefix.kind {
            PrefixKind::Transform { kind, args, flat } => {
                let groups = builtin::TRANSFORMS.iter().find(|it| it.kind == *kind).map_or(&[][..], |it| it.groups);
                Node::Transform { kind: *kind, code: self.numbers(args, groups, *flat), body, origin: at }
            }
            PrefixKind::Paint(material) => Node::Paint { material: self.material_id(*material), body },
            PrefixKind::Calc(steps) => Node::Calc { code: self.steps(steps), body, origin: at },
            PrefixKind::Variant(count) => Node::Variant { count: self.value_of(count), body, origin: at },
            PrefixKind::Error | PrefixKind::Later(_) => return body,
        };
        self.node(node, prefix.span)
    }

    fn system_call(
        &mut self,
        system: SystemId,
        args: &[(usize, Expr)],
        seed: Option<&Expr>,
        place: u64,
        span: Span,
    ) -> Node {
        let formals = &self.program.systems[system.index()].formals;
        let given = args.iter().filter_map(|it| Some(Slot(formals.get(it.0)?.slot as u16))).collect();
        let args = self.code(|coder| args.iter().map(|it| coder.expr(&it.1)).collect());
        let seed = seed.map(|it| self.value_of(it));
        Node::System(Box::new(form::SystemCall {
            system: self.system_id(system),
            args,
            given,
            seed,
            place,
            origin: origin(span),
        }))
    }

    /// Writes a code with the results that `write` gives.
    pub(super) fn code(&mut self, write: impl FnOnce(&mut Coder<'_>) -> Vec<Reg>) -> Code {
        if self.overflow.is_some() {
            return Code::default();
        }
        let mut coder = Coder::new(self.program, self.values, &mut self.functions);
        let results = write(&mut coder);
        let (code, overflow) = coder.finish(results);
        self.overflow = self.overflow.or(overflow);
        code
    }

    /// The code of one value.
    pub(super) fn value_of(&mut self, expr: &Expr) -> Code {
        self.code(|coder| vec![coder.expr(expr)])
    }

    pub(super) fn values_of(&mut self, exprs: &[Expr]) -> Code {
        self.code(|coder| exprs.iter().map(|it| coder.expr(it)).collect())
    }

    pub(super) fn steps(&mut self, steps: &[Step]) -> Code {
        self.code(|coder| {
            coder.steps(steps);
            Vec::new()
        })
    }

    /// The numbers of a transformation or primitive; those of a vector stand for themselves.
    pub(super) fn numbers(&mut self, args: &[Expr], groups: &[Group], flat: bool) -> Code {
        self.code(|coder| {
            if flat {
                return args.iter().map(|it| coder.expr(it)).collect();
            }
            let mut results = Vec::new();
            for (arg, group) in args.iter().zip(groups) {
                match group.parts.len() {
                    1 => results.push(coder.expr(arg)),
                    count => results.extend(coder.parts(arg, count)),
                }
            }
            results
        })
    }
}

//! The machine that runs compiled expressions.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use treegen_runtime::eval::{Env, Machine, Path};
use treegen_runtime::form::{
    BinaryOp, Builtin, Code, Function, FunctionId, Op, Origin, Reg, Slot, UnaryOp, Value, Vector,
};
use treegen_runtime::{Fault, FaultKind, Limit, Limits};

fn env() -> Env {
    Env { slots: vec![Value::Number(4.0), Value::Number(0.0)], path: Path(1, 2), turn: 0 }
}

fn code(registers: u16, ops: Vec<Op>, result: u16) -> Code {
    Code { origins: vec![Origin::NONE; ops.len()].into(), ops: ops.into(), registers, results: Box::new([Reg(result)]) }
}

fn run_with(functions: &[Function], code: &Code) -> Result<Value, Fault> {
    let mut machine = Machine::new(functions, 7, &Limits::default());
    machine.run(code, &mut env()).map(|it| it[0].clone())
}

fn number(value: f64) -> Value {
    Value::Number(value)
}

fn binary(op: BinaryOp, a: Value, b: Value) -> Result<Value, Fault> {
    let ops = vec![Op::Constant(Reg(0), a), Op::Constant(Reg(1), b), Op::Binary(Reg(2), op, Reg(0), Reg(1))];
    run_with(&[], &code(3, ops, 2))
}

fn builtin(builtin: Builtin, args: &[Value]) -> Result<Value, Fault> {
    let mut ops: Vec<Op> = args.iter().enumerate().map(|(n, it)| Op::Constant(Reg(n as u16), it.clone())).collect();
    let to = Reg(args.len() as u16);
    ops.push(Op::Builtin(to, builtin, (0..args.len() as u16).map(Reg).collect()));
    run_with(&[], &code(to.0 + 1, ops, to.0))
}

fn vector(parts: &[f64]) -> Value {
    Value::Vector(Vector::new(parts).unwrap())
}

#[test]
fn remainders_have_the_sign_of_the_divisor() {
    for (a, b, rest) in [(7.0, 3.0, 1.0), (-7.0, 3.0, 2.0), (7.0, -3.0, -2.0), (-7.0, -3.0, -1.0), (6.0, 3.0, 0.0)] {
        assert_eq!(binary(BinaryOp::Remainder, number(a), number(b)), Ok(number(rest)));
    }
}

#[test]
fn vectors_add_and_scale_and_nothing_else() {
    let (a, b) = (vector(&[1.0, 2.0]), vector(&[10.0, 20.0]));
    assert_eq!(binary(BinaryOp::Add, a.clone(), b.clone()), Ok(vector(&[11.0, 22.0])));
    assert_eq!(binary(BinaryOp::Multiply, number(3.0), a.clone()), Ok(vector(&[3.0, 6.0])));
    assert_eq!(binary(BinaryOp::Divide, b.clone(), number(10.0)), Ok(a.clone()));
    for (op, x, y) in [
        (BinaryOp::Multiply, a.clone(), b),
        (BinaryOp::Add, a.clone(), number(1.0)),
        (BinaryOp::Add, a.clone(), vector(&[1.0, 2.0, 3.0])),
        (BinaryOp::Equal, a, number(1.0)),
    ] {
        assert!(matches!(binary(op, x, y), Err(Fault { kind: FaultKind::Type { .. }, .. })));
    }
}

#[test]
fn what_is_no_number_is_a_fault_and_infinity_needs_an_infinite_operand() {
    let inf = f64::INFINITY;
    for (op, a, b) in [
        (BinaryOp::Divide, 1.0, 0.0),
        (BinaryOp::Divide, inf, 0.0),
        (BinaryOp::Subtract, inf, inf),
        (BinaryOp::Multiply, 1e200, 1e200),
        (BinaryOp::Power, -1.0, 0.5),
        (BinaryOp::Remainder, 1.0, 0.0),
    ] {
        let result = binary(op, number(a), number(b));
        assert!(matches!(result, Err(Fault { kind: FaultKind::NotANumber { .. }, .. })), "{op:?} {a} {b}: {result:?}");
    }
    assert_eq!(binary(BinaryOp::Subtract, number(inf), number(1.0)), Ok(number(inf)));
    for (function, x) in
        [(Builtin::Ln, 0.0), (Builtin::Sqrt, -1.0), (Builtin::Acos, 2.0), (Builtin::Tan, 90.0), (Builtin::Exp, 1e3)]
    {
        assert!(builtin(function, &[number(x)]).is_err(), "{function:?}");
    }
}

#[test]
fn an_index_outside_its_list_is_told_with_the_length() {
    let list = Op::List(Reg(2), Box::new([Reg(0), Reg(1)]));
    for (index, fine) in [(0.0, true), (1.0, true), (2.0, false), (-1.0, false), (0.5, false), (f64::INFINITY, false)] {
        let ops = vec![
            Op::Constant(Reg(0), number(10.0)),
            Op::Constant(Reg(1), number(11.0)),
            list.clone(),
            Op::Constant(Reg(3), number(index)),
            Op::Index(Reg(4), Reg(2), Reg(3)),
        ];
        match run_with(&[], &code(5, ops, 4)) {
            Ok(value) => assert!(fine && value == number(10.0 + index)),
            Err(fault) => assert!(!fine && fault.kind == FaultKind::Index { index, length: 2 }),
        }
    }
}

#[test]
fn a_jump_leaves_out_what_is_not_asked_for() {
    // if slot0 == 4 then 1 else 1 / 0
    let ops = vec![
        Op::Load(Reg(0), Slot(0)),
        Op::Constant(Reg(1), number(4.0)),
        Op::Binary(Reg(2), BinaryOp::Equal, Reg(0), Reg(1)),
        Op::JumpUnless(Reg(2), 6),
        Op::Constant(Reg(3), number(1.0)),
        Op::Jump(8),
        Op::Constant(Reg(4), number(0.0)),
        Op::Binary(Reg(3), BinaryOp::Divide, Reg(1), Reg(4)),
    ];
    assert_eq!(run_with(&[], &code(5, ops, 3)), Ok(number(1.0)));
}

/// A function of one parameter that calls itself until it is 0, and sums up.
fn triangular() -> Function {
    let ops = vec![
        Op::Param(Reg(0), 0),
        Op::Constant(Reg(1), number(0.0)),
        Op::Binary(Reg(2), BinaryOp::Equal, Reg(0), Reg(1)),
        Op::JumpIf(Reg(2), 8),
        Op::Constant(Reg(3), number(1.0)),
        Op::Binary(Reg(4), BinaryOp::Subtract, Reg(0), Reg(3)),
        Op::Call { to: Reg(5), function: FunctionId(0), args: Box::new([Reg(4)]), place: 9 },
        Op::Binary(Reg(1), BinaryOp::Add, Reg(0), Reg(5)),
    ];
    Function { name: "sum".into(), params: 1, code: code(6, ops, 1), origin: Origin::NONE }
}

fn call_triangular(of: f64) -> Result<Value, Fault> {
    let ops = vec![
        Op::Constant(Reg(0), number(of)),
        Op::Call { to: Reg(1), function: FunctionId(0), args: Box::new([Reg(0)]), place: 3 },
        Op::Unary(Reg(2), UnaryOp::Negate, Reg(0)),
        Op::Binary(Reg(3), BinaryOp::Add, Reg(1), Reg(2)),
    ];
    run_with(&[triangular()], &code(4, ops, 3))
}

#[test]
fn functions_call_themselves_to_the_limit_and_leave_the_callers_registers_alone() {
    assert_eq!(call_triangular(10.0), Ok(number(45.0)));
    assert_eq!(call_triangular(127.0), Ok(number(127.0 * 126.0 / 2.0)));
    let fault = call_triangular(128.0).expect_err("one too deep");
    assert_eq!(fault.kind, FaultKind::Limit { limit: Limit::Calls, most: 128 });
}

#[test]
fn a_draw_depends_on_path_place_turn_and_seed_and_on_nothing_else() {
    let draw = |seed, path, turn, place| {
        let mut machine = Machine::new(&[], seed, &Limits::default());
        let mut env = Env { path, turn, ..env() };
        let first = machine.run(&common::random(0.0, 1.0, place), &mut env).unwrap()[0].clone();
        // Asked again it is the same.
        assert_eq!(first, machine.run(&common::random(0.0, 1.0, place), &mut env).unwrap()[0]);
        first
    };
    let base = draw(1, Path(1, 2), 0, 5);
    assert_ne!(base, draw(2, Path(1, 2), 0, 5));
    assert_ne!(base, draw(1, Path(1, 3), 0, 5));
    assert_ne!(base, draw(1, Path(2, 2), 0, 5));
    assert_ne!(base, draw(1, Path(1, 2), 1, 5));
    assert_ne!(base, draw(1, Path(1, 2), 0, 6));
}

#[test]
fn operations_without_end_meet_the_limit() {
    let mut machine = Machine::new(&[], 0, &Limits { operations: 2, ..Limits::default() });
    let code = code(3, vec![Op::Constant(Reg(0), number(1.0)), Op::Copy(Reg(1), Reg(0)), Op::Copy(Reg(2), Reg(1))], 2);
    let fault = machine.run(&code, &mut env()).expect_err("three operations");
    assert_eq!(fault.kind, FaultKind::Limit { limit: Limit::Operations, most: 2 });
}

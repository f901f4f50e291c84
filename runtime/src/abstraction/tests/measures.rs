//! Which slots hold measures.

use super::super::measures::Measures;
use crate::form::{
    BinaryOp, Builtin, Call, Choice, Code, Graph, Node, NodeId, Op, Origin, PrimitiveKind, Reg, Rule, Select, SelectId,
    Slot, System, SystemId, Value,
};

fn code(ops: Vec<Op>, results: &[u16]) -> Code {
    let origins = vec![Origin::NONE; ops.len()].into();
    Code { ops: ops.into(), origins, registers: 4, results: results.iter().map(|it| Reg(*it)).collect() }
}

#[test]
fn what_noise_has_gone_into_is_a_measure_and_a_counter_is_none() {
    // T(height + noise(height), left - 1): the register of the noise is used again for the 1 and for the counter.
    let args = code(
        vec![
            Op::Load(Reg(0), Slot(0)),
            Op::Builtin(Reg(1), Builtin::Noise, [Reg(0)].into()),
            Op::Binary(Reg(3), BinaryOp::Add, Reg(0), Reg(1)),
            Op::Load(Reg(2), Slot(1)),
            Op::Constant(Reg(1), Value::Number(1.0)),
            Op::Binary(Reg(1), BinaryOp::Subtract, Reg(2), Reg(1)),
        ],
        &[3, 1],
    );
    let nodes = vec![
        Node::Primitive { kind: PrimitiveKind::Sphere, code: Code::default(), origin: Origin::NONE },
        Node::Call(Call { select: SelectId(0), args, place: 1, origin: Origin::NONE }),
    ];
    let rule = |body| Rule { label: None, guard: None, weight: None, body, origin: Origin::NONE };
    let select = Select {
        module: "T".to_owned(),
        system: SystemId(0),
        params: vec![Slot(0), Slot(1)],
        choice: Choice::First,
        rules: vec![rule(NodeId(0)), rule(NodeId(1))],
        proxy: None,
        origin: Origin::NONE,
    };
    let system = System {
        name: "S".to_owned(),
        slots: vec!["height".to_owned(), "left".to_owned()],
        formals: Vec::new(),
        lets: Code::default(),
        vars: Code::default(),
        start: NodeId(1),
        origin: Origin::NONE,
    };
    let graph = Graph::new(nodes, vec![select], vec![system], Vec::new(), SystemId(0)).expect("it fits together");
    let measures = Measures::of(&graph, |_| Some(0));
    assert!(measures.holds(0, Slot(0)));
    assert!(!measures.holds(0, Slot(1)));
}

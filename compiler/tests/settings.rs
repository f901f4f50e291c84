//! Values given from outside.

mod common;

use common::{codes, compiled_with};
use treegen_runtime::form::{Code, Op, Value};

const PROGRAM: &str = "
    param height = 3 in 1..9;
    csg Tree(order = 6 in 0..inf, wide = false, at = (0, 0, 1)) { start move(at) uscale(if wide then order else height) sphere; }
    scene { sun { direction: (0, 0, -1), strength: height } show Tree(); }";

fn constants(code: &Code) -> Vec<Value> {
    code.ops.iter().filter_map(|it| if let Op::Constant(_, value) = it { Some(value.clone()) } else { None }).collect()
}

#[test]
fn a_param_is_set() {
    let compiled = compiled_with(PROGRAM, &[("height", "2 ^ 2")]);
    assert_eq!(compiled.scene.map(|it| it.suns[0].strength), Some(4.0));
}

#[test]
fn a_formal_gets_a_new_default() {
    let settings = [("Tree.order", "inf"), ("Tree.wide", "true"), ("Tree.at", "(1, 2, 3)")];
    let scene = compiled_with(PROGRAM, &settings).scene.unwrap();
    let tree = scene.graph.systems().iter().find(|it| it.name == "Tree").unwrap();
    let defaults: Vec<Value> = tree.formals.iter().flat_map(|it| constants(it.default.as_ref().unwrap())).collect();
    assert_eq!(defaults[..2], [Value::Number(f64::INFINITY), Value::Bool(true)]);
    assert!(matches!(defaults[2], Value::Vector(it) if it.parts() == [1.0, 2.0, 3.0]));
}

#[test]
fn without_a_scene_the_formals_of_the_system_shown_need_no_prefix() {
    let program = "csg Tree(order) { start uscale(order) sphere; }";
    let compiled = compiled_with(program, &[("order", "2")]);
    assert!(compiled.scene.is_some());
}

#[test]
fn the_last_of_several_settings_counts() {
    let compiled = compiled_with(PROGRAM, &[("height", "4"), ("height", "5")]);
    assert_eq!(compiled.scene.map(|it| it.suns[0].strength), Some(5.0));
}

#[test]
fn wrong_settings_are_told_apart_from_wrong_programs() {
    for (name, value, code) in [
        ("hieght", "2", "E0801"),
        ("Tree.height", "2", "E0801"),
        ("height", "2; let x = 1", "E0802"),
        ("height", "20", "E0803"),
        ("height", "(1", "E0802"),
        ("height", "tall", "E0803"),
        ("Tree.order", "-1", "E0803"),
    ] {
        let compiled = compiled_with(PROGRAM, &[(name, value)]);
        assert_eq!(codes(&compiled), [code], "{name}={value}");
        assert!(compiled.problems.iter().all(treegen_compiler::Problem::is_about_settings));
        assert!(compiled.scene.is_none());
    }
}

#[test]
fn a_setting_of_another_type_is_a_problem_of_the_setting() {
    for (name, value) in [("Tree.order", "true"), ("height", "(1, 2)"), ("Tree.at", "3")] {
        let compiled = compiled_with(PROGRAM, &[(name, value)]);
        assert_eq!(codes(&compiled), ["E0803"], "{name}={value}");
    }
}

#[test]
fn a_misspelled_setting_suggests_the_name_that_fits() {
    let compiled = compiled_with(PROGRAM, &[("Tree.ordr", "2")]);
    assert_eq!(compiled.problems[0].suggestions[0].text, "did you mean `Tree.order`?");
}

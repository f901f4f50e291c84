//! What is exported is what rays see: the pieces of a scene, met by brute force, give what the reference walker gives, and what is
//! written is read back as the same.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{is_steady, look};
use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use serde_json::Value;
use treegen_runtime::Limits;
use treegen_runtime::export::{Boolean, Piece, Pieces, Placed, write_json};
use treegen_runtime::form::{MaterialId, Node, PrimitiveKind, Scene};
use treegen_runtime::geometry::{Intervals, Primitive, Ray};
use treegen_runtime::trace::reference::Reference;

/// A piece with all that belongs to it.
enum Tree {
    Primitive(Placed),
    Boolean(Boolean, Vec<Vec<Tree>>),
}

fn pieces(scene: &Scene) -> Vec<Piece> {
    let pieces = Pieces::of(scene, &Limits::default(), &()).expect("these scenes have no faults");
    pieces.collect::<Result<_, _>>().expect("these scenes have no faults")
}

/// The trees up to the end of the list, or of the operand that the first piece is in.
fn trees(pieces: &mut impl Iterator<Item = Piece>) -> Vec<Tree> {
    let mut trees = Vec::new();
    while let Some(piece) = pieces.next() {
        match piece {
            Piece::Primitive(placed) => trees.push(Tree::Primitive(placed)),
            Piece::Begin(boolean) => {
                let mut operands = Vec::new();
                while let Some(Piece::BeginOperand) = pieces.next() {
                    operands.push(self::trees(pieces));
                }
                trees.push(Tree::Boolean(boolean, operands));
            }
            Piece::EndOperand => return trees,
            Piece::BeginOperand | Piece::End => unreachable!("operands stand in Booleans, and end before them"),
        }
    }
    trees
}

/// Where a line is inside, with the routes and paints of the surfaces it crosses.
fn inside(trees: &[Tree], ray: &Ray) -> Intervals<(u64, Option<MaterialId>)> {
    let inside = |tree: &Tree| match tree {
        Tree::Primitive(placed) => {
            let primitive = Primitive::new(placed.kind, &placed.parameters).unwrap();
            let chords = primitive.chords(&ray.mapped(&placed.world_from_primitive.inverse()), None);
            Intervals::of_chords(&chords, |_| (placed.route, placed.material))
        }
        Tree::Boolean(boolean, operands) => {
            let mut operands = operands.iter().map(|it| inside(it, ray));
            let first = operands.next().unwrap();
            operands.fold(first, |all, it| match boolean {
                Boolean::Intersection => all.intersection(&it, 1e-12),
                Boolean::Difference => all.difference(&it, 1e-12),
            })
        }
    };
    Intervals::union_of(&trees.iter().map(inside).collect::<Vec<_>>(), 0.0)
}

fn compare(scene: &Scene) -> Result<(), String> {
    let reference = Reference::new(scene, &Limits::default());
    let trees = trees(&mut pieces(scene).into_iter());
    let rays = common::ray_bundle(12, 1.6);
    for (ray, sample) in rays.iter().zip(look(&reference, &rays)) {
        let inside = inside(&trees, ray);
        let ends = inside.as_slice().iter().flat_map(|it| [it.near, it.far]);
        let first = ends.filter(|it| it.t > 0.0).min_by(|a, b| a.t.total_cmp(&b.t));
        let same = match (first, sample.first()) {
            (None, None) => true,
            (Some(end), Some(seen)) => {
                (end.t - seen.depth).abs() <= 1e-9 * seen.depth && end.surface == (seen.route, seen.material)
            }
            _ => false,
        };
        if !same && is_steady(&reference, ray) {
            return Err(format!("{ray:?}\nby the book {sample:?}\nexported {first:?}"));
        }
    }
    Ok(())
}

/// A primitive or a Boolean as it was written.
fn read(json: &Value) -> Tree {
    let kind = json["kind"].as_str().unwrap();
    let boolean = match kind {
        "intersection" => Boolean::Intersection,
        "difference" => Boolean::Difference,
        _ => return Tree::Primitive(read_primitive(kind, json)),
    };
    let operand = |it: &Value| it.as_array().unwrap().iter().map(read).collect();
    Tree::Boolean(boolean, json["operands"].as_array().unwrap().iter().map(operand).collect())
}

fn read_primitive(kind: &str, json: &Value) -> Placed {
    let kinds = [
        PrimitiveKind::Sphere,
        PrimitiveKind::Cylinder,
        PrimitiveKind::Box,
        PrimitiveKind::Tetrahedron,
        PrimitiveKind::Cone,
        PrimitiveKind::Torus,
        PrimitiveKind::Ellipsoid,
    ];
    let number = |it: &Value| it.as_f64().unwrap();
    let m = |row: usize, column: usize| number(&json["world_from_primitive"][row][column]);
    let column = |column| DVec3::new(m(0, column), m(1, column), m(2, column));
    let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
    Placed {
        kind: *kinds.iter().find(|it| it.name() == kind).unwrap(),
        parameters: json["parameters"].as_array().unwrap().iter().map(number).collect(),
        world_from_primitive: DAffine3 { matrix3, translation: column(3) },
        material: json["material"].as_str().map(|it| MaterialId(it.parse().unwrap())),
        route: 0,
    }
}

fn assert_same(one: &[Tree], other: &[Tree]) {
    assert_eq!(one.len(), other.len());
    for pair in one.iter().zip(other) {
        match pair {
            (Tree::Primitive(one), Tree::Primitive(other)) => {
                assert_eq!((one.kind, &one.parameters, one.material), (other.kind, &other.parameters, other.material));
                assert_eq!(one.world_from_primitive, other.world_from_primitive);
            }
            (Tree::Boolean(one, one_operands), Tree::Boolean(other, other_operands)) => {
                assert_eq!((one, one_operands.len()), (other, other_operands.len()));
                one_operands.iter().zip(other_operands).for_each(|(one, other)| assert_same(one, other));
            }
            _ => panic!("a primitive is no Boolean"),
        }
    }
}

/// Scenes made at random, all that they show painted with one of two materials, which are called by their numbers.
fn painted(seed: u64) -> Scene {
    let scene = common::random_scene(seed);
    let mut nodes = scene.graph.nodes().to_vec();
    let mut systems = scene.graph.systems().to_vec();
    nodes.push(Node::Paint { material: MaterialId((seed % 2) as u32), body: systems[0].start });
    systems[0].start = treegen_runtime::form::NodeId(nodes.len() as u32 - 1);
    let (selects, functions) = (scene.graph.selects().to_vec(), scene.graph.functions().to_vec());
    let graph = treegen_runtime::form::Graph::new(nodes, selects, systems, functions, scene.graph.root()).unwrap();
    let material = |name: &str| treegen_runtime::form::Material { name: name.into(), ..Default::default() };
    Scene { materials: vec![material("0"), material("1")], ..common::scene_of(graph) }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_exported_is_what_is_seen_by_the_book(seed in any::<u64>()) {
        compare(&painted(seed)).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn what_is_written_as_json_is_read_back_as_the_same(seed in any::<u64>()) {
        let scene = painted(seed);
        let mut text = Vec::new();
        write_json(&scene, &mut Pieces::of(&scene, &Limits::default(), &()).unwrap(), &mut text).unwrap();
        let lines: Vec<Value> = text.split(|it| *it == b'\n').filter(|it| !it.is_empty())
            .map(|it| serde_json::from_slice(it).unwrap()).collect();
        let (records, written): (Vec<&Value>, Vec<&Value>) = lines.iter().partition(|it| it["kind"] == "material");
        prop_assert_eq!(records.len(), 2);
        let written: Vec<Tree> = written.into_iter().map(read).collect();
        assert_same(&written, &trees(&mut pieces(&scene).into_iter()));
    }
}

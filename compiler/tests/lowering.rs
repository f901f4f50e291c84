//! What programs become.

#![allow(clippy::expect_used, reason = "a test that cannot go on has failed")]

mod common;

use common::{codes, compiled, graph, scene};
use treegen_runtime::Limits;
use treegen_runtime::eval::{Env, Machine, Path};
use treegen_runtime::form::{
    Choice, Code, Fbm, Fourier, Graph, Material, Node, NodeId, Op, Pattern, PrimitiveKind, Select, Slot, Space,
    Texture, TextureId, TransformKind, Value,
};

/// What a node is made of, as text: kinds and operands, without codes and places, and without C-nodes.
fn shape(graph: &Graph, id: NodeId) -> String {
    let all = |ids: &[NodeId], sign: &str| {
        let parts: Vec<String> = ids.iter().map(|it| shape(graph, *it)).collect();
        format!("({})", parts.join(sign))
    };
    match graph.node(id) {
        Node::Empty => "nothing".to_owned(),
        Node::Primitive { kind, .. } => kind.name().to_owned(),
        Node::Transform { kind, body, .. } => format!("{} {}", kind.name(), shape(graph, *body)),
        Node::Calc { body, .. } => shape(graph, *body),
        Node::Paint { material, body } => format!("paint{} {}", material.0, shape(graph, *body)),
        Node::Variant { body, .. } => format!("variant {}", shape(graph, *body)),
        Node::Repeat { body, .. } => format!("repeat {}", shape(graph, *body)),
        Node::Choice { then, otherwise, .. } => {
            format!("if {{ {} }} else {{ {} }}", shape(graph, *then), shape(graph, *otherwise))
        }
        Node::Union(ids) => all(ids, " | "),
        Node::Intersect(ids) => all(ids, " & "),
        Node::Difference(first, ids) => format!("{} \\ {}", shape(graph, *first), all(ids, " \\ ")),
        Node::Call(call) => graph.select(call.select).module.clone(),
        Node::System(call) => format!("{}()", graph.system(call.system).name),
        Node::Shape(shape) => format!("shape of {}", graph.system(graph.shape(*shape).system).name),
    }
}

/// The shape of everything that is shown.
fn shown(text: &str) -> String {
    let graph = graph(text);
    shape(&graph, graph.system(graph.root()).start)
}

/// The shapes of all rules, with their modules.
fn rules(graph: &Graph) -> Vec<String> {
    let of = |select: &Select| {
        let module = select.module.clone();
        select.rules.iter().map(|it| format!("{module} -> {}", shape(graph, it.body))).collect::<Vec<_>>()
    };
    graph.selects().iter().flat_map(of).collect()
}

fn select<'g>(graph: &'g Graph, module: &str) -> &'g Select {
    graph.selects().iter().find(|it| it.module == module).expect("the module is needed")
}

/// The number that an expression has, found on the way through everything.
fn number(expr: &str) -> f64 {
    scene(&format!("scene {{ sun {{ direction: (0, 0, -1), strength: {expr} }} show sphere; }}")).suns[0].strength
}

const SIERPINSKI: &str = "
    csg Sierpinski(order = 6 in 0..inf) {
      start S(order);
      stop:  S(c) if c == 0 -> tetrahedron;
      split: S(c) -> move(.5, .5, .5) uscale(.5) S(c - 1) | move(-.5, -.5, .5) uscale(.5) S(c - 1);
    }
    material Clay { color: (.8, .45, .3), gloss: .25 }
    scene { camera { eye: (2, -5, 1), target: (0, 0, .5), fov: 32 } show paint(Clay) Sierpinski(); }";

#[test]
fn a_program_becomes_a_cyclic_graph() {
    let scene = scene(SIERPINSKI);
    let graph = &scene.graph;
    assert_eq!(shape(graph, graph.system(graph.root()).start), "paint0 Sierpinski()");
    assert_eq!(rules(graph), ["S -> tetrahedron", "S -> (move uscale S | move uscale S)"]);
    assert_eq!(select(graph, "S").params.len(), 1);
    assert_eq!(select(graph, "S").choice, Choice::First);
    assert_eq!(scene.materials[0].color, [0.8, 0.45, 0.3]);
    assert_eq!(scene.materials[0].gloss, 0.25);
    assert_eq!(scene.camera.as_ref().map(|it| it.eye.to_array()), Some([2.0, -5.0, 1.0]));
}

#[test]
fn arguments_and_assignments_make_the_same_graph() {
    let assigned = "
        csg Sierpinski(order = 6) {
          var c = order;
          start S;
          stop:  S if c == 0 -> tetrahedron;
          split: S -> { c = c - 1 } (move(.5, .5, .5) uscale(.5) S | move(-.5, -.5, .5) uscale(.5) S);
        }
        material Clay { color: (.8, .45, .3) }
        scene { show paint(Clay) Sierpinski(); }";
    assert_eq!(rules(&graph(SIERPINSKI)), rules(&graph(assigned)));
}

#[test]
fn a_file_without_a_scene_shows_its_last_system() {
    assert_eq!(shown("csg A { start sphere; } csg B { start box; }"), "B()");
    assert_eq!(shown("csg A { start sphere; } csg B { start box; } scene { show A(); }"), "A()");
}

#[test]
fn everything_shown_is_united_in_order() {
    assert_eq!(
        shown("scene { show sphere; show box | cylinder; show nothing; }"),
        "(sphere | (box | cylinder) | nothing)"
    );
}

#[test]
fn cuts_of_one_level_are_one_node() {
    let kept = "(sphere & box & cone)";
    assert_eq!(
        shown("scene { show sphere & box \\ cylinder & cone(1, 1) \\ torus(2); }"),
        format!("{kept} \\ (cylinder \\ torus)")
    );
    assert_eq!(shown("scene { show sphere \\ (box | cylinder); }"), "sphere \\ (box \\ cylinder)");
    assert_eq!(shown("scene { show (sphere \\ box) \\ cylinder; }"), "sphere \\ (box \\ cylinder)");
    assert_eq!(shown("scene { show sphere \\ (box \\ cylinder); }"), "sphere \\ (box \\ (cylinder))");
}

#[test]
fn unions_are_flat() {
    assert_eq!(shown("scene { show sphere | (box | (cylinder | nothing)) | box; }"), "(sphere | box | cylinder | box)");
}

#[test]
fn an_operator_holds_for_the_rest_of_its_chain() {
    assert_eq!(shown("scene { show move(1, 2, 3) uscale(2) sphere | box; }"), "(move uscale sphere | box)");
    assert_eq!(shown("scene { show move(1, 2, 3) (sphere | box); }"), "move (sphere | box)");
}

#[test]
fn a_vector_stands_for_its_numbers() {
    let graph = graph("scene { show move((1, 2, 3)) rotate((0, 0, 1), 90) halfspace((0, 0, 1), 2); }");
    let mut found = Vec::new();
    for node in graph.nodes() {
        match node {
            Node::Transform { kind, code, .. } => found.push((Some(*kind), results(&graph, code))),
            Node::Primitive { code, .. } => found.push((None, results(&graph, code))),
            _ => {}
        }
    }
    assert_eq!(
        found,
        [
            (None, vec![0.0, 0.0, 1.0, 2.0]),
            (Some(TransformKind::Rotate), vec![0.0, 0.0, 1.0, 90.0]),
            (Some(TransformKind::Move), vec![1.0, 2.0, 3.0]),
        ]
    );
}

/// The numbers that a code gives in an environment without slots.
fn results(graph: &Graph, code: &Code) -> Vec<f64> {
    let mut machine = Machine::new(graph.functions(), 0, &Limits::default());
    let mut env = Env { slots: Vec::new(), path: Path::default(), turn: 0 };
    let results = machine.run(code, &mut env).expect("nothing in it fails");
    results.iter().map(|it| if let Value::Number(it) = it { *it } else { f64::NAN }).collect()
}

#[test]
fn arithmetic_is_that_of_the_language() {
    for (expr, value) in [
        ("10 + -2 ^ 2", 6.0),
        ("2 ^ 3 ^ 2", 512.0),
        ("2 ^ -1", 0.5),
        ("-7 % 3", 2.0),
        ("5 + 7 % -3", 3.0),
        ("10 - 3 - 2", 5.0),
        ("24 / 4 / 3", 2.0),
        ("sin(30) + cos(60)", 1.0),
        ("atan2(1, 1)", 45.0),
        ("(1, 2, 3).z + [4, 5, 6][1]", 8.0),
        ("norm((3, 4)) + dot((1, 2), (3, 4))", 16.0),
        ("if 1 < 2 and not 3 < 2 then 1 else 2", 1.0),
        ("if 1 > 2 then 1 else if 2 > 3 then 2 else 3", 3.0),
        ("mix(2, 4, .25) + max(1, 5, 3)", 7.5),
    ] {
        assert!((number(expr) - value).abs() < 1e-12, "{expr} is {}", number(expr));
    }
}

#[test]
fn and_or_and_if_look_at_no_more_than_they_need() {
    assert_eq!(number("if 1 > 2 and 1 / 0 > 0 then 1 else 2"), 2.0);
    assert_eq!(number("if 1 < 2 or 1 / 0 > 0 then 1 else 2"), 1.0);
    assert_eq!(number("if 1 < 2 then 1 else 1 / 0"), 1.0);
}

#[test]
fn a_use_may_stand_before_the_definition() {
    let text = "
        let a = b + f(2);
        fn f(x) = x * c;
        let b = 1;
        param c = 10;
        scene { sun { direction: (0, 0, -1), strength: a } show sphere; }";
    assert_eq!(scene(text).suns[0].strength, 21.0);
}

#[test]
fn a_systems_lets_are_found_each_after_those_it_reads() {
    let graph =
        graph("csg A(n = 4) { let b = f(a) + 1; fn f(x) = x * k; let a = n; let k = a + 1; start uscale(b) sphere; }");
    let system = graph.systems().iter().find(|it| it.name == "A").expect("it is shown");
    let mut env = Env { slots: vec![Value::Number(4.0); system.slots.len()], path: Path::default(), turn: 0 };
    Machine::new(graph.functions(), 0, &Limits::default()).run(&system.lets, &mut env).expect("nothing in it fails");
    let b = system.slots.iter().position(|it| it == "b").expect("it has a slot");
    assert_eq!(env.slots[b], Value::Number(21.0));
}

#[test]
fn a_formals_range_is_looked_at_when_the_system_is_called() {
    let graph = graph("csg A(n = 4 in 1..9) { start uscale(n) sphere; }");
    let system = graph.systems().iter().find(|it| it.name == "A").expect("it is shown");
    let check = system.formals[0].check.as_ref().expect("it has a range");
    let run = |value: f64| {
        let mut env = Env { slots: vec![Value::Number(value)], path: Path::default(), turn: 0 };
        Machine::new(&[], 0, &Limits::default()).run(check, &mut env).is_ok()
    };
    assert!(run(1.0) && run(9.0));
    assert!(!run(0.5) && !run(9.5));
}

#[test]
fn a_label_is_its_rules_number() {
    let text =
        "csg A { var n = 1; start t; select t by if n > 0 then b else a; a: t -> box; b: t -> sphere | { n = 0 } t; }";
    let graph = graph(text);
    let Choice::Function(code) = &select(&graph, "t").choice else { panic!("it is selected by a function") };
    let constants: Vec<&Value> =
        code.ops.iter().filter_map(|it| if let Op::Constant(_, value) = it { Some(value) } else { None }).collect();
    assert_eq!(constants, [&Value::Number(0.0), &Value::Number(2.0), &Value::Number(1.0)]);
}

#[test]
fn weights_make_a_draw() {
    let graph = graph("csg A { start t; t @ 2 -> box; t @ 1 -> sphere; }");
    assert!(matches!(select(&graph, "t").choice, Choice::Weighted(_)));
}

#[test]
fn a_calc_is_put_in_where_it_is_run_inside_its_place() {
    let text =
        "csg A { var n = 3; calc less { let d = random(0, 1); n = n - d } start { less; less } uscale(n) sphere; }";
    let graph = graph(text);
    let code = graph.nodes().iter().find_map(|it| if let Node::Calc { code, .. } = it { Some(code) } else { None });
    let code = code.expect("there is a C-node");
    let kind = |op: &Op| match op {
        Op::Enter(_) => Some("enter"),
        Op::Leave => Some("leave"),
        Op::Store(..) => Some("store"),
        Op::Draw { .. } => Some("draw"),
        _ => None,
    };
    let kinds: Vec<&str> = code.ops.iter().filter_map(kind).collect();
    let once = ["enter", "draw", "store", "store", "leave"];
    assert_eq!(kinds, [once, once].concat());
    let places: Vec<u64> =
        code.ops.iter().filter_map(|it| if let Op::Enter(it) = it { Some(*it) } else { None }).collect();
    assert_ne!(places[0], places[1], "each run draws for itself");
}

#[test]
fn a_proxy_belongs_to_its_module() {
    let graph = graph("csg A { start t; t -> box | uscale(.5) t; proxy t -> sphere; }");
    let proxy = select(&graph, "t").proxy.expect("it has one");
    assert!(matches!(graph.node(proxy), Node::Primitive { kind: PrimitiveKind::Sphere, .. }));
}

#[test]
fn a_systems_arguments_find_their_formals() {
    let graph = graph("csg A(a = 1, b = 2) { start scale(a, b, 1) sphere; } scene { show A(b: 3, seed: 7); }");
    let call = graph.nodes().iter().find_map(|it| if let Node::System(call) = it { Some(call) } else { None });
    let call = call.expect("there is a call");
    assert_eq!(call.given, [Slot(1)]);
    assert_eq!(results(&graph, &call.args), [3.0]);
    assert_eq!(call.seed.as_ref().map(|it| results(&graph, it)), Some(vec![7.0]));
}

#[test]
fn what_nothing_shows_is_not_lowered() {
    let graph = graph("csg A { start sphere; } shape B { start segment(1, 1, 1); } csg C { start A(); }");
    let names: Vec<&str> = graph.systems().iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["scene", "C", "A"]);
}

/// The places of all draws and calls of a module, in order.
fn places(graph: &Graph, module: &str) -> Vec<u64> {
    let mut places = Vec::new();
    let mut of_code = |code: &Code| {
        for op in &code.ops {
            match op {
                Op::Draw { place, .. } | Op::Call { place, .. } | Op::Enter(place) => places.push(*place),
                _ => {}
            }
        }
    };
    for rule in &select(graph, module).rules {
        rule.guard.iter().chain(&rule.weight).for_each(&mut of_code);
        let mut stack = vec![rule.body];
        while let Some(id) = stack.pop() {
            match graph.node(id) {
                Node::Transform { code, body, .. } | Node::Calc { code, body, .. } => {
                    of_code(code);
                    stack.push(*body);
                }
                Node::Union(ids) => stack.extend(ids.iter().rev()),
                Node::Call(call) => of_code(&call.args),
                _ => {}
            }
        }
    }
    places
}

const PLANT: &str = "csg Plant { var n = 9; start apex(1); fn bent(x) = gauss(x, 3); calc less { n = n - random(0, 1) }
    grow: apex(a) if chance(.5) @ random(1, 2) -> sphere | { less } rotz(random(0, 360)) rotx(bent(a)) apex(gauss(0, 1));
    apex(a) @ 1 -> rotz(random(0, 1)) sphere; }";

#[test]
fn comments_layout_and_rules_added_elsewhere_move_no_place() {
    let plain = places(&graph(PLANT), "apex");
    assert_eq!(plain.len(), 8);
    let spaced = PLANT.replace(' ', "\n  /* here */ ");
    assert_eq!(places(&graph(&spaced), "apex"), plain);
    let grown = PLANT
        .replace(
            "csg Plant {",
            "let k = random(0, 1); csg Plant { let first = random(0, 1); other -> rotz(random(0, 1)) box;",
        )
        .replace("start apex(1);", "start apex(1) | uscale(first * k) other;");
    assert_eq!(places(&graph(&grown), "apex"), plain);
}

#[test]
fn each_draw_has_a_place_of_its_own() {
    let mut places = places(&graph(PLANT), "apex");
    let count = places.len();
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), count);
}

#[test]
fn a_label_keeps_a_rules_draws_when_rules_are_added_before_it() {
    let before = graph(PLANT);
    let after = graph(&PLANT.replace("grow: apex", "first: apex(a) @ 1 -> box; grow: apex"));
    let count = places(&before, "apex").len() - 1;
    assert_eq!(places(&before, "apex")[..count], places(&after, "apex")[..count]);
}

#[test]
fn long_chains_lower_without_deep_stacks() {
    let count = 100_000;
    let union = "sphere | ".repeat(count);
    let cut = " \\ box".repeat(count);
    let chain = "uscale(2) ".repeat(count);
    let sum = "1 + ".repeat(count);
    let text =
        format!("let a = {sum} 1; scene {{ show {union} uscale(a) sphere; show sphere {cut}; show {chain} sphere; }}");
    let worker = std::thread::Builder::new().stack_size(2 << 20).spawn(move || graph(&text).nodes().len());
    let nodes = worker.expect("a thread starts").join().expect("it ends well");
    assert!(nodes > 3 * count);
}

#[test]
fn nesting_up_to_its_limit_needs_no_deep_stack() {
    let depth = 250;
    let (open, close) = ("(".repeat(depth), ")".repeat(depth));
    let choice = "if 1 < 2 { ".repeat(depth / 2);
    let ends = " }".repeat(depth / 2);
    let text =
        format!("let a = {open}1{close}; scene {{ show {open}uscale(a) sphere{close}; show {choice} sphere {ends}; }}");
    let worker = std::thread::Builder::new().stack_size(2 << 20).spawn(move || codes(&compiled(&text)));
    assert_eq!(worker.expect("a thread starts").join().expect("it ends well"), [""; 0]);
}

#[test]
fn calcs_that_double_are_stopped() {
    let mut text = "csg A { var n = 1; calc c0 { n = n + 1 }".to_owned();
    for number in 1..40 {
        text.push_str(&format!("calc c{number} {{ c{0}; c{0} }}", number - 1));
    }
    text.push_str("start { c39 } uscale(n) sphere; }");
    assert_eq!(codes(&compiled(&text)), ["E0905"]);
}

#[test]
fn materials_bring_the_textures_they_name() {
    let scene = scene(
        "texture Spare { kind: chunks, colors: [(1, 0, 0)] }
         texture Bark { kind: fbm, octaves: 3, dimension: 2.5, seed: 4, space: world }
         texture Foliage { kind: fourier, terms: 7, ratio: 1.5, stretch: (1, 2, 3), offset: (0, 0, 9) }
         texture Plain { kind: fbm }
         material Unused { shade: Plain }
         material Leaf { shade: Foliage, amount: .7, bump: Bark, mirror: .2 }
         material Trunk { bump: Bark, depth: .04 }
         scene { show paint(Leaf) sphere | paint(Trunk) box; }",
    );
    let (bark, foliage) = (Some(TextureId(1)), Some(TextureId(0)));
    let names: Vec<&str> = scene.textures.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["Foliage", "Bark"]);
    let leaf = Material {
        name: "Leaf".into(),
        shade: foliage,
        amount: 0.7,
        bump: bark,
        mirror: 0.2,
        origin: scene.materials[0].origin,
        ..Material::default()
    };
    let trunk = Material {
        name: "Trunk".into(),
        bump: bark,
        depth: 0.04,
        origin: scene.materials[1].origin,
        ..Material::default()
    };
    assert_eq!(scene.materials, [leaf, trunk]);
    let fourier = Pattern::Fourier(Fourier { terms: 7, ratio: 1.5, ..Fourier::default() });
    let foliage = Texture {
        name: "Foliage".into(),
        stretch: [1.0, 2.0, 3.0].into(),
        offset: [0.0, 0.0, 9.0].into(),
        origin: scene.textures[0].origin,
        ..Texture::new(fourier)
    };
    let bark = Texture {
        name: "Bark".into(),
        space: Space::World,
        seed: 4.0,
        origin: scene.textures[1].origin,
        ..Texture::new(Pattern::Fbm(Fbm { octaves: 3, dimension: 2.5, ..Fbm::default() }))
    };
    assert_eq!(scene.textures, [foliage, bark]);
}

#[test]
fn a_texture_is_measured_where_its_kind_belongs_unless_it_says() {
    let space = |texture: &str| {
        let program = format!("texture T {{ {texture} }} material M {{ shade: T }} scene {{ show paint(M) box; }}");
        scene(&program).textures[0].space
    };
    assert_eq!(space("kind: fbm"), Space::Object);
    assert_eq!(space("kind: fourier"), Space::World);
    assert_eq!(space("kind: fourier, space: object"), Space::Object);
    assert_eq!(space("space: world, kind: fbm"), Space::World);
}

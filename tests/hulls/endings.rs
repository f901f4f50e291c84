//! What ends a hull's derivation, and what makes no hull.

use treegen_runtime::trace::Tracer;
use treegen_runtime::trace::cells::{CellTracer, Culling};
use treegen_runtime::trace::reference::Reference;
use treegen_runtime::{Fault, FaultKind, Limit, Limits};

use crate::common::{compiled, scene};
use crate::support::{fault, normals_of};

const DOUBLING: &str = "hull H {
    start [ N(1) ] [ rotx(180) N(1) ];
    derive parallel GENERATIONS;
    prune none;
    N(len) -> [ rotx(10) N(len) ] [ rotx(-10) N(len) ];
} scene { show H() & sphere; }";

#[test]
fn planes_end_at_their_limit_long_before_two_to_the_sixtieth() {
    for generations in ["14", "60", "1e9"] {
        let fault = fault(&DOUBLING.replace("GENERATIONS", generations));
        assert_eq!(fault.kind, FaultKind::Limit { limit: Limit::Planes, most: 16_384 }, "{generations}");
        assert!(!fault.trail.is_empty());
    }
    let scene = scene(&DOUBLING.replace("GENERATIONS", "3"));
    let within = |planes| normals_of(&scene, &Limits { planes, ..Limits::default() }).map(|it| it.len());
    assert_eq!(within(16), Ok(16));
    assert_eq!(within(17), Ok(16));
    assert!(within(15).is_err());
}

#[test]
fn generations_are_counted_by_whole_numbers() {
    for (generations, value) in [("-1", -1.0), (".5", 0.5), ("inf", f64::INFINITY)] {
        let fault = fault(&DOUBLING.replace("GENERATIONS", generations));
        assert_eq!(fault.kind, FaultKind::Whole { what: "derive", value, least: 0.0 });
    }
}

#[test]
fn a_module_that_only_replaces_itself_ends_at_a_limit() {
    let fault = fault("hull H { start N(1); derive parallel 1e9; N(len) -> N(len); } scene { show H() & sphere; }");
    assert!(matches!(fault.kind, FaultKind::Limit { limit: Limit::Rules, .. }), "{fault:?}");
}

#[test]
fn a_length_is_not_negative_and_an_angle_beyond_a_right_one_makes_it_so() {
    let of = |rule: &str| {
        fault(&format!("hull H {{ start N(1); prune none; N(len) -> {rule}; }} scene {{ show H() & sphere; }}"))
    };
    assert_eq!(of("rotx(100) N(len / cos(120))").kind, of("N(1 / cos(120))").kind);
    assert!(matches!(of("normal(-1)").kind, FaultKind::Normal { length: Some(-1.0) }));
    assert!(matches!(of("normal(inf)").kind, FaultKind::Normal { .. }));
    assert_eq!(of("M; M -> nothing").kind, FaultKind::Normal { length: None });
    assert_eq!(of("M((1, 2)); M(v) -> nothing").kind, FaultKind::Normal { length: None });
}

/// What both tracers say of a program.
fn refused(text: &str) -> Fault {
    let scene = scene(text);
    let limits = Limits::default();
    let fault = match CellTracer::new(&scene, &limits, Culling::State) {
        Err(fault) => fault,
        Ok(tracer) => look(&tracer),
    };
    assert_eq!(look(&Reference::new(&scene, &limits)).kind, fault.kind);
    fault
}

fn look(tracer: &dyn Tracer) -> Fault {
    let ray = treegen_runtime::geometry::Ray { origin: glam::DVec3::NEG_Y * 9.0, direction: glam::DVec3::Y };
    let mut seen = treegen_runtime::trace::Seen::default();
    let found = tracer.look(&[treegen_runtime::trace::Beam::thin(ray)], &mut seen);
    found.expect_err("this should have been refused").fault
}

#[test]
fn a_hull_without_an_end_is_refused_with_the_direction_and_the_place() {
    let text = "hull Open { start repeat 6 as i { [ rotz(60 * i) rotx(90) normal(1) ] } [ rotx(180) normal(1) ]; }
                csg Tree { start move(1, 0, 0) Open(); }";
    let fault = refused(text);
    let FaultKind::OpenHull { direction: Some([x, y, z]) } = fault.kind else { panic!("{fault:?}") };
    assert!(x.abs() < 1e-6 && y.abs() < 1e-6 && z > 1.0 - 1e-6, "{x} {y} {z}");
    assert_eq!(&text[fault.origin.start as usize..fault.origin.end as usize], "Open");
}

#[test]
fn a_hull_without_an_end_may_be_cut_by_another_solid() {
    for scene in ["Open() & sphere", "sphere \\ move(0, 0, .5) Open()", "uscale(2) (box & Open() & sphere)"] {
        let text = format!(
            "hull Open {{ start repeat 3 as i {{ [ rotz(120 * i) rotx(90) normal(.3) ] }}; }} scene {{ show {scene}; }}"
        );
        let book = crate::common::by_the_book(&text);
        let cells = crate::common::by_cells(&text);
        let met = |it: &[Option<crate::common::Seen>]| it.iter().map(Option::is_some).collect::<Vec<bool>>();
        assert_eq!(met(&cells), met(&book), "{scene}");
        assert!(book.iter().any(Option::is_some), "{scene}");
    }
    // But not if it stands somewhere else as it is, nor if it is what is cut.
    for scene in ["Open() & sphere | Open()", "Open() \\ sphere"] {
        let text = format!("hull Open {{ start normal(1); }} scene {{ show {scene}; }}");
        assert!(matches!(refused(&text).kind, FaultKind::OpenHull { .. }), "{scene}");
    }
}

#[test]
fn without_a_normal_there_is_no_hull() {
    for start in ["nothing", "move(0, 0, -1) normal(1)"] {
        let fault = refused(&format!("hull H {{ start {start}; }}"));
        assert_eq!(fault.kind, FaultKind::OpenHull { direction: None }, "{start}");
    }
}

#[test]
fn an_empty_hull_is_not_seen() {
    let text =
        "hull H { start repeat 6 as i { [ rotz(60 * i) rotx(90) normal(1) ] } [ move(0, 0, 2) rotx(180) normal(0) ]
                       [ normal(1) ] ; prune none; }";
    assert!(crate::common::by_cells(text).iter().all(Option::is_none));
    assert!(crate::common::by_the_book(text).iter().all(Option::is_none));
}

#[test]
fn words_of_one_kind_of_walk_do_not_stand_in_the_other() {
    let codes = |text: &str| compiled(text).problems.iter().map(|it| it.code).collect::<Vec<&str>>();
    assert_eq!(codes("hull H { start segment(1, 1, 1) normal(1); }"), ["E0509"]);
    assert_eq!(codes("shape S { start segment(1, 1, 1) normal(1); }"), ["E0509"]);
    assert_eq!(codes("csg S { start normal(1); }"), ["E0508"]);
    assert_eq!(codes("hull H { start N(1); N(l) +> N(l); }"), ["E0509"]);
    assert_eq!(codes("shape S { start segment(1, 1, 1); derive parallel 2; prune none; }"), ["E0509", "E0509"]);
    assert_eq!(codes("hull H { start normal(1); derive youngest 2; }"), ["E0517"]);
}

//! Hulls as both tracers see them: in unions, Booleans, copies and variants.

use crate::common::{by_cells, by_the_book};

const CROWN: &str = "hull Crown(n = 3) {
    var angle = 30;
    start [ N(1.2) ] [ rotx(180) normal(.6) ] repeat 5 as i { [ rotz(72 * i) rotx(85) N(1) ] };
    derive parallel n;
    N(len) -> { let back = len * gauss(.45, .05); let a = gauss(angle, 6); let b = gauss(angle, 6); angle = angle * .6 }
        move(0, 0, len - back) rotz(random(0, 360))
        [ rotx( a) N(back / cos(a)) ]
        [ rotx(-b) N(back / cos(b)) ];
}
hull Trunk { start paint(Wood) repeat 6 as i { [ rotz(60 * i) rotx(88) normal(.3) ] } [ normal(1) ] [ rotx(180) normal(1) ]; }
material Leaf { color: (.2, .4, .1) }
material Wood { color: (.3, .2, .1) }
";

fn assert_same(what: &str) {
    let text = format!("{CROWN} {what}");
    let (cells, book) = (by_cells(&text), by_the_book(&text));
    assert!(book.iter().any(Option::is_some), "{what}");
    for (number, (fast, slow)) in cells.iter().zip(&book).enumerate() {
        match (fast, slow) {
            (Some(fast), Some(slow)) => {
                assert!((fast.depth - slow.depth).abs() <= 1e-9 * slow.depth, "{what}: {number} {fast:?} {slow:?}");
                assert_eq!(fast.paint, slow.paint, "{what}: {number}");
                let cosine: f64 = fast.normal.iter().zip(slow.normal).map(|(a, b)| a * b).sum();
                assert!(cosine > 1.0 - 1e-12, "{what}: {number} {fast:?} {slow:?}");
            }
            (None, None) => {}
            _ => panic!("{what}: {number} {fast:?} {slow:?}"),
        }
    }
}

#[test]
fn both_tracers_see_the_same_of_hulls() {
    assert_same("scene { show Crown(); }");
    assert_same("scene { show Crown(0); }");
    assert_same("scene { show paint(Leaf) Crown(6) | move(0, 0, -1) Trunk(); }");
}

#[test]
fn hulls_stand_wherever_solids_do() {
    assert_same("scene { show Crown() & move(.3, 0, .4) sphere; }");
    assert_same("scene { show Crown() \\ move(.3, -.5, .4) uscale(.7) (sphere | Crown(2)); }");
    assert_same("scene { show rotx(30) scale(1, .4, 1.5) mirror(1, 0, 0) Crown(); }");
    assert_same("scene { show repeat 4 as i { move(i * .7 - 1, i * .3, 0) variant(2) Crown() }; }");
    assert_same(
        "csg Grove { start tree(3); tree(n) if n > 0 -> paint(Leaf) Crown() | move(.5, .6, .1) uscale(.8) tree(n - 1); tree(n) -> Trunk(); }",
    );
    assert_same("shape Plant { start segment(.8, .1, .05) uscale(.4) paint(Leaf) Crown(); }");
}

#[test]
fn solids_can_be_placed_beside_the_planes_of_a_hull() {
    assert_same(
        "hull Fruit { start [ normal(.5) ] [ rotx(180) normal(.5) ] repeat 4 as i { [ rotz(90 * i) rotx(90) normal(.4) move(0, 0, .4) uscale(.2) sphere ] }; }",
    );
}

#[test]
fn more_plants_than_are_looked_into_for_bounds_are_all_seen() {
    // Four hundred turned cubes and stems, of which nothing is known together.
    let grove = |plant: &str| {
        format!(
            "hull Cube {{ start [ normal(.3) ] [ rotx(180) normal(.3) ] repeat 4 as i {{ [ rotz(90 * i) rotx(90) normal(.3) ] }}; }}
             shape Stem {{ start segment(.5, .1, .1); }}
             csg Grove {{ start repeat 400 as i {{ move(i % 20 - 8, floor(i / 20) - 4, 0) turned(i) }}; turned(a) -> rotz(a) {plant}; }}
             scene {{ show Grove(); }}"
        )
    };
    for plant in ["Cube()", "Stem()"] {
        let (cells, book) = (by_cells(&grove(plant)), by_the_book(&grove(plant)));
        let met = |it: &[Option<crate::common::Seen>]| it.iter().map(Option::is_some).collect::<Vec<bool>>();
        assert!(book.iter().flatten().count() > 100, "{plant}");
        assert_eq!(met(&cells), met(&book), "{plant}");
    }
}

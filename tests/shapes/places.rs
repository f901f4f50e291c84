//! Solids placed by walks, and shapes placed by others.

use crate::common::{Seen, by_cells, by_the_book};
use crate::support::{derived, rounded};

/// Both tracers see the same of all of these, and see something.
fn assert_same(programs: &[&str]) {
    let first = by_the_book(programs[0]);
    let hits = first.iter().flatten().count();
    assert!(hits > 20, "{hits} hits are too few to tell anything:\n{}", programs[0]);
    for program in programs {
        for see in [by_the_book, by_cells] {
            assert!(are_alike(&first, &see(program)), "these differ:\n{}\n{program}", programs[0]);
        }
    }
}

/// The same but for rounding: frames are multiplied in another order in an expression.
fn are_alike(a: &[Option<Seen>], b: &[Option<Seen>]) -> bool {
    let alike = |(a, b): (&Option<Seen>, &Option<Seen>)| match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let normals = a.normal.iter().zip(b.normal).all(|(a, b)| (a - b).abs() < 1e-6);
            a.paint == b.paint && (a.depth - b.depth).abs() < 1e-9 && normals
        }
        _ => false,
    };
    // A ray that touches an edge may fall on either side of it.
    a.iter().zip(b).filter(|it| !alike(*it)).count() <= 1
}

#[test]
fn a_walk_places_what_an_expression_says() {
    let found = derived(
        "shape S { start move(1, 2, 3) sphere rotx(90) move(0, 0, 1) (box | cylinder) [ uscale(.1) torus(.3) ]; }",
    );
    let places: Vec<[f64; 3]> = found.solids.iter().map(|it| rounded(*it)).collect();
    assert_eq!(places, [[1.0, 2.0, 3.0], [1.0, 1.0, 3.0], [1.0, 1.0, 3.0]]);
    assert_same(&[
        "shape S { start move(0, 0, .5) [ rotx(30) scale(.2, .4, 1) (sphere & halfspace(0, 0, 1, .3)) ] rotz(40) uscale(.3) box; }",
        "csg S { start move(0, 0, .5) (rotx(30) scale(.2, .4, 1) (sphere & halfspace(0, 0, 1, .3)) | rotz(40) uscale(.3) box); }",
    ]);
}

#[test]
fn what_is_placed_sees_state_parameters_and_counters() {
    assert_same(&[
        "shape S { var r = .3; start repeat 3 as i { move(.7, 0, 0) [ move(-1.4, 0, 0) { r = r + .1 * i } a(i) ] };
           a(n) -> ( { r = r * .9 } uscale(r) (if n == 1 { box } else { sphere }) ); }",
        "csg S { start move(-.7, 0, 0) uscale(.27) sphere | uscale(.36) box | move(.7, 0, 0) uscale(.45) sphere; }",
    ]);
}

#[test]
fn paint_of_a_walk_is_for_what_has_none() {
    assert_same(&[
        "shape S { start paint(A) move(-.6, 0, .5) [ uscale(.5) (sphere | paint(B) move(2.4, 0, 0) box) ]; }
         material A { color: (1, 0, 0) } material B { color: (0, 0, 1) } scene { show S(); }",
        "csg S { start move(-.6, 0, .5) uscale(.5) (paint(A) sphere | paint(B) move(2.4, 0, 0) box); }
         material A { color: (1, 0, 0) } material B { color: (0, 0, 1) } scene { show S(); }",
    ]);
}

#[test]
fn systems_stand_in_walks_and_walks_in_systems() {
    assert_same(&[
        "shape Tree { start segment(.8, .2, .2) [ rotx(25) uscale(.7) Leaf(.5) ] [ rotx(-40) uscale(.6) Twig(2) ]; }
         shape Twig(n) { start segment(n / 2, .1, .1) uscale(.4) sphere; }
         csg Leaf(r) { start move(0, 0, .8) scale(r, .2, .8) sphere; }
         csg Two { start move(-.6, 0, 0) Tree() | move(.6, 0, 0) uscale(.9) Tree(); }
         scene { show Two(); }",
        "csg Tree { start scale(.2, .2, .8) cylinder
             | move(0, 0, .8) (rotx(25) uscale(.7) move(0, 0, .8) scale(.5, .2, .8) sphere
                             | rotx(-40) uscale(.6) (scale(.1, .1, 1) cylinder | move(0, 0, 1) uscale(.4) sphere)); }
         csg Two { start move(-.6, 0, 0) Tree() | move(.6, 0, 0) uscale(.9) Tree(); }
         scene { show Two(); }",
    ]);
}

#[test]
fn a_shape_may_stand_in_itself_as_long_as_that_ends() {
    assert_same(&[
        "shape Tree(n = 3) { start segment(.8, .2, .15) if n > 0 { [ rotx(30) uscale(.6) Tree(n - 1) ] [ rotx(-30) uscale(.6) Tree(n - 1) ] }; }",
        "csg Tree(n = 3) { start move(0, 0, 0) scale(1, 1, .8) cone(.2, .15)
            | if n > 0 { move(0, 0, .8) (rotx(30) uscale(.6) Tree(n - 1) | rotx(-30) uscale(.6) Tree(n - 1)) }; }",
    ]);
    // Without an end it shrinks to nothing, as a cycle of a graph does; by the book that would take for ever.
    let shape = "shape Tree { start segment(.8, .2, .15) [ rotx(30) uscale(.5) Tree() ]; } scene { show Tree(); }";
    let cycle = "csg Tree { start scale(1, 1, .8) cone(.2, .15) | move(0, 0, .8) rotx(30) uscale(.5) Tree(); } scene { show Tree(); }";
    assert!(are_alike(&by_cells(shape), &by_cells(cycle)));
}

#[test]
fn a_stem_is_a_solid() {
    assert_same(&[
        "shape S { start segment(1, .6, .4); } csg Cut { start (S() \\ move(0, -.6, .5) uscale(.5) sphere) & halfspace(0, 0, 1, .9); } scene { show Cut(); }",
        "csg Cut { start (cone(.6, .4) \\ move(0, -.6, .5) uscale(.5) sphere) & halfspace(0, 0, 1, .9); } scene { show Cut(); }",
    ]);
    // A bent one leaves no slivers in what it is taken out of: the hole is as by the book.
    let hole = "shape S { start repeat 6 { segment(.3, .25, .25) rotx(25) }; } csg Cut { start move(0, 0, .5) box \\ S(); } scene { show Cut(); }";
    assert!(are_alike(&by_the_book(hole), &by_cells(hole)));
}

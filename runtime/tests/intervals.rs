//! Interval algebra: against sets of cells, where every Boolean operation is one on bits.

use treegen_runtime::geometry::{Chord, Crossing, End, Interval, Intervals};

/// How many cells the line has: cell 0 reaches from minus infinity to 0, the last one from 62 to infinity.
const CELLS: u32 = 64;

/// Where cell `index` begins, for 0 to `CELLS`.
fn edge(index: u32) -> f64 {
    match index {
        0 => f64::NEG_INFINITY,
        CELLS => f64::INFINITY,
        _ => f64::from(index - 1),
    }
}

/// Which operand a surface is of, and which of its events it is: they are numbered by the edge.
type Surface = (u8, u32);

/// The runs of ones in `bits` as intervals of operand `name`.
fn intervals(bits: u64, name: u8) -> Intervals<Surface> {
    moved(bits, name, |_| 0.0)
}

/// The same with each event moved by a little.
fn moved(bits: u64, name: u8, by: impl Fn(u32) -> f64) -> Intervals<Surface> {
    let inside = |index: u32| index < CELLS && bits >> index & 1 == 1;
    let end = |index: u32| End { t: edge(index) + by(index), surface: (name, index), flipped: false };
    let starts = (0..CELLS).filter(|index| inside(*index) && (*index == 0 || !inside(*index - 1)));
    Intervals::of_sorted(starts.map(|start| {
        let length = (start..=CELLS).take_while(|index| inside(*index)).count() as u32;
        Interval { near: end(start), far: end(start + length) }
    }))
}

/// The edges at which the list begins and ends.
fn edges(list: &Intervals<Surface>) -> Vec<(f64, f64)> {
    list.as_slice().iter().map(|it| (it.near.t, it.far.t)).collect()
}

/// Pseudo-random numbers with a fixed seed (splitmix64).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Sets of every kind: long runs, single cells, nearly nothing, nearly all.
    fn set(&mut self) -> u64 {
        let (a, b, kind) = (self.next(), self.next(), self.next() % 6);
        match kind {
            0 => a,
            1 => a & b & self.next(),
            2 => a | b | self.next(),
            3 => [0, !0, 1, 1 << 63][(a % 4) as usize],
            4 => (a | a << 1 | a << 2) & (b | b >> 1 | b >> 2),
            _ => (!0 << (a % 64)) ^ (!0 << (b % 64)),
        }
    }
}

#[test]
fn operations_are_those_of_the_sets_of_cells() {
    let mut numbers = Numbers(1);
    for _ in 0..20_000 {
        let (a, b) = (numbers.set(), numbers.set());
        let (first, second) = (intervals(a, 1), intervals(b, 2));
        for tolerance in [0.0, 1e-9] {
            assert_eq!(edges(&first.union(&second, tolerance)), edges(&intervals(a | b, 0)), "{a:x} | {b:x}");
            assert_eq!(edges(&first.intersection(&second, tolerance)), edges(&intervals(a & b, 0)), "{a:x} & {b:x}");
            assert_eq!(edges(&first.difference(&second, tolerance)), edges(&intervals(a & !b, 0)), "{a:x} \\ {b:x}");
        }
    }
}

#[test]
fn each_end_keeps_the_surface_that_makes_it_and_the_first_operand_wins() {
    let mut numbers = Numbers(2);
    let has_event = |bits: u64, index: u32| {
        let before = index > 0 && bits >> (index - 1) & 1 == 1;
        let after = index < CELLS && bits >> index & 1 == 1;
        before != after
    };
    for _ in 0..10_000 {
        let (a, b) = (numbers.set(), numbers.set());
        let (first, second) = (intervals(a, 1), intervals(b, 2));
        let results = [
            (first.union(&second, 0.0), false),
            (first.intersection(&second, 0.0), false),
            (first.difference(&second, 0.0), true),
        ];
        for (result, cuts) in results {
            for end in result.as_slice().iter().flat_map(|it| [it.near, it.far]) {
                let (name, index) = end.surface;
                assert_eq!(end.t, edge(index));
                assert_eq!(name, if has_event(a, index) { 1 } else { 2 }, "{a:x} {b:x}");
                assert_eq!(end.flipped, cuts && name == 2);
            }
        }
    }
}

#[test]
fn what_is_cut_out_of_what_is_cut_out_is_turned_twice() {
    let (a, b, c) = (intervals(0xff00, 1), intervals(0x0ff0, 2), intervals(0x0080, 3));
    // The near end of a \ (b \ c) is the end of b; nothing of c is seen there.
    let result = a.difference(&b.difference(&c, 0.0), 0.0);
    assert_eq!(result.as_slice()[0].near, End { t: edge(12), surface: (2, 12), flipped: true });
    // Inside b, c is turned once by its own difference and once by this one.
    let result = intervals(!0, 1).difference(&b.difference(&c, 0.0), 0.0);
    let seen = result.as_slice()[1];
    assert_eq!(seen.near, End { t: edge(7), surface: (3, 7), flipped: false });
    assert_eq!(seen.far, End { t: edge(8), surface: (3, 8), flipped: false });
}

#[test]
fn the_union_of_many_is_the_union_one_by_one_to_the_surface() {
    let mut numbers = Numbers(3);
    for count in 0..8 {
        for _ in 0..1_000 {
            let lists: Vec<_> = (0..count).map(|name| intervals(numbers.set() & numbers.set(), name)).collect();
            for tolerance in [0.0, 1e-9] {
                let one_by_one = lists.iter().fold(Intervals::empty(), |all, it| all.union(it, tolerance));
                assert_eq!(Intervals::union_of(&lists, tolerance), one_by_one);
            }
        }
    }
}

#[test]
fn events_that_rounding_moved_apart_are_one() {
    let mut numbers = Numbers(4);
    for _ in 0..10_000 {
        let (a, b, noise) = (numbers.set(), numbers.set(), numbers.next());
        let first = intervals(a, 1);
        // Each event of the second list is a little early, a little late or in place.
        let second = moved(b, 2, |index| (((noise >> (index % 62)) & 3) as f64 - 1.5) * 1e-13);
        let tolerance = 1e-12;
        let results = [
            (first.union(&second, tolerance), a | b),
            (first.intersection(&second, tolerance), a & b),
            (first.difference(&second, tolerance), a & !b),
            (Intervals::union_of(&[first.clone(), second.clone()], tolerance), a | b),
        ];
        for (result, bits) in results {
            let expected = edges(&intervals(bits, 0));
            assert_eq!(result.len(), expected.len(), "{a:x} {b:x} {noise:x}");
            for (piece, (near, far)) in result.as_slice().iter().zip(expected) {
                assert!(piece.near.t == near || (piece.near.t - near).abs() <= 2e-13);
                assert!(piece.far.t == far || (piece.far.t - far).abs() <= 2e-13);
                // A place that is the first one's is so to the bit.
                assert!(piece.near.surface.0 == 2 || piece.near.t == near);
                assert!(piece.far.surface.0 == 2 || piece.far.t == far);
            }
        }
    }
}

#[test]
fn any_tolerance_leaves_a_sorted_list_of_pieces_with_length() {
    let mut numbers = Numbers(5);
    for _ in 0..10_000 {
        let (a, b) = (numbers.set(), numbers.set());
        let noise = numbers.next();
        let shifted = |index: u32| ((noise >> (index % 60)) & 15) as f64 / 20.0;
        let (first, second) = (intervals(a, 1), moved(b, 2, shifted));
        // The tolerance is as long as the cells: nearly everything coincides with something.
        for tolerance in [0.3, 1.0, 2.5] {
            for result in [
                first.union(&second, tolerance),
                first.intersection(&second, tolerance),
                first.difference(&second, tolerance),
                second.difference(&first, tolerance),
                Intervals::union_of(&[second.clone(), first.clone()], tolerance),
            ] {
                assert!(result.as_slice().iter().all(|it| it.near.t < it.far.t));
                assert!(result.as_slice().windows(2).all(|it| it[0].far.t < it[1].near.t));
            }
        }
    }
}

#[test]
fn a_shell_keeps_its_thickness_down_to_the_tolerance() {
    let solid = |near: f64, far: f64| {
        let chord = Chord { near: Crossing { t: near, face: 0 }, far: Crossing { t: far, face: 1 } };
        Intervals::of_chords(&[chord], |it| it.face)
    };
    for thickness in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9] {
        let shell = solid(-1.0, 1.0).difference(&solid(-1.0, 1.0 - thickness), 1e-12);
        assert_eq!(shell.len(), 1);
        let piece = shell.as_slice()[0];
        assert_eq!((piece.near.t, piece.far.t), (1.0 - thickness, 1.0));
        assert!(piece.near.flipped && !piece.far.flipped);
    }
    // Thinner than the tolerance there is no shell at all, not a speckle here and there.
    assert!(solid(-1.0, 1.0).difference(&solid(-1.0, 1.0 - 1e-13), 1e-12).is_empty());
    assert!(solid(-1.0, 1.0).difference(&solid(-1.0, 1.0 + 1e-13), 1e-12).is_empty());
    // Stacked solids have nothing in common, and nothing between them.
    assert!(solid(-1.0, 0.0).intersection(&solid(-1e-13, 1.0), 1e-12).is_empty());
    assert_eq!(solid(-1.0, 0.0).union(&solid(1e-13, 1.0), 1e-12).len(), 1);
}

#[test]
fn pieces_without_length_are_no_pieces_and_those_that_touch_are_one() {
    let piece = |near: f64, far: f64| Interval {
        near: End { t: near, surface: near as i32, flipped: false },
        far: End { t: far, surface: far as i32, flipped: false },
    };
    let list =
        Intervals::of_sorted([piece(0.0, 0.0), piece(1.0, 2.0), piece(2.0, 4.0), piece(3.0, 3.5), piece(5.0, 6.0)]);
    assert_eq!(list.as_slice(), [piece(1.0, 4.0), piece(5.0, 6.0)]);
    assert!(!list.is_empty() && Intervals::<i32>::empty().is_empty());
}

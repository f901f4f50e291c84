//! Splitting as FG86, section 2.1, has it.

use glam::DVec3;
use treegen_runtime::derive::Normal;

use crate::support::normals;

/// The paper's splitting with its parameters, and as many splits as are wanted.
fn paper(generations: u32, deviations: [f64; 3], start: &str) -> String {
    let [back, angle, length] = deviations;
    format!(
        "hull H {{
            var angle = 30, jitter = {angle};
            start {start};
            derive parallel {generations};
            prune none;
            N(len) -> {{ let back = len * .4 + gauss(0, {back}) * len; let a = gauss(angle, jitter); let b = gauss(angle, jitter);
                         angle = angle * .5; jitter = jitter * .5 }}
                move(0, 0, len - back) rotz(random(0, 360))
                [ rotx(a) N(back / cos(a) + gauss(0, {length}) * len) ]
                [ rotx(-b) N(back / cos(b) + gauss(0, {length}) * len) ];
        }}"
    )
}

fn degrees(a: DVec3, b: DVec3) -> f64 {
    libm::acos(a.dot(b).clamp(-1.0, 1.0)).to_degrees()
}

#[test]
fn without_deviations_the_new_normals_end_in_the_old_plane_where_the_angle_says() {
    for start in ["N(2)", "rotx(50) N(2)", "move(1, -2, .5) rotate(1, 2, 3, 77) N(2)"] {
        let old = &normals(&paper(0, [0.0; 3], start))[0];
        let new = normals(&paper(1, [0.0; 3], start));
        assert_eq!(new.len(), 2);
        let fork = old.start + old.direction * (2.0 * 0.6);
        let end = old.start + old.direction * old.length;
        let old_plane = old.plane().unwrap();
        for normal in &new {
            assert!((normal.start - fork).length() < 1e-12);
            assert!((degrees(normal.direction, old.direction) - 30.0).abs() < 1e-9);
            // The end lies in the old plane, |BC| tan(angle) from the old end.
            let tip = normal.start + normal.direction * normal.length;
            assert!((old_plane.normal.dot(tip) - old_plane.offset).abs() < 1e-12);
            assert!(((tip - end).length() - 0.8 * libm::tan(30_f64.to_radians())).abs() < 1e-12);
            // And so does the new plane, which is square to the normal.
            let plane = normal.plane().unwrap();
            assert!((plane.normal.dot(tip) - plane.offset).abs() < 1e-12);
        }
        // To either side.
        assert!((degrees(new[0].direction, new[1].direction) - 60.0).abs() < 1e-9);
    }
}

#[test]
fn n_generations_make_2_to_the_n_times_as_many_normals() {
    for generations in 0..8 {
        let start = "repeat 5 as i { [ rotz(72 * i) rotx(80) N(1) ] }";
        let found = normals(&paper(generations, [0.05, 3.0, 0.02], start));
        assert_eq!(found.len(), 5 << generations);
        assert!(found.iter().all(|it| (it.direction.length() - 1.0).abs() < 1e-12 && it.length >= 0.0));
    }
}

/// What the split of one normal drew: how far back it forked, the two angles, and what was added to the two lengths.
fn drawn(pair: &[Normal], length: f64) -> [f64; 5] {
    let along = pair[0].start.z;
    let back = length - along;
    let angles = [0, 1].map(|it| degrees(pair[it].direction, DVec3::Z));
    let added = [0, 1].map(|it: usize| pair[it].length - back / libm::cos(angles[it].to_radians()));
    [back, angles[0], angles[1], added[0], added[1]]
}

fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, (values.iter().map(|it| (it - mean) * (it - mean)).sum::<f64>() / count).sqrt())
}

#[test]
fn a_hundred_thousand_draws_have_the_means_and_deviations_that_were_asked_for() {
    // 8,000 normals a hull, each of length 1 along z.
    let mut splits = Vec::new();
    for seed in 0..13 {
        let text = paper(1, [0.05, 4.0, 0.02], "repeat 8000 as i { [ N(1) ] }");
        let text = format!("{text} scene {{ show H(seed: {seed}) & sphere; }}");
        let found = normals(&text);
        assert_eq!(found.len(), 16_000);
        splits.extend(found.chunks(2).map(|it| drawn(it, 1.0)));
    }
    assert!(splits.len() > 100_000);
    // A normal distribution cut at 3 sigma has .9866 of its deviation.
    const CUT: f64 = 0.986_58;
    let cases = [(0, 0.4, 0.05), (1, 30.0, 4.0), (2, 30.0, 4.0), (3, 0.0, 0.02), (4, 0.0, 0.02)];
    for (which, mean, sigma) in cases {
        let values: Vec<f64> = splits.iter().map(|it| it[which]).collect();
        let (found_mean, found_deviation) = mean_and_deviation(&values);
        // Five standard errors.
        let room = 5.0 / (values.len() as f64).sqrt();
        assert!((found_mean - mean).abs() < room * sigma, "{which}: {found_mean}");
        assert!((found_deviation / sigma - CUT).abs() < room, "{which}: {}", found_deviation / sigma);
        assert!(values.iter().all(|it| (it - mean).abs() <= 3.0 * sigma + 1e-9));
    }
    // The five are drawn apart.
    for a in 0..5 {
        for b in 0..a {
            let product: f64 = splits.iter().map(|it| (it[a] - cases[a].1) * (it[b] - cases[b].1)).sum();
            let correlation = product / splits.len() as f64 / (cases[a].2 * cases[b].2);
            assert!(correlation.abs() < 5.0 / (splits.len() as f64).sqrt(), "{a} {b} {correlation}");
        }
    }
}

#[test]
fn angles_shrink_from_generation_to_generation() {
    let found = normals(&paper(2, [0.0; 3], "N(2)"));
    assert_eq!(found.len(), 4);
    // 15 degrees to either side of what led 30 to either side.
    let pairs = degrees(found[0].direction, found[1].direction);
    assert!((pairs - 30.0).abs() < 1e-9, "{pairs}");
}

#[test]
fn pruning_keeps_exactly_what_points_outwards() {
    let start = "repeat 6 as i { [ rotz(60 * i + 7) rotx(80 + 25 * (i % 2)) N(1) ] } [ rotx(180) normal(1) ]
                 [ move(1, 1, 1) rotx(180) normal(3) ] [ move(1, 1, -1) rotx(180) normal(3) ]";
    // All at once: of what one generation brings those that point outwards are left.
    let all = paper(1, [0.1, 12.0, 0.02], start);
    let pruned = all.replace("prune none;", "prune outward;");
    let by_default = all.replace("prune none;", "");
    let all = normals(&all);
    let kept: Vec<&Normal> = all
        .iter()
        .filter(|it| {
            let (n, p) = (it.direction, it.start);
            n.x * p.x >= 0.0 && n.y * p.y >= 0.0 && n.z * p.z >= 0.0
        })
        .collect();
    assert!(kept.len() > 4 && kept.len() < all.len(), "{} of {}", kept.len(), all.len());
    let pruned = normals(&pruned);
    assert_eq!(pruned.iter().collect::<Vec<&Normal>>(), kept);
    assert!(pruned.iter().all(Normal::is_outward));
    assert_eq!(normals(&by_default), pruned);
}

#[test]
fn an_outward_hull_always_holds_its_centre() {
    for seed in 0..200 {
        let start = "[ N(3) ] [ rotx(180) normal(1) ] repeat 5 as i { [ rotz(72 * i) rotx(80) N(2) ] }";
        let text = paper(4, [0.1, 15.0, 0.02], start).replace("prune none;", "");
        for normal in normals(&format!("{text} scene {{ show H(seed: {seed}) & sphere; }}")) {
            assert!(normal.plane().unwrap().offset >= 0.0, "{seed} {normal:?}");
        }
    }
}

#[test]
fn even_scaling_and_mirrors_reach_normals_and_uneven_scaling_only_moves_them() {
    let found = normals(
        "hull H { start [ uscale(2) move(0, 0, 1) normal(3) ] [ mirror(0, 0, 1) normal(1) ]
                        [ scale(1, 4, 1) move(0, 1, 0) rotx(-90) normal(1) ]; prune none; }
         scene { show H() & sphere; }",
    );
    let ends: Vec<(DVec3, f64)> = found.iter().map(|it| (it.direction, it.plane().unwrap().offset)).collect();
    assert_eq!(ends, [(DVec3::Z, 8.0), (DVec3::NEG_Z, 1.0), (DVec3::Y, 5.0)]);
}

#[test]
fn toward_turns_normals_too() {
    let found = normals("hull H { start toward((0, 0, -1), 180) normal(2); } scene { show H() & sphere; }");
    assert!((found[0].direction - DVec3::NEG_Z).length() < 1e-15, "{found:?}");
}

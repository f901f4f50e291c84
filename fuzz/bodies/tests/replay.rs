//! All inputs that are stored, and some made up on the spot.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]
#![allow(clippy::print_stdout, reason = "a test that fails says with which input")]

use std::fs;
use std::path::Path;

use treegen_fuzz::{check, draw, generate, intervals, ray, text};

/// Runs a body on each stored input for a target.
fn replay(target: &str, body: impl Fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../inputs").join(target);
    let mut paths: Vec<_> = fs::read_dir(&folder).unwrap().map(|it| it.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "nothing in {}", folder.display());
    for path in paths {
        println!("{}", path.display());
        body(&fs::read(&path).unwrap());
    }
}

fn as_text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn stored_texts_are_read_and_laid_out() {
    replay("text", |it| text::text(&as_text(it)));
    replay("check", |it| text::text(&as_text(it)));
    replay("draw", |it| text::text(&as_text(it)));
}

#[test]
fn stored_texts_are_compiled_and_mended() {
    replay("text", |it| check::check(&as_text(it)));
    replay("check", |it| check::check(&as_text(it)));
}

#[test]
fn stored_programs_are_drawn_in_every_way() {
    replay("draw", |it| {
        draw::draw(&as_text(it));
    });
}

#[test]
fn stored_rays_meet_their_primitives() {
    replay("ray", ray::ray);
}

#[test]
fn stored_expressions_over_intervals_are_right() {
    replay("intervals", intervals::intervals);
}

/// So many bytes from a seed (splitmix64).
fn bytes(seed: u64, count: usize) -> Vec<u8> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    (0..count).map(|_| next() as u8).collect()
}

/// How many inputs are made up: `TREEGEN_FUZZ=1000000 cargo test --release -p treegen-fuzz` goes on for longer.
fn count(usual: u64) -> u64 {
    std::env::var("TREEGEN_FUZZ").ok().and_then(|it| it.parse().ok()).unwrap_or(usual)
}

#[test]
fn rays_and_intervals_of_any_bytes_are_right() {
    for seed in 0..count(20_000) {
        ray::ray(&bytes(seed, 160));
        intervals::intervals(&bytes(seed, 96));
    }
}

#[test]
fn programs_of_any_bytes_are_drawn_and_most_are_without_mistakes() {
    let mut whole = 0;
    let all = count(150);
    for seed in 0..all {
        let program = generate::program(&bytes(seed, 64 + seed as usize % 400));
        text::text(&program);
        whole += u64::from(draw::draw(&program));
    }
    println!("{whole} of {all} make a scene");
    assert!(whole * 2 > all, "only {whole} of {all} make a scene");
}

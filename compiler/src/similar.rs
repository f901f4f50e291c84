//! The name that was probably meant.

/// Names longer than this are not compared: nobody misspells them by a letter.
const MAX_LENGTH: usize = 40;

/// How many names are compared at most, so that ten thousand unknown names cost no more than they should.
const MAX_COMPARED: usize = 1000;

/// How many names are looked at for their length at most.
const MAX_SEEN: usize = 20_000;

/// The one of `candidates` that is nearest to `name`, if any is near enough to be a slip of the finger.
///
/// Nearness is the number of letters to insert, remove, exchange or swap with a neighbour (restricted Damerau-Levenshtein
/// distance); a third of the length may differ. Of equally near names the first in alphabetical order is taken.
pub(crate) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > MAX_LENGTH {
        return None;
    }
    let most = (name.len().max(3) / 3).max(1);
    let lengths = |it: &&str| it.len().abs_diff(name.len()) <= most && *it != name;
    let near = candidates.into_iter().take(MAX_SEEN).filter(lengths).take(MAX_COMPARED);
    near.map(|it| (distance(name, it), it)).filter(|it| it.0 <= most && it.0 < name.len()).min().map(|it| it.1)
}

/// How many slips lie between two words; capitals are half forgiven by counting them as letters of their own.
fn distance(a: &str, b: &str) -> usize {
    if a.eq_ignore_ascii_case(b) {
        return 1;
    }
    let (a, b): (Vec<u8>, Vec<u8>) = (a.bytes().collect(), b.bytes().collect());
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, y) in b.iter().enumerate() {
            let mut best = (last[j] + usize::from(x != y)).min(last[j + 1] + 1).min(row[j] + 1);
            if i > 0 && j > 0 && a[i - 1] == *y && b[j - 1] == *x {
                best = best.min(before[j - 1] + 1);
            }
            row.push(best);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_finger_is_found() {
        assert_eq!(nearest("shpere", ["box", "sphere", "cone"]), Some("sphere"));
        assert_eq!(nearest("cylindr", ["cylinder"]), Some("cylinder"));
        assert_eq!(nearest("Sphere", ["sphere"]), Some("sphere"));
    }

    #[test]
    fn another_word_is_not() {
        assert_eq!(nearest("leaf", ["move", "trunk"]), None);
        assert_eq!(nearest("a", ["b"]), None);
    }
}

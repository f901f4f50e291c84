//! Marks that are alike: what belongs together in a row of a drawn tile.

use pulp::Simd;

use crate::lanes::{EIGHT, Kernel, SIXTEEN};
use crate::scan::Mark;

/// Which of the first sixteen marks are the same as one, in these bits. Those that are not there are not.
#[inline(always)]
pub(super) fn alike<K: Kernel>(kernel: K, marks: &[Mark], mark: Mark, bits: u64) -> u32 {
    let Some(sixteen) = marks.first_chunk::<SIXTEEN>() else {
        return marks
            .iter()
            .enumerate()
            .fold(0, |all, (lane, it)| all | u32::from((it.0 ^ mark.0) & bits == 0) << lane);
    };
    let (eights, _) = sixteen.as_chunks();
    alike_eight(kernel, &eights[0], mark, bits) | alike_eight(kernel, &eights[1], mark, bits) << EIGHT
}

/// Which of eight are.
#[inline(always)]
fn alike_eight<K: Kernel>(kernel: K, marks: &[Mark; EIGHT], mark: Mark, bits: u64) -> u32 {
    let lanes = kernel.lanes();
    let (masks, wanted) = (lanes.splat_u64s(bits), lanes.splat_u64s(mark.0 & bits));
    kernel.bits(lanes.equal_u64s(lanes.and_u64s(pulp::cast(Mark::numbers(marks)), masks), wanted))
}

/// How many marks at the beginning are the same as one.
#[inline(always)]
pub(super) fn end_of_run<K: Kernel>(kernel: K, marks: &[Mark], mark: Mark) -> usize {
    let mut end = 0;
    while let Some(eight) = marks[end..].first_chunk::<EIGHT>() {
        let same = alike_eight(kernel, eight, mark, u64::MAX).trailing_ones() as usize;
        end += same;
        if same < EIGHT {
            return end;
        }
    }
    marks[end..].iter().position(|it| *it != mark).map_or(marks.len(), |it| end + it)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Plain;

    #[test]
    fn marks_are_alike_in_the_bits_that_are_asked_for_up_to_their_end() {
        let marks: Vec<Mark> = (0..40).map(|it| Mark::new(u32::from(it >= 21), it / 3)).collect();
        for start in 0..40 {
            let (rest, mark) = (&marks[start..], marks[start]);
            let same = |bits: u64, it: &Mark| (it.0 ^ mark.0) & bits == 0;
            for bits in [u64::MAX, Mark::PIECE] {
                let expected = rest.iter().take(SIXTEEN).enumerate();
                let expected = expected.fold(0, |all, (lane, it)| all | u32::from(same(bits, it)) << lane);
                assert_eq!(alike(Plain, rest, mark, bits), expected, "{start}");
            }
            let run = rest.iter().take_while(|it| **it == mark).count();
            assert_eq!(end_of_run(Plain, rest, mark), run, "{start}");
        }
        assert_eq!(end_of_run(Plain, &[Mark::NOTHING; 37], Mark::NOTHING), 37);
    }
}

//! Choices remembered: guards that see few values of a module are mostly asked about the same ones again and again.

use crate::form::{Module, Op, Shape, Slot, Stride};

/// What was chosen of a module's rules, by the values that its guards see.
#[derive(Debug)]
pub(super) struct Memo {
    /// Where those values are among the module's, in the order of its parameters and of the state.
    columns: Vec<usize>,
    entries: [Option<Entry>; ENTRIES],
}

/// What a choice follows from: the bits of the values, and how many rules are passed over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Key {
    values: [u64; MOST_VALUES],
    passed: u32,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    key: Key,
    chosen: Option<u32>,
}

/// Guards that see more values are asked each time.
const MOST_VALUES: usize = 2;
/// How many choices are remembered of a module.
const ENTRIES: usize = 16;

impl Memo {
    /// That of a module whose values are in these slots; none if what its guards say may follow from anything but a few of them.
    pub(super) fn new(module: &Module, shape: &Shape, slots: &[Slot]) -> Option<Self> {
        let mut columns = Vec::new();
        for guard in module.rules.iter().filter_map(|it| it.guard.as_ref()) {
            for op in &guard.code().ops {
                let seen = match op {
                    // Functions may draw as well.
                    Op::Draw { .. } | Op::Call { .. } | Op::Store(..) => return None,
                    Op::Load(_, slot) | Op::Element(_, slot, _) => Some(*slot),
                    Op::Constant(..)
                    | Op::Param(..)
                    | Op::Copy(..)
                    | Op::Unary(..)
                    | Op::Binary(..)
                    | Op::Index(..)
                    | Op::Builtin(..)
                    | Op::Check { .. }
                    | Op::Vector(..)
                    | Op::List(..)
                    | Op::Part(..)
                    | Op::Enter(_)
                    | Op::Leave
                    | Op::Jump(_)
                    | Op::JumpIf(..)
                    | Op::JumpUnless(..) => None,
                };
                let Some(slot) = seen else { continue };
                match slots.iter().position(|it| *it == slot) {
                    Some(column) if !columns.contains(&column) => columns.push(column),
                    Some(_) => {}
                    None if is_assigned(shape, slot) => return None,
                    // It is the same all through the derivation.
                    None => {}
                }
            }
        }
        (columns.len() <= MOST_VALUES).then_some(Self { columns, entries: [None; ENTRIES] })
    }

    /// The key of a choice for a module with these values, of which so many rules are passed over.
    #[inline]
    pub(super) fn key(&self, values: &[f64], passed: usize) -> Key {
        let mut key = Key { values: [0; MOST_VALUES], passed: passed as u32 };
        for (to, column) in key.values.iter_mut().zip(&self.columns) {
            *to = values.get(*column).map_or(0, |it| it.to_bits());
        }
        key
    }

    /// What was chosen, if that is remembered.
    #[inline]
    pub(super) fn get(&self, key: &Key) -> Option<Option<u32>> {
        self.entries[key.place()].filter(|it| it.key == *key).map(|it| it.chosen)
    }

    /// Remembers a choice.
    pub(super) fn put(&mut self, key: Key, chosen: Option<u32>) {
        self.entries[key.place()] = Some(Entry { key, chosen });
    }
}

impl Key {
    /// Where it is remembered.
    #[inline]
    fn place(&self) -> usize {
        let [a, b] = self.values;
        let mixed = (a ^ b.rotate_left(21) ^ u64::from(self.passed)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 60) as usize % ENTRIES
    }
}

/// Whether a derivation may change what is in a slot.
fn is_assigned(shape: &Shape, slot: Slot) -> bool {
    let bound = shape.state.iter().chain(shape.modules.iter().flat_map(|it| &it.params));
    let mut found = bound.into_iter().any(|it| *it == slot);
    for walk in shape.walks() {
        walk.visit(&mut |stride| {
            found |= match stride {
                Stride::Calc(formula) => formula.code().stores().any(|it| it == slot),
                Stride::Repeat { index, .. } => *index == slot,
                _ => false,
            };
        });
    }
    found
}

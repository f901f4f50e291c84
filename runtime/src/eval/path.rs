//! Paths and places: what a random draw depends on besides the seed.

/// The chain of the places of calls from the scene to here, with the indices of the `repeat`s around them, as a hash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Path(pub u64, pub u64);

/// Makes places: hashes of names and counts. The compiler gives every draw and call one.
///
/// ```
/// use treegen_runtime::eval::Place;
/// let rule = Place::system("Plant").rule("apex", "grow");
/// assert_ne!(rule.draw(0), rule.draw(1));
/// assert_ne!(rule.draw(0), rule.call(0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place(u64);

impl Place {
    /// In a system.
    pub fn system(name: &str) -> Self {
        Self(0x7472_6565_6765_6e00).name("system").name(name)
    }

    /// At the top of a file.
    pub fn file() -> Self {
        Self(0x7472_6565_6765_6e00).name("file")
    }

    /// In a rule: its module, and its label, or its number among the module's rules as text.
    pub fn rule(self, module: &str, label: &str) -> Self {
        self.name("rule").name(module).name(label)
    }

    /// In a definition of this kind (`let`, `fn`, `calc`, `var`, `formal`, `start`, `select`, `show`, ...) and name.
    pub fn definition(self, kind: &str, name: &str) -> Self {
        self.name(kind).name(name)
    }

    /// The n-th draw in here, from the left.
    pub fn draw(self, number: u32) -> u64 {
        mix(self.name("draw").0, u64::from(number))
    }

    /// The n-th call of a module, system or function, or run of a `calc`, in here, from the left.
    pub fn call(self, number: u32) -> u64 {
        mix(self.name("call").0, u64::from(number))
    }

    fn name(self, name: &str) -> Self {
        // FNV-1a keeps what names are, `mix` spreads it.
        let bytes = name
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
        Self(mix(self.0, bytes))
    }
}

/// A hash of two numbers: every bit of both reaches every bit of the result.
pub(crate) fn mix(a: u64, b: u64) -> u64 {
    spread(spread(a).wrapping_add(b))
}

/// A bijection on 64 bits that spreads every bit over all (the finaliser of SplitMix64, Steele et al. 2014).
pub(crate) fn spread(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

impl Path {
    /// The path that begins at a seed, wherever it stands.
    pub fn from_seed(seed: f64) -> Self {
        Self::default().joined(0x5eed, (seed + 0.0).to_bits())
    }

    /// A path that no derivation takes, for states that stand for others.
    pub(crate) fn made_up(number: u32) -> Self {
        Self::default().joined(0x6d61_6465_2075_7000, u64::from(number))
    }

    /// The path that goes on through a call at `place`, in the turn of the `repeat`s around it.
    #[must_use]
    pub fn joined(self, place: u64, turn: u64) -> Self {
        Self(mix(mix(self.0, place), turn), mix(mix(self.1 ^ 0x5851_f42d_4c95_7f2d, turn), place))
    }
}
/// The number from 0 to 1, without 1, that random bits stand for.
pub(crate) fn fraction(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

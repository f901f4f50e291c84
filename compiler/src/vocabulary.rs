//! The names that a program gives to values, for messages about them.

/// The names of a program's enums and their values.
#[derive(Clone, Debug, Default)]
pub struct Vocabulary {
    /// For each enum its name and its values' names.
    pub(crate) enums: Vec<(String, Vec<String>)>,
}

impl Vocabulary {
    /// How a program writes a value of an enum.
    pub(crate) fn case(&self, kind: u32, case: u32) -> String {
        let Some((name, cases)) = self.enums.get(kind as usize) else { return "a value of an enum".to_owned() };
        cases.get(case as usize).map_or_else(|| name.clone(), |it| format!("{name}.{it}"))
    }
}

//! Names that differ from all others, made by counting on: "clay", "clay 2", "clay 3".

use std::collections::{HashMap, HashSet};

/// `base`, or `base 2`, `base 3`, …: the first that `is_taken` does not hold for. A number at the end of `base` counts on.
#[must_use]
pub fn free_name(base: &str, is_taken: impl Fn(&str) -> bool) -> String {
    if !is_taken(base) {
        return base.to_owned();
    }
    let base = match base.rsplit_once(' ') {
        Some((before, number)) if number.parse::<u32>().is_ok() && !before.is_empty() => before,
        _ => base,
    };
    (2..u32::MAX)
        .map(|number| format!("{base} {number}"))
        .find(|name| !is_taken(name))
        .unwrap_or_else(|| base.to_owned())
}

/// Gives out names that differ from each other, however many are alike.
#[derive(Clone, Debug, Default)]
pub struct UniqueNames {
    taken: HashSet<String>,
    /// The number to try next for a name that was asked for more than once.
    next: HashMap<String, u64>,
}

impl UniqueNames {
    /// Takes names that are not to be given out.
    pub fn take(&mut self, names: impl IntoIterator<Item = String>) {
        self.taken.extend(names);
    }

    /// `base`, or `base 2`, `base 3` and so on: one that was not given out yet.
    pub fn unique(&mut self, base: &str) -> String {
        if self.taken.insert(base.to_owned()) {
            return base.to_owned();
        }
        let next = self.next.entry(base.to_owned()).or_insert(2);
        loop {
            let name = format!("{base} {next}");
            *next += 1;
            if self.taken.insert(name.clone()) {
                return name;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_names_count_up() {
        let taken = ["clay", "clay 2"];
        assert_eq!(free_name("clay", |name| taken.contains(&name)), "clay 3");
        assert_eq!(free_name("chrome", |name| taken.contains(&name)), "chrome");
        assert_eq!(free_name("clay 2", |name| taken.contains(&name)), "clay 3");
    }

    #[test]
    fn unique_names_are_given_out_once() {
        let mut names = UniqueNames::default();
        names.take(["a 2".to_owned()]);
        let given = ["a", "a", "b", "a", "a 3"].map(|base| names.unique(base));
        assert_eq!(given, ["a", "a 3", "b", "a 4", "a 3 2"]);
    }
}

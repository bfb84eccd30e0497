//! Sentences that hold of several things of a file at once.

use super::shorten::shortened;

/// What is said of things that have names: each sentence once, with the first name and how many more there are.
#[derive(Clone, Debug)]
pub struct Remarks {
    /// What all the things are: `material`.
    kind: &'static str,
    said: Vec<Remark>,
}

#[derive(Clone, Debug)]
struct Remark {
    what: &'static str,
    first: String,
    more: u64,
}

impl Remarks {
    /// Nothing is said yet of things of this `kind`.
    #[must_use]
    pub fn of(kind: &'static str) -> Self {
        Self {
            kind,
            said: Vec::new(),
        }
    }

    /// Says `what` of the thing called `name`.
    pub fn add(&mut self, name: &str, what: &'static str) {
        match self.said.iter_mut().find(|remark| remark.what == what) {
            Some(remark) => remark.more += 1,
            None => self.said.push(Remark {
                what,
                first: shortened(name).into_owned(),
                more: 0,
            }),
        }
    }

    /// The sentences, such as `material "leaf" and 3 more: lets light through`.
    pub fn sentences(&self) -> impl Iterator<Item = String> {
        self.said.iter().map(|Remark { what, first, more }| {
            let kind = self.kind;
            match more {
                0 => format!("{kind} \"{first}\": {what}"),
                _ => format!("{kind} \"{first}\" and {more} more: {what}"),
            }
        })
    }
}

//! `raymini check` without a scene: the built-in extreme cases, one line each.

use std::process::ExitCode;

use anyhow::Result;
use serde::Serialize;

use crate::analysis::matrix::{self, Bar, Case, Effort, Finding};
use crate::cli::{say, say_json};

/// A case as it is written for programs.
#[derive(Debug, Serialize)]
struct CaseFacts {
    name: &'static str,
    tried: &'static str,
    /// `None` where there is no figure.
    measured: Option<f64>,
    bar: f64,
    /// Whether the figure must be the bar, or may be less.
    exactly: bool,
    passed: bool,
    seconds: f64,
    /// What the program said when it broke down.
    panic: Option<String>,
}

impl CaseFacts {
    fn new(case: &Case, finding: Finding) -> Self {
        Self {
            name: case.name,
            tried: case.tried,
            measured: finding.measured.is_finite().then_some(finding.measured),
            bar: case.bar.value(),
            exactly: matches!(case.bar, Bar::Exactly(_)),
            passed: finding.passed,
            seconds: finding.seconds,
            panic: finding.panic,
        }
    }

    fn line(&self) -> String {
        let verdict = if self.passed { "pass" } else { "FAIL" };
        let measured = self.measured.map_or("none".to_owned(), shown);
        let relation = if self.exactly { "=" } else { "≤" };
        let panic = self
            .panic
            .iter()
            .map(|words| format!("; panicked: {words}"));
        format!(
            "{verdict}  {measured:>9}  {relation} {:<7} {:6.1} s  {}: {}{}",
            shown(self.bar),
            self.seconds,
            self.name,
            self.tried,
            panic.collect::<String>()
        )
    }
}

/// Three digits, with an exponent where zeros would hide them.
fn shown(number: f64) -> String {
    let has_few_zeros = number == 0.0 || (1e-3..1e6).contains(&number.abs());
    if !has_few_zeros {
        format!("{number:.2e}")
    } else if number.fract() == 0.0 {
        number.to_string()
    } else {
        format!("{number:.3}")
    }
}

/// Tries every case whose name holds `only`; exit code 1 where one fails.
pub fn run(effort: Effort, only: Option<&str>, as_json: bool) -> Result<ExitCode> {
    let mut all = Vec::new();
    for case in matrix::cases().filter(|case| only.is_none_or(|only| case.name.contains(only))) {
        let facts = CaseFacts::new(case, case.run(effort));
        if !as_json {
            say(&facts.line())?;
        }
        all.push(facts);
    }
    anyhow::ensure!(
        !all.is_empty(),
        "no case's name holds \"{}\"",
        only.unwrap_or_default()
    );
    let failed = all.iter().filter(|case| !case.passed).count();
    let seconds: f64 = all.iter().map(|case| case.seconds).sum();
    if as_json {
        say_json(&serde_json::json!({ "cases": all, "seconds": seconds }))?;
    } else {
        say(&format!(
            "{} of {} cases pass, in {seconds:.0} s",
            all.len() - failed,
            all.len()
        ))?;
    }
    Ok(exit_code(&all))
}

/// Whether all cases pass, as programs ask.
fn exit_code(cases: &[CaseFacts]) -> ExitCode {
    if cases.iter().all(|case| case.passed) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_case_that_fails_makes_the_command_fail() {
        let facts = |measured: f64, passed: bool| {
            let case = matrix::cases().next().expect("there are cases");
            let finding = Finding {
                measured,
                passed,
                seconds: 0.1,
                panic: None,
            };
            CaseFacts::new(case, finding)
        };
        let all = [facts(0.0, true), facts(7.0, false), facts(0.0, true)];
        assert_eq!(exit_code(&all), ExitCode::FAILURE);
        assert_eq!(exit_code(&all[..1]), ExitCode::SUCCESS);
        assert!(all[0].line().starts_with("pass"), "{}", all[0].line());
        assert!(all[1].line().starts_with("FAIL"), "{}", all[1].line());
        // No figure is no pass, and is written as none.
        let broken = facts(f64::NAN, false);
        assert_eq!(exit_code(&[broken]), ExitCode::FAILURE);
    }
}

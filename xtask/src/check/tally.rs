//! Counts tests: passed, failed, and skipped by cause.

use std::collections::{BTreeMap, BTreeSet};

/// The results of the tests of several steps. A step that runs no tests counts as one test.
#[derive(Debug, Default, PartialEq)]
pub struct Tally {
    passed: usize,
    failed: usize,
    /// By cause.
    skipped: BTreeMap<String, usize>,
}

impl Tally {
    /// One check that passed or failed as a whole.
    pub fn add_whole(&mut self, has_passed: bool) {
        self.passed += usize::from(has_passed);
        self.failed += usize::from(!has_passed);
    }

    /// The results of other checks.
    pub fn add(&mut self, others: &Tally) {
        self.passed += others.passed;
        self.failed += others.failed;
        others.skipped.iter().for_each(|(cause, count)| self.add_skipped(cause, *count));
    }

    /// Tests that were not run, for one cause.
    pub fn add_skipped(&mut self, cause: &str, count: usize) {
        *self.skipped.entry(cause.into()).or_default() += count;
    }

    /// A test program: what it printed, and whether it succeeded. One that fails without a failed test (it was killed)
    /// counts as one failed test.
    pub fn add_tests(&mut self, output: &str, has_succeeded: bool) {
        let [passed, failed, ignored] = results(output);
        self.passed += passed;
        self.failed += if has_succeeded { failed } else { failed.max(1) };
        if ignored > 0 {
            self.add_skipped("ignored", ignored);
        }
    }

    /// The `lines` that pytest printed with `-rs`: `SKIPPED [2] tests/a.py:7: no data`, and a last line such as
    /// `1 failed, 117 passed, 2 skipped in 50.33s`.
    pub fn add_pytest(&mut self, lines: &[String], has_succeeded: bool) {
        let of_summary = |line: &&String| line.contains(" passed") || line.contains(" failed");
        let summary = lines.iter().rev().find(of_summary).map_or("", String::as_str);
        self.passed += count_before(summary, " passed");
        let failed = count_before(summary, " failed") + count_before(summary, " error");
        self.failed += if has_succeeded { failed } else { failed.max(1) };
        for line in lines {
            let Some((count, rest)) = line.strip_prefix("SKIPPED [").and_then(|rest| rest.split_once(']')) else {
                continue;
            };
            let cause = rest.split_once(": ").map_or(rest, |(_, cause)| cause).trim();
            self.add_skipped(cause, count.parse().unwrap_or(1));
        }
    }

    /// Lines `BINARY TEST CAUSE`, separated by tabs. Test harnesses count a skipped test as passed; a test that is
    /// listed twice counts once, with its first cause.
    pub fn add_skips(&mut self, skips: &str) {
        let mut seen = BTreeSet::new();
        for line in skips.lines() {
            let Some((test, cause)) = line.rsplit_once('\t') else { continue };
            if seen.insert(test) {
                self.add_skipped(cause, 1);
                self.passed = self.passed.saturating_sub(1);
            }
        }
    }

    pub fn failed(&self) -> usize {
        self.failed
    }

    /// A line per cause, the most frequent first, and the totals: `N passed, N failed, N skipped`.
    pub fn lines(&self) -> Vec<String> {
        let mut causes: Vec<_> = self.skipped.iter().collect();
        causes.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let mut lines: Vec<_> = causes.iter().map(|(cause, count)| format!("{count} skipped: {cause}")).collect();
        let skipped: usize = self.skipped.values().sum();
        lines.push(format!("{} passed, {} failed, {skipped} skipped", self.passed, self.failed));
        lines
    }
}

/// The numbers of passed, failed and ignored tests in the lines `test result: ` of test programs.
pub fn results(output: &str) -> [usize; 3] {
    let mut sums = [0; 3];
    for counts in output.lines().filter_map(|line| line.strip_prefix("test result: ")) {
        for (sum, word) in sums.iter_mut().zip([" passed", " failed", " ignored"]) {
            *sum += count_before(counts, word);
        }
    }
    sums
}

/// The number before a word, of a text such as `ok. 12 passed; 0 failed;`. 0 if there is none.
fn count_before(text: &str, word: &str) -> usize {
    let before = text.split(word).next().filter(|before| before.len() < text.len()).unwrap_or_default();
    let digits = before.rsplit(|c: char| !c.is_ascii_digit()).next().unwrap_or_default();
    digits.parse().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        text.lines().map(str::to_owned).collect()
    }

    const TWO_PROGRAMS: &str = "\
running 3 tests
test a ... ok
test result: ok. 3 passed; 0 failed; 0 ignored; 0 measured; 2 filtered out; finished in 1.20s
     Running tests/suite.rs
test result: FAILED. 10 passed; 2 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.01s";

    #[test]
    fn results_of_programs_are_summed() {
        let mut tally = Tally::default();
        tally.add_tests(TWO_PROGRAMS, false);
        assert_eq!(tally.lines(), ["1 skipped: ignored", "13 passed, 2 failed, 1 skipped"]);
    }

    #[test]
    fn skipped_tests_are_no_passed_ones() {
        let mut tally = Tally::default();
        tally.add_tests("test result: ok. 10 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out", true);
        tally.add_skips("suite-1\ta\tno gfortran\nsuite-1\tb\tonly with --all\nsuite-1\ta\tno valgrind\n");
        tally.add_skips("other-2\ta\tonly with --all\n");
        let expected = ["2 skipped: only with --all", "1 skipped: no gfortran", "7 passed, 0 failed, 3 skipped"];
        assert_eq!(tally.lines(), expected);
    }

    #[test]
    fn a_program_that_fails_without_a_failed_test_counts() {
        let mut tally = Tally::default();
        tally.add_tests("", false);
        tally.add_tests("test result: ok. 4 passed; 0 failed; 0 ignored", false);
        assert_eq!(tally.lines(), ["4 passed, 2 failed, 0 skipped"]);
    }

    #[test]
    fn results_of_pytest_are_counted() {
        let text = "..s.\nSKIPPED [2] tests/test_ranks.py:12: mpi4py is not installed\nFAILED tests/a.py::b - 1 passed\n\
                    1 failed, 117 passed, 2 skipped in 50.33s (0:00:50)";
        let mut tally = Tally::default();
        tally.add_pytest(&lines(text), false);
        assert_eq!(tally.lines(), ["2 skipped: mpi4py is not installed", "117 passed, 1 failed, 2 skipped"]);
        let mut tally = Tally::default();
        tally.add_pytest(&lines("INTERNALERROR> no tests"), false);
        assert_eq!(tally.lines(), ["0 passed, 1 failed, 0 skipped"]);
    }
}

//! A measured number beside the published one, and the verdict that follows from the two.

use std::fmt;

/// Condition that a measured number must satisfy to count as reproduced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Expectation {
    /// At most this far from a value, in the value's unit.
    Near {
        /// The value.
        value: f64,
        /// Largest distance.
        within: f64,
    },
    /// At most this.
    AtMost(f64),
    /// At least this.
    AtLeast(f64),
    /// Between the two, ends included.
    Between(f64, f64),
}

impl Expectation {
    /// Near a value, by a share of it.
    pub fn relative(value: f64, share: f64) -> Self {
        Self::Near {
            value,
            within: (value * share).abs(),
        }
    }

    /// Whether a number satisfies it; NaN never does.
    pub fn holds(&self, measured: f64) -> bool {
        match *self {
            Self::Near { value, within } => (measured - value).abs() <= within,
            Self::AtMost(most) => measured <= most,
            Self::AtLeast(least) => measured >= least,
            Self::Between(least, most) => (least..=most).contains(&measured),
        }
    }
}

impl fmt::Display for Expectation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Near { value, within } => write!(f, "{} ± {}", short(value), short(within)),
            Self::AtMost(most) => write!(f, "≤ {}", short(most)),
            Self::AtLeast(least) => write!(f, "≥ {}", short(least)),
            Self::Between(least, most) => write!(f, "{} to {}", short(least), short(most)),
        }
    }
}

/// Published result.
#[derive(Debug, Clone, PartialEq)]
pub enum Published {
    /// A number, in the finding's unit.
    Number(f64),
    /// A claim without a number, or a number read off a plot, in words.
    Claim(String),
    /// No published result: the measurement is ours, and so is the expectation.
    Nothing,
}

impl fmt::Display for Published {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => f.write_str(&short(*value)),
            Self::Claim(words) => f.write_str(words),
            Self::Nothing => f.write_str("–"),
        }
    }
}

/// A reason for a difference, which is a measurement too: it is given only if it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// The reason, in words that are true if and only if the expectation holds.
    pub reason: String,
    /// The number that decides.
    pub measured: f64,
    /// Condition that the number must satisfy.
    pub expected: Expectation,
}

/// Conclusion from the numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// The measured number satisfies the expectation.
    Reproduced,
    /// The measured number fails the expectation; lists the explanations that hold, with their numbers. Empty: not
    /// explained.
    Differs {
        /// Reasons.
        because: Vec<String>,
    },
}

/// A measured number beside the published one.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Name within the experiment, in kebab case; stored ranges and CSV use it.
    pub key: String,
    /// The figure, table or section of the paper.
    pub figure: String,
    /// Measured quantity.
    pub quantity: String,
    /// Unit of all its numbers; empty for a ratio or a count.
    pub unit: &'static str,
    /// Published result.
    pub published: Published,
    /// Measured value.
    pub measured: f64,
    /// More about the result, such as the order that a count of swaps sums up.
    pub detail: String,
    /// Condition that must hold for the result to count as reproduced.
    pub expected: Expectation,
    /// Reasons for a difference, tried in this order.
    pub explanations: Vec<Explanation>,
    /// Whether it comes from a clock, and so differs between runs.
    pub timed: bool,
}

impl Finding {
    /// A measurement of our own, with what we expect of it. `figure` names the paper's figure, table or section.
    pub fn new(figure: &str, key: &str, quantity: &str, measured: f64, expected: Expectation) -> Self {
        Self {
            key: key.to_owned(),
            figure: figure.to_owned(),
            quantity: quantity.to_owned(),
            unit: "",
            published: Published::Nothing,
            measured,
            detail: String::new(),
            expected,
            explanations: Vec::new(),
            timed: false,
        }
    }

    /// Number of discordant pairs of an order: 0 if `measured`, sorted by its numbers, comes out in the order
    /// `published`. Numbers less than `tie` (a share) apart count as equal.
    pub fn order(
        figure: &str,
        key: &str,
        quantity: &str,
        published: &[&str],
        measured: &[(&str, f64)],
        tie: f64,
    ) -> Self {
        let mut sorted = measured.to_vec();
        sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
        let value = |name: &str| {
            measured
                .iter()
                .find(|one| one.0 == name)
                .map_or(f64::NAN, |one| one.1)
        };
        let mut swapped = 0;
        for (rank, first) in published.iter().enumerate() {
            for second in &published[rank + 1..] {
                let right = value(first) <= value(second) * (1.0 + tie);
                swapped += usize::from(!right);
            }
        }
        Self::new(figure, key, quantity, swapped as f64, Expectation::AtMost(0.0))
            .unit("pairs")
            .published(Published::Claim(published.join(" < ")))
            .detail(in_order(&sorted, tie))
    }

    /// Sets the unit.
    #[must_use]
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// Sets the published result.
    #[must_use]
    pub fn published(mut self, published: Published) -> Self {
        self.published = published;
        self
    }

    /// Sets more words about the result.
    #[must_use]
    pub fn detail(mut self, detail: impl Into<String>) -> Self {
        self.detail = detail.into();
        self
    }

    /// Adds a reason for a difference, given only if its own number holds.
    #[must_use]
    pub fn explained_by(mut self, reason: &str, measured: f64, expected: Expectation) -> Self {
        self.explanations.push(Explanation {
            reason: reason.to_owned(),
            measured,
            expected,
        });
        self
    }

    /// Marks it as coming from a clock.
    #[must_use]
    pub fn timed(mut self) -> Self {
        self.timed = true;
        self
    }

    /// Conclusion from the numbers.
    pub fn verdict(&self) -> Verdict {
        if self.expected.holds(self.measured) {
            return Verdict::Reproduced;
        }
        let holding = self
            .explanations
            .iter()
            .filter(|one| one.expected.holds(one.measured));
        Verdict::Differs {
            because: holding
                .map(|one| format!("{} ({})", one.reason, short(one.measured)))
                .collect(),
        }
    }

    /// The verdict in words.
    pub fn verdict_text(&self) -> String {
        match self.verdict() {
            Verdict::Reproduced if self.published == Published::Nothing => "holds".to_owned(),
            Verdict::Reproduced => "reproduced".to_owned(),
            Verdict::Differs { because } if because.is_empty() => "differs, not explained".to_owned(),
            Verdict::Differs { because } => format!("differs because {}", because.join("; ")),
        }
    }

    /// The measured number with its unit and detail.
    pub fn measured_text(&self) -> String {
        let number = format!("{} {}", short(self.measured), self.unit);
        match self.detail.as_str() {
            "" => number.trim_end().to_owned(),
            detail => format!("{} ({detail})", number.trim_end()),
        }
    }
}

/// Names and numbers, smallest first; those closer than `tie` count as equal.
fn in_order(sorted: &[(&str, f64)], tie: f64) -> String {
    let mut text = String::new();
    let mut before = f64::NEG_INFINITY;
    for (name, number) in sorted {
        let sign = match *number <= before * (1.0 + tie) {
            true => " ≈ ",
            false => " < ",
        };
        if before.is_finite() {
            text.push_str(sign);
        }
        text.push_str(&format!("{name} {}", short(*number)));
        before = *number;
    }
    if text.contains('≈') {
        text.push_str(&format!(
            "; ≈ is less than {} % apart and counts as equal",
            short(100.0 * tie)
        ));
    }
    text
}

/// A number in few digits: about four significant ones.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    let decimals = (3.0 - magnitude).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_follows_from_numbers_alone() {
        let finding = Finding::new("Fig. 1", "a", "a length", 1.2, Expectation::relative(1.0, 0.1));
        assert_eq!(finding.verdict_text(), "differs, not explained");
        let explained = finding
            .clone()
            .explained_by("this does not hold", 3.0, Expectation::AtMost(2.0))
            .explained_by("the ruler is long", 1.2, Expectation::AtLeast(1.1));
        assert_eq!(
            explained.verdict_text(),
            "differs because the ruler is long (1.2)"
        );
        let near = Finding {
            measured: 1.05,
            ..finding
        };
        assert_eq!(near.verdict_text(), "holds");
        assert_eq!(
            near.published(Published::Number(1.0)).verdict_text(),
            "reproduced"
        );
    }

    #[test]
    fn what_is_not_a_number_holds_nowhere() {
        for expected in [
            Expectation::AtMost(1.0),
            Expectation::AtLeast(1.0),
            Expectation::Between(0.0, 1.0),
            Expectation::relative(1.0, 1.0),
        ] {
            assert!(!expected.holds(f64::NAN), "{expected}");
        }
    }

    #[test]
    fn an_order_counts_the_pairs_that_are_swapped() {
        let measured = [("slow", 3.0), ("fast", 1.0), ("middle", 1.02)];
        let order =
            |published: &[&str], tie| Finding::order("T", "o", "time", published, &measured, tie).measured;
        assert_eq!(order(&["fast", "middle", "slow"], 0.0), 0.0);
        assert_eq!(order(&["slow", "middle", "fast"], 0.0), 3.0);
        assert_eq!(order(&["middle", "fast", "slow"], 0.0), 1.0);
        assert_eq!(order(&["middle", "fast", "slow"], 0.03), 0.0);
        assert_eq!(order(&["fast", "absent"], 0.0), 1.0);
        let words = |tie| Finding::order("T", "o", "time", &[], &measured, tie).detail;
        assert_eq!(words(0.0), "fast 1 < middle 1.02 < slow 3");
        assert_eq!(
            words(0.03),
            "fast 1 ≈ middle 1.02 < slow 3; ≈ is less than 3 % apart and counts as equal"
        );
    }

    #[test]
    fn numbers_are_short() {
        let texts = [0.0, 1.15, 0.000_712_34, 35_400.4, 1e-7, 2.5e8].map(short);
        assert_eq!(texts, ["0", "1.15", "0.0007123", "35400", "1.00e-7", "2.50e8"]);
    }
}

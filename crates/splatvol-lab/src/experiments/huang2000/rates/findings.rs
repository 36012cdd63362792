//! Findings of Fig. 5 and 6.

use super::{ENGINE, Rates};
use crate::experiments::huang2000::method::FASTSPLATS;
use crate::{Expectation, Finding, Outcome, Published};

/// The order of the four, and how rates grow with the radius.
pub(super) fn rate_findings(outcome: &mut Outcome, (figure, key): (&str, &str), rates: &Rates) {
    let order = ["linear", "RLUT", "square", "2D"];
    for radius in [4.0, 24.0] {
        let measured = order.map(|method| (method, rates.at(method, radius) / 1e6));
        let without_root = ["RLUT", "square", "2D"].map(|method| rates.at(method, radius));
        let most = without_root.into_iter().fold(0.0, f64::max);
        let least = without_root.into_iter().fold(f64::INFINITY, f64::min);
        outcome.find(
            Finding::order(
                figure,
                &format!("{key}-order-{radius}"),
                &format!("million pixels per second at radius {radius}: pairs in another order"),
                &order,
                &measured,
                0.03,
            )
            .timed()
            .explained_by(
                "the methods without a root are bound by adding to channels, not by finding entries: their rates are within this factor",
                most / least,
                Expectation::AtMost(1.25),
            ),
        );
    }
    let square = |radius| rates.at("square", radius);
    outcome.find(
        Finding::new(
            figure,
            &format!("{key}-grows"),
            "rate of square at radius 24 over its rate at 2",
            square(24.0) / square(2.0),
            Expectation::AtLeast(1.2),
        )
        .published(Published::Claim("for large splats, higher rates".to_owned()))
        .timed(),
    );
    outcome.find(
        Finding::new(
            figure,
            &format!("{key}-levels-off"),
            "rate of square at radius 24 over its rate at 16",
            square(24.0) / square(16.0),
            Expectation::relative(1.0, 0.15),
        )
        .published(Published::Claim(
            "levels off as the radius approaches 24".to_owned(),
        ))
        .timed(),
    );
    outcome.find(
        Finding::new(
            figure,
            &format!("{key}-default-engine"),
            "rate of the default engine over that of 2D, radius 8",
            rates.at(ENGINE, 8.0) / rates.at("2D", 8.0),
            Expectation::AtLeast(2.0),
        )
        .timed(),
    );
}

pub(super) fn channel_findings(outcome: &mut Outcome, [four, one]: [&Rates; 2]) {
    for (method, _) in FASTSPLATS {
        outcome.find(
            Finding::new(
                "Fig. 6",
                &format!("one-over-four-{}", method.to_lowercase()),
                &format!("rate of one channel over that of four, {method}, radius 16"),
                one.at(method, 16.0) / four.at(method, 16.0),
                Expectation::Between(1.05, 2.5),
            )
            .published(Published::Claim("higher, far less than 3".to_owned()))
            .timed(),
        );
    }
}

//! All papers and experiments.

use crate::experiments::{beyond, huang2000, mueller1998, swan1997, zwicker2001};
use crate::{Experiment, LabError, Paper};

/// The papers, oldest first, with all their figures and tables.
pub fn papers() -> [&'static Paper; 4] {
    [
        &swan1997::PAPER,
        &mueller1998::PAPER,
        &huang2000::PAPER,
        &zwicker2001::PAPER,
    ]
}

/// All experiments, by paper; ours last.
pub fn experiments() -> impl Iterator<Item = &'static Experiment> {
    [
        swan1997::EXPERIMENTS,
        mueller1998::EXPERIMENTS,
        huang2000::EXPERIMENTS,
        zwicker2001::EXPERIMENTS,
        beyond::EXPERIMENTS,
    ]
    .into_iter()
    .flatten()
}

/// The experiment with this name.
///
/// # Errors
/// No experiment has this name; the error suggests one that begins alike.
pub fn experiment(name: &str) -> Result<&'static Experiment, LabError> {
    let alike = |one: &Experiment| {
        let same = one.name.chars().zip(name.chars()).take_while(|(a, b)| a == b);
        same.count()
    };
    experiments()
        .find(|one| one.name == name)
        .ok_or_else(|| LabError::UnknownName {
            name: name.to_owned(),
            nearest: experiments()
                .max_by_key(|one| alike(one))
                .filter(|one| alike(one) > 3)
                .map(|one| one.name),
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_are_unique_and_belong_to_their_paper() {
        let mut names = HashSet::new();
        for one in experiments() {
            assert!(names.insert(one.name), "{} twice", one.name);
            assert!(one.name.starts_with(one.paper), "{} of {}", one.name, one.paper);
            assert!(!one.about.is_empty() && !one.title.is_empty(), "{}", one.name);
            assert_eq!(experiment(one.name).unwrap().name, one.name);
        }
        assert!(experiment("nothing").is_err());
    }

    #[test]
    fn figures_and_experiments_name_each_other() {
        for paper in papers() {
            for figure in paper.figures {
                for name in figure.experiments {
                    let one = experiment(name).unwrap();
                    assert!(
                        one.figures.contains(&figure.number),
                        "{name} lacks {}",
                        figure.number
                    );
                }
            }
            for one in experiments().filter(|one| one.paper == paper.key) {
                for number in one.figures.iter().filter(|number| !number.starts_with("Section")) {
                    let entry = paper.figures.iter().find(|figure| figure.number == *number);
                    assert!(
                        entry.is_some_and(|entry| entry.experiments.contains(&one.name)),
                        "{number}"
                    );
                }
            }
        }
    }
}

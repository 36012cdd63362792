//! The child process: damages inputs of one target and watches what comes of them.
//!
//! Answers guide it: an input whose answer is new, numbers apart, is kept and damaged further.

use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Result;

use crate::input::Input;
use crate::random::Random;
use crate::target::Target;
use crate::targets::KNOWN;
use crate::trial::{Clock, Fault, Trial, processor_time};

/// Most inputs that are kept for their answers.
const KEPT: usize = 400;
/// Most findings that are written: more of the same help nobody.
const FINDINGS: usize = 10;

/// How long, and from where.
#[derive(Debug, Clone)]
pub(crate) struct Extent {
    pub(crate) seed: u64,
    pub(crate) inputs: u64,
    /// Of the processor.
    pub(crate) seconds: f64,
    pub(crate) clock: Clock,
}

/// Counts of a run, as a line of text between the processes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) inputs: u64,
    pub(crate) accepted: u64,
    pub(crate) answers: u64,
    pub(crate) rendered: u64,
    pub(crate) findings: u64,
    /// Time of the processor.
    pub(crate) milliseconds: u64,
}

impl Counts {
    pub(crate) fn line(&self) -> String {
        let Self {
            inputs,
            accepted,
            answers,
            rendered,
            findings,
            milliseconds,
        } = self;
        format!("{inputs} {accepted} {answers} {rendered} {findings} {milliseconds}")
    }

    pub(crate) fn of_line(line: &str) -> Option<Self> {
        let numbers: Vec<u64> = line.split(' ').map_while(|number| number.parse().ok()).collect();
        let [inputs, accepted, answers, rendered, findings, milliseconds] = numbers[..] else {
            return None;
        };
        Some(Self {
            inputs,
            accepted,
            answers,
            rendered,
            findings,
            milliseconds,
        })
    }
}

/// Runs to the end of the extent. Faults are written below `findings`, counts to standard output.
pub(crate) fn run(target: &Target, extent: &Extent, work: &Path, findings: &Path) -> Result<()> {
    let start = processor_time();
    let elapsed = || processor_time().saturating_sub(start);
    let mut campaign = Campaign {
        target,
        trial: Trial::new(target.reader, work.to_owned(), extent.clock),
        findings: findings.to_owned(),
        seed: extent.seed,
        seeds: (target.seeds)(),
        kept: Vec::new(),
        answers: HashMap::new(),
        faults: HashMap::new(),
        counts: Counts::default(),
    };
    for index in 0..campaign.seeds.len() {
        let seed = campaign.seeds[index].clone();
        let accepted = campaign.try_input(&seed, true)?;
        anyhow::ensure!(
            accepted,
            "seed {index} of {} is refused: {:?}",
            target.name,
            campaign.answers.keys()
        );
    }
    campaign.counts = Counts {
        findings: campaign.counts.findings,
        ..Counts::default()
    };
    let mut random = Random(extent.seed ^ 0x5eed);
    let mut reported = Instant::now();
    while campaign.counts.inputs < extent.inputs && elapsed().as_secs_f64() < extent.seconds {
        let input = campaign.next(&mut random);
        let renders = random.below(8) == 0;
        campaign.try_input(&input, renders)?;
        if reported.elapsed() > Duration::from_millis(500) {
            reported = Instant::now();
            campaign.report(elapsed())?;
        }
    }
    campaign.report(elapsed())
}

struct Campaign<'a> {
    target: &'a Target,
    trial: Trial,
    findings: PathBuf,
    seed: u64,
    seeds: Vec<Input>,
    kept: Vec<Input>,
    /// Answers, and how often each was given.
    answers: HashMap<String, u64>,
    faults: HashMap<String, u64>,
    counts: Counts,
}

impl Campaign<'_> {
    fn next(&self, random: &mut Random) -> Input {
        let all = self.seeds.len() + self.kept.len();
        let of = |index: usize| {
            self.seeds
                .get(index)
                .unwrap_or_else(|| &self.kept[index - self.seeds.len()])
        };
        let base = match random.below(3) {
            0 => of(random.below(self.seeds.len())),
            _ => of(random.below(all)),
        };
        let donor = of(random.below(all));
        let mut input = base.damaged(random, self.target.dictionary, donor);
        while random.below(4) == 0 {
            input = input.damaged(random, self.target.dictionary, donor);
        }
        input
    }

    /// Whether it was accepted.
    fn try_input(&mut self, input: &Input, renders: bool) -> Result<bool> {
        let outcome = self.trial.run(input, renders)?;
        self.counts.inputs += 1;
        self.counts.accepted += u64::from(outcome.accepted);
        self.counts.rendered += u64::from(outcome.rendered);
        let times = self.answers.entry(outcome.answer).or_default();
        *times += 1;
        if *times == 1 && self.kept.len() < KEPT {
            self.kept.push(input.clone());
        }
        self.counts.answers = self.answers.len() as u64;
        match outcome.fault {
            Some(fault) if !is_known(self.target, &fault.line()) => self.note(input, &fault)?,
            _ => {}
        }
        Ok(outcome.accepted)
    }

    /// Writes an input and its fault, unless faults at that place are known.
    fn note(&mut self, input: &Input, fault: &Fault) -> Result<()> {
        let times = self.faults.entry(fault.place()).or_default();
        *times += 1;
        if *times > 1 || self.faults.len() > FINDINGS {
            return Ok(());
        }
        let name = format!("{}-{}-{}", self.target.name, self.seed, self.counts.inputs);
        input.write(&self.findings.join(&name))?;
        self.counts.findings += 1;
        let mut out = std::io::stdout().lock();
        writeln!(out, "finding {name} {}", fault.line())?;
        Ok(())
    }

    fn report(&mut self, elapsed: Duration) -> Result<()> {
        self.counts.milliseconds = elapsed.as_millis() as u64;
        let mut out = std::io::stdout().lock();
        writeln!(out, "counts {}", self.counts.line())?;
        out.flush()?;
        Ok(())
    }
}

/// Whether a fault is on the list of those that are still open.
pub(crate) fn is_known(target: &Target, line: &str) -> bool {
    let fits = |name: &str| name.is_empty() || name == target.name;
    KNOWN.iter().any(|(name, text)| fits(name) && line.contains(text))
}

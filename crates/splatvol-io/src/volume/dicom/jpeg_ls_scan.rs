//! The samples of a scan of JPEG-LS (T.87, annex A; several components: annex B).
//!
//! Lines of components alternate with a run's length for each component; interleaved samples share their runs, which go
//! on while all components do. All components of a scan share the statistics.

use super::jpeg_ls_bits::Bits;
use super::jpeg_ls_context::{Parameters, Statistics};

/// Lengths of runs, as powers of two (A.2.1).
const RUN_POWERS: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13, 14, 15,
];

/// The line of a component that is decoded and the one above it, with one sample more on either side.
struct Lines {
    previous: Vec<i32>,
    current: Vec<i32>,
}

impl Lines {
    fn new(columns: usize) -> Self {
        Self {
            previous: vec![0; columns + 2],
            current: vec![0; columns + 2],
        }
    }

    /// Sets the samples beside a line (A.2.1: left of it is the sample above its first one).
    fn begin(&mut self) {
        let columns = self.previous.len() - 2;
        self.current[0] = self.previous[1];
        self.previous[columns + 1] = self.previous[columns];
    }

    /// Left, above, and left of above.
    fn neighbours(&self, x: usize) -> [i32; 3] {
        [self.current[x - 1], self.previous[x], self.previous[x - 1]]
    }

    /// The context: quantised gradients, 0 where all vanish.
    fn surrounding(&self, x: usize, parameters: &Parameters) -> i32 {
        let [left, above, above_left] = self.neighbours(x);
        let gradients = [
            self.previous[x + 1] - above,
            above - above_left,
            above_left - left,
        ];
        let [first, second, third] = gradients.map(|gradient| parameters.quantised(gradient));
        81 * first + 9 * second + third
    }
}

/// Components whose samples alternate, and the length of their runs.
struct Group {
    lines: Vec<Lines>,
    run_index: usize,
}

/// A scan while it is decoded.
pub(super) struct Scan<'a> {
    coder: Coder<'a>,
    groups: Vec<Group>,
}

impl<'a> Scan<'a> {
    /// A scan of so many groups of components, whose samples alternate within a group and whose lines do between groups.
    pub(super) fn new(bytes: &'a [u8], columns: usize, groups: [usize; 2], parameters: Parameters) -> Self {
        let [groups, components] = groups;
        let group = || Group {
            lines: (0..components).map(|_| Lines::new(columns)).collect(),
            run_index: 0,
        };
        Self {
            coder: Coder::new(bytes, parameters),
            groups: (0..groups).map(|_| group()).collect(),
        }
    }

    /// Decodes a line of all components.
    pub(super) fn line(&mut self) -> Option<()> {
        for group in &mut self.groups {
            group.line(&mut self.coder)?;
        }
        Some(())
    }

    /// The components' lines that were decoded last.
    pub(super) fn lines(&self) -> impl Iterator<Item = &[i32]> {
        let lines = self.groups.iter().flat_map(|group| &group.lines);
        lines.map(|lines| &lines.previous[1..lines.previous.len() - 1])
    }

    /// The place of the first byte behind the samples.
    pub(super) fn position(&self) -> usize {
        self.coder.bits.position()
    }
}

impl Group {
    fn line(&mut self, coder: &mut Coder<'_>) -> Option<()> {
        self.lines.iter_mut().for_each(Lines::begin);
        let columns = self.lines.first()?.current.len() - 2;
        let mut x = 1;
        while x <= columns {
            let runs = |lines: &Lines| lines.surrounding(x, &coder.parameters) == 0;
            if self.lines.iter().all(runs) {
                x = self.run(x, coder)?;
                continue;
            }
            for lines in &mut self.lines {
                let surrounding = lines.surrounding(x, &coder.parameters);
                lines.current[x] = coder.regular(surrounding, lines.neighbours(x))?;
            }
            x += 1;
        }
        for lines in &mut self.lines {
            std::mem::swap(&mut lines.previous, &mut lines.current);
        }
        Some(())
    }

    /// Decodes a run from `x` on, and the samples that end it; returns the next x (A.7).
    fn run(&mut self, mut x: usize, coder: &mut Coder<'_>) -> Option<usize> {
        let columns = self.lines.first()?.current.len() - 2;
        loop {
            let power = RUN_POWERS[self.run_index];
            let rest = columns + 1 - x;
            if coder.bits.bit()? == 0 {
                let taken = coder.bits.bits(power)? as usize;
                if taken >= rest {
                    return None;
                }
                self.repeat(x, taken);
                self.end_run(x + taken, coder)?;
                return Some(x + taken + 1);
            }
            let taken = (1 << power).min(rest);
            self.repeat(x, taken);
            x += taken;
            if taken == 1 << power {
                self.run_index = (self.run_index + 1).min(31);
            }
            if x > columns {
                return Some(x);
            }
        }
    }

    /// Copies the samples left of `x`.
    fn repeat(&mut self, x: usize, count: usize) {
        for lines in &mut self.lines {
            let left = lines.current[x - 1];
            lines.current[x..x + count].fill(left);
        }
    }

    fn end_run(&mut self, x: usize, coder: &mut Coder<'_>) -> Option<()> {
        let alone = self.lines.len() == 1;
        for lines in &mut self.lines {
            let [left, above, _] = lines.neighbours(x);
            let kind = i32::from(alone && (left - above).abs() <= coder.parameters.near);
            lines.current[x] = coder.run_end([left, above], kind, self.run_index)?;
        }
        self.run_index = self.run_index.saturating_sub(1);
        Some(())
    }
}

/// Errors and what they have taught.
struct Coder<'a> {
    bits: Bits<'a>,
    parameters: Parameters,
    contexts: Vec<Statistics>,
    /// Bits of an error, and the longest code.
    width: u32,
    limit: u32,
}

impl<'a> Coder<'a> {
    fn new(bytes: &'a [u8], parameters: Parameters) -> Self {
        let range = parameters.range();
        let bits_of = |value: i32| 32 - (value.max(2) - 1).leading_zeros();
        let sample_bits = bits_of(parameters.max_value + 1).max(2);
        Self {
            bits: Bits::new(bytes),
            contexts: vec![Statistics::new(range); 367],
            width: bits_of(range),
            limit: 2 * (sample_bits + sample_bits.max(8)),
            parameters,
        }
    }

    /// A sample from its neighbours (A.4 to A.6).
    fn regular(&mut self, surrounding: i32, [left, above, above_left]: [i32; 3]) -> Option<i32> {
        // Among interleaved samples, one whose gradients vanish need not begin a run.
        let sign = if surrounding < 0 { -1 } else { 1 };
        let context = &mut self.contexts[surrounding.unsigned_abs() as usize];
        let (low, high) = (left.min(above), left.max(above));
        let median = (left + above - above_left).clamp(low, high);
        let predicted = (median + sign * context.correction).clamp(0, self.parameters.max_value);
        let k = context.golomb(context.sizes);
        let mapped = self.bits.golomb(k, self.limit, self.width)?;
        let mut error = if mapped & 1 == 0 {
            mapped >> 1
        } else {
            -(mapped >> 1) - 1
        };
        if self.parameters.near == 0 && k == 0 && 2 * context.bias <= -context.count {
            error = -error - 1;
        }
        context.learn(error, &self.parameters);
        Some(self.restored(predicted, sign * error))
    }

    /// Prediction and error to a sample, modulo the range (A.4.5, A.8).
    fn restored(&self, predicted: i32, error: i32) -> i32 {
        let Parameters { max_value, near, .. } = self.parameters;
        let step = 2 * near + 1;
        let modulus = self.parameters.range() * step;
        let mut sample = predicted + error * step;
        if sample < -near {
            sample += modulus;
        } else if sample > max_value + near {
            sample -= modulus;
        }
        sample.clamp(0, max_value)
    }

    /// The sample that differs (A.7.2), with an error of `kind` 1 where left and above agree and stand for themselves alone.
    fn run_end(&mut self, [left, above]: [i32; 2], kind: i32, run_index: usize) -> Option<i32> {
        let context = &mut self.contexts[365 + kind as usize];
        let total = context.sizes + if kind == 1 { context.count >> 1 } else { 0 };
        let k = context.golomb(total);
        let limit = self.limit - RUN_POWERS[run_index] - 1;
        let mapped = self.bits.golomb(k, limit, self.width)?;
        let doubled = mapped + kind;
        let turned = k != 0 || 2 * context.negative >= context.count;
        let size = (doubled + 1) >> 1;
        let error = if (doubled & 1 == 1) == turned { -size } else { size };
        context.learn_end(error, mapped, kind, self.parameters.reset);
        if kind == 1 {
            return Some(self.restored(left, error));
        }
        let sign = if left > above { -1 } else { 1 };
        Some(self.restored(above, sign * error))
    }
}

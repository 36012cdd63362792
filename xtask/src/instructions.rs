//! The kernels' machine code: vectors as wide as promised, and nothing called in them that should have been inlined.
//!
//! A kernel is written once and compiled for every SIMD level, as a function `vectorize_LEVEL`. Two mistakes cost half
//! of its speed and change no result: code that is not inlined into that function is compiled for the baseline
//! processor, and an operation on vectors that is not inlined (`__fearless_simd_kernel`) passes them through memory.
//! Closures and `array::from_fn` have led to both.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Decoder of the machine code of a function at an address.
type Decode = fn(&[u8], u64) -> Found;

use anyhow::{Context, Result, bail};
use object::{Architecture, Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use serde_json::Value;

use crate::decode::{Found, arm, x86};
use crate::metadata::run;

/// Part of the name of operations that ought to be inlined.
const OPERATION: &str = "__fearless_simd_kernel";

/// Instruction that the functions of a SIMD level must contain somewhere.
struct Level {
    function: &'static str,
    instruction: &'static str,
    count: fn(&Found) -> usize,
}

const X86: [Level; 3] = [
    Level {
        function: "vectorize_avx512",
        instruction: "fused multiply-adds of zmm registers",
        count: |found| found.fused_512,
    },
    Level {
        function: "vectorize_avx2",
        instruction: "fused multiply-adds of ymm registers",
        count: |found| found.fused_256,
    },
    Level {
        function: "vectorize_sse4_2",
        instruction: "packed multiplications of xmm registers",
        count: |found| found.packed_128,
    },
];

// NEON is every such processor's baseline: its functions are inlined into ordinary ones.
const ARM: [Level; 1] = [Level {
    function: "",
    instruction: "fused multiply-adds of NEON registers",
    count: |found| found.packed_128,
}];

/// A function of the program.
struct Function<'a> {
    name: &'a str,
    address: u64,
    code: &'a [u8],
}

/// Checks a program, or builds the command for release and checks that.
pub(crate) fn check(root: &Path, program: Option<&str>) -> Result<String> {
    let path = match program {
        Some(program) => PathBuf::from(program),
        None => build(root)?,
    };
    let name = path.display().to_string();
    let bytes = std::fs::read(&path).with_context(|| name.clone())?;
    let file = object::File::parse(&*bytes).with_context(|| name.clone())?;
    let functions = functions(&file)?;
    let (levels, decode): (&[Level], Decode) = match file.architecture() {
        Architecture::X86_64 => (&X86, x86),
        Architecture::Aarch64 => (&ARM, arm),
        other => bail!("{name}: the instructions of {other:?} are not known here"),
    };
    let found: Vec<Found> = functions.iter().map(|f| decode(f.code, f.address)).collect();
    let (mut summary, mut problems) = (String::new(), Vec::new());
    for level in levels {
        let of_level = || {
            functions
                .iter()
                .zip(&found)
                .filter(|(f, _)| f.name.contains(level.function))
        };
        let count: usize = of_level().map(|(_, found)| (level.count)(found)).sum();
        let (number, what) = (of_level().count(), level.instruction);
        if count == 0 {
            problems.push(format!("{number} functions *{}* have no {what}", level.function));
        }
        write!(
            summary,
            "\n  {number} functions *{}*: {count} {what}",
            level.function
        )?;
    }
    let calls = calls_of_operations(&functions, &found);
    if !calls.is_empty() {
        problems.push(
            "vector operations that are not inlined (in kernels, loops and functions of #[inline(always)] instead of \
             closures that array::map or from_fn call):"
                .to_owned(),
        );
        problems.extend(calls);
    }
    if !problems.is_empty() {
        bail!("{name}:\n{}{summary}", problems.join("\n"));
    }
    Ok(format!("{name}: nothing calls a vector operation{summary}"))
}

/// Builds the command, and returns its path.
fn build(root: &Path) -> Result<PathBuf> {
    let arguments = [
        "build",
        "--locked",
        // As the release profile, with the names of functions.
        "--profile=profiling",
        "--package",
        "splatvol-cli",
        "--message-format=json",
    ];
    let output = run(Command::new(env!("CARGO")).args(arguments).current_dir(root))?;
    String::from_utf8_lossy(&output)
        .lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .find_map(|message| Some(PathBuf::from(message.get("executable")?.as_str()?)))
        .context("cargo names no executable of splatvol-cli")
}

/// All functions, by address. Code between two symbols belongs to the first: not every format records sizes.
fn functions<'a>(file: &'a object::File<'a>) -> Result<Vec<Function<'a>>> {
    let mut functions = Vec::new();
    for section in file
        .sections()
        .filter(|section| section.kind() == SectionKind::Text)
    {
        let (start, data) = (section.address(), section.data()?);
        let symbols: BTreeMap<u64, &str> = file
            .symbols()
            .filter(|symbol| {
                symbol.kind() == SymbolKind::Text && symbol.section_index() == Some(section.index())
            })
            .filter_map(|symbol| Some((symbol.address(), symbol.name().ok()?)))
            .collect();
        let ends = symbols.keys().skip(1).copied().chain([start + data.len() as u64]);
        for ((&address, &name), end) in symbols.iter().zip(ends) {
            let range = address.saturating_sub(start) as usize..end.saturating_sub(start) as usize;
            let code = data
                .get(range)
                .with_context(|| format!("{name} lies outside its section"))?;
            functions.push(Function { name, address, code });
        }
    }
    if functions.is_empty() {
        bail!("the program has no symbols");
    }
    Ok(functions)
}

/// A line for every function that calls an operation instead of containing it.
fn calls_of_operations(functions: &[Function<'_>], found: &[Found]) -> Vec<String> {
    let operations: BTreeMap<u64, &str> = functions
        .iter()
        .filter(|function| function.name.contains(OPERATION))
        .map(|function| (function.address, function.name))
        .collect();
    let mut lines = Vec::new();
    for (function, found) in functions.iter().zip(found) {
        let mut calls: BTreeMap<&str, usize> = BTreeMap::new();
        for target in &found.targets {
            // Jumps within an operation are not calls.
            if let Some(name) = operations.get(target).filter(|_| *target != function.address) {
                *calls.entry(name).or_default() += 1;
            }
        }
        lines.extend(calls.into_iter().map(|(operation, count)| {
            let (caller, operation) = (readable(function.name), readable(operation));
            format!(
                "{caller} (at {:#x})\n  calls {operation} in {count} places",
                function.address
            )
        }));
    }
    lines
}

fn readable(symbol: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(symbol))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_of_operations_are_named_with_their_callers() {
        let function = |name, address| Function {
            name,
            address,
            code: &[],
        };
        let functions = [
            function("kernel", 16),
            function("mul::__fearless_simd_kernel", 64),
            function("other", 80),
        ];
        let calls = |targets: &[u64]| Found {
            targets: targets.to_vec(),
            ..Found::default()
        };
        let bad = [calls(&[64, 80, 64]), calls(&[64]), calls(&[16])];
        let lines = calls_of_operations(&functions, &bad);
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(
            lines[0].starts_with("kernel (at 0x10)") && lines[0].ends_with("in 2 places"),
            "{lines:?}"
        );
        let good = [calls(&[80]), calls(&[]), calls(&[])];
        assert_eq!(calls_of_operations(&functions, &good), Vec::<String>::new());
    }

    #[test]
    fn this_program_s_functions_are_found() {
        let bytes = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        let file = object::File::parse(&*bytes).unwrap();
        let functions = functions(&file).unwrap();
        let own = functions
            .iter()
            .find(|f| f.name.contains("calls_of_operations"))
            .unwrap();
        assert!(!own.code.is_empty());
    }
}

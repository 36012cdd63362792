//! The machine that times were measured on.

/// Name of the processor if the system reports it, otherwise of the architecture.
pub(super) fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    model(&told).unwrap_or(std::env::consts::ARCH).to_owned()
}

/// The first processor's name in Linux's `cpuinfo`, which not every architecture has.
fn model(told: &str) -> Option<&str> {
    let entries = told.lines().filter_map(|line| line.split_once(':'));
    let mut names = entries.filter(|(key, _)| key.trim() == "model name");
    names
        .next()
        .map(|(_, name)| name.trim())
        .filter(|name| !name.is_empty())
}

/// Number of threads that `Workbench::threads` stands for.
pub(super) fn threads(asked: Option<usize>) -> usize {
    asked.unwrap_or_else(rayon::current_num_threads)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_processor_s_name_is_found() {
        let told = "processor\t: 0\nmodel\t\t: 1\nmodel name\t: Maker 9: the Fast\nmodel name\t: other\n";
        assert_eq!(model(told), Some("Maker 9: the Fast"));
        assert_eq!(model("processor\t: 0\nBogoMIPS\t: 50.00\n"), None);
        assert_eq!(model("model name\t: \n"), None);
        assert!(!processor().is_empty() && threads(Some(3)) == 3 && threads(None) > 0);
    }
}

//! Names of clip paths that depend on nothing but the plot.
//!
//! The plotting crate numbers its clip paths over all plots that the process has drawn, so the same plot would have
//! different bytes each time. If they were numbered from zero in each plot, plots on one page would use each other's.
//! Here they are numbered within the plot, after a hash of its text (FNV-1a, 64 bits).

/// Prefix of the plotting crate's identifiers; a number follows.
const PREFIX: &str = "kuva-clip-";

/// This drawing, its clip paths renamed.
pub(super) fn stable(svg: &str) -> String {
    let numbers = numbers(svg);
    let place = |number: &str| numbers.iter().position(|known| *known == number).unwrap_or(0);
    let anonymous = renamed(svg, |number| format!("{}", place(number)));
    let hash = anonymous.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    renamed(svg, |number| format!("clip-{hash:016x}-{}", place(number)))
}

/// The numbers that follow the prefix, in the order of their first appearance.
fn numbers(svg: &str) -> Vec<&str> {
    let mut numbers = Vec::new();
    for rest in svg.split(PREFIX).skip(1) {
        let number = leading_digits(rest);
        if !numbers.contains(&number) {
            numbers.push(number);
        }
    }
    numbers
}

fn renamed(svg: &str, name: impl Fn(&str) -> String) -> String {
    let mut parts = svg.split(PREFIX);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for rest in parts {
        let number = leading_digits(rest);
        text.push_str(&name(number));
        text.push_str(&rest[number.len()..]);
    }
    text
}

fn leading_digits(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    &text[..end]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_the_plot_and_not_the_count_of_plots() {
        let drawing = |first: u32, word: &str| {
            let second = first + 1;
            format!(
                "<a id=\"kuva-clip-{first}\"/><b id=\"kuva-clip-{second}\"/><g clip=\"url(#kuva-clip-{first})\">{word}"
            )
        };
        let [one, later, other] = [drawing(0, "x"), drawing(9, "x"), drawing(0, "y")].map(|svg| stable(&svg));
        assert_eq!(one, later);
        assert_ne!(one.split('"').nth(1), other.split('"').nth(1));
        let names: Vec<&str> = one.split('"').collect();
        assert_ne!(names[1], names[3]);
        assert_eq!(names[5], format!("url(#{})", names[1]));
        assert_eq!(stable("<svg/>"), "<svg/>");
    }
}

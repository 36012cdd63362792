//! Licence expressions, as in SPDX annex D: names joined by `AND`, `OR` and `WITH`, in parentheses.
//!
//! The older `MIT/Apache-2.0` of crates.io means `OR`.

use anyhow::{Result, bail};

/// Whether a licence expression can be met with licences that `allowed` accepts. `A WITH B` needs A.
pub(crate) fn satisfied(expression: &str, allowed: &dyn Fn(&str) -> bool) -> Result<bool> {
    let spaced = expression
        .replace('(', " ( ")
        .replace(')', " ) ")
        .replace('/', " OR ");
    let mut parser = Parser {
        tokens: spaced.split_whitespace().collect(),
        next: 0,
        allowed,
    };
    let value = parser.any()?;
    match parser.peek() {
        None => Ok(value),
        Some(token) => bail!("licence expression {expression:?}: unexpected {token:?}"),
    }
}

struct Parser<'a> {
    tokens: Vec<&'a str>,
    next: usize,
    allowed: &'a dyn Fn(&str) -> bool,
}

impl<'a> Parser<'a> {
    fn peek(&self) -> Option<&'a str> {
        self.tokens.get(self.next).copied()
    }

    fn take(&mut self, token: &str) -> bool {
        let found = self.peek() == Some(token);
        self.next += usize::from(found);
        found
    }

    fn any(&mut self) -> Result<bool> {
        let mut value = self.all()?;
        while self.take("OR") {
            value |= self.all()?;
        }
        Ok(value)
    }

    fn all(&mut self) -> Result<bool> {
        let mut value = self.one()?;
        while self.take("AND") {
            value &= self.one()?;
        }
        Ok(value)
    }

    fn one(&mut self) -> Result<bool> {
        if self.take("(") {
            let value = self.any()?;
            if !self.take(")") {
                bail!("licence expression without its closing parenthesis");
            }
            return Ok(value);
        }
        let name = self.name()?;
        if self.take("WITH") {
            self.name()?;
        }
        Ok((self.allowed)(name))
    }

    fn name(&mut self) -> Result<&'a str> {
        match self.peek() {
            Some(name) if !["AND", "OR", "WITH", "(", ")"].contains(&name) => {
                self.next += 1;
                Ok(name)
            }
            other => bail!("licence expression: expected a name, found {other:?}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_mit_and_zlib(expression: &str) -> Result<bool> {
        satisfied(expression, &|name| ["MIT", "Zlib"].contains(&name))
    }

    #[test]
    fn one_branch_of_or_and_all_of_and_must_be_allowed() {
        for (expression, expected) in [
            ("MIT", true),
            ("GPL-3.0-only", false),
            ("GPL-3.0-only OR MIT", true),
            ("GPL-3.0-only/MIT", true),
            ("MIT AND GPL-3.0-only", false),
            ("(GPL-3.0-only OR MIT) AND Zlib", true),
            ("GPL-3.0-only OR MIT AND ISC", false),
            ("MIT WITH LLVM-exception", true),
            ("ISC WITH LLVM-exception OR (Zlib)", true),
        ] {
            assert_eq!(with_mit_and_zlib(expression).unwrap(), expected, "{expression}");
        }
    }

    #[test]
    fn nonsense_is_an_error() {
        for expression in ["", "MIT OR", "(MIT", "MIT)", "MIT Zlib", "AND", "MIT WITH"] {
            assert!(with_mit_and_zlib(expression).is_err(), "{expression}");
        }
    }
}

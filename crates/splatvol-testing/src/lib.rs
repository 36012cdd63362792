//! Analytic fields and the comparison kit of the tests.

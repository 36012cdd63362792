// Plain: an item without operators.

// Pieces of the part of an interval.
const PIECES: i32 = 2;

fn operate(seen: Seen, appearance: ptr<function, Appearance>) {}

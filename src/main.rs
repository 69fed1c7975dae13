//! The `texray` program: run one command, print the error, set the exit code.

fn main() {}

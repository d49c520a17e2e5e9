
/// Whether it is the turn of a change.
pub fn mutant(number: usize) -> bool {
    static TURN: std::sync::LazyLock<usize> =
        std::sync::LazyLock::new(|| std::env::var("MUTANT").map_or(0, |turn| turn.parse().unwrap_or(0)));
    *TURN == number
}

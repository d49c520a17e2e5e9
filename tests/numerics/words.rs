//! The words of choices and outcomes.

use thurible_core::words::Alternatives;
use thurible_core::{Boundary, Colours, Method, Named, Norm, NsoSolver, Place, Scheme, Status, Unit};

fn each_word_is_its_own<T: Named>() {
    for &value in T::ALL {
        assert_eq!(T::from_name(value.name()), Ok(value));
    }
    let words = T::WORDS.iter().copied();
    assert!(T::ALL.iter().map(|value| value.name()).eq(words));
    assert!(T::from_name("").is_err());
}

#[test]
fn words_and_values_belong_together() {
    each_word_is_its_own::<Method>();
    each_word_is_its_own::<Scheme>();
    each_word_is_its_own::<Boundary>();
    each_word_is_its_own::<Norm>();
    each_word_is_its_own::<NsoSolver>();
    each_word_is_its_own::<Colours>();
    each_word_is_its_own::<Status>();
    each_word_is_its_own::<Place>();
    each_word_is_its_own::<Unit>();
}

#[test]
fn an_unknown_word_is_answered_with_the_known_ones() {
    let listed = Boundary::from_name("closed").map_err(|unknown| unknown.to_string());
    assert_eq!(
        listed,
        Err("\"wall\" or \"periodic\" or \"open\" or \"open_low\" or \"open_high\"".into())
    );
    assert_eq!(
        Alternatives(Boundary::WORDS).to_string(),
        "\"wall\" or \"periodic\" or \"open\" or \"open_low\" or \"open_high\""
    );
}

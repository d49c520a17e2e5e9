//! The tables of what can be chosen for a method.

use thurible_core::method::choices::{Choices, Kind, NoChoices, Numbers, Value};
use thurible_core::{Method, Named, Params};

/// A value of `kind` that is allowed and is not `given`.
fn another(kind: Kind, given: Value<'static>) -> Value<'static> {
    match kind {
        Kind::Flag => Value::Flag(given != Value::Flag(true)),
        Kind::Number(_) => Value::Number(0.125),
        Kind::Count(most) | Kind::Automatic(most) if given == Value::Count(most) => Value::Count(1),
        Kind::Count(most) | Kind::Automatic(most) => Value::Count(most),
        Kind::Word(words) => Value::Word(words.last().copied().unwrap_or_default()),
    }
}

#[test]
fn every_choice_can_be_made_by_its_place() {
    for &method in Method::ALL {
        let mut params = Params::default();
        let table = params.choices(method).table();
        for (index, choice) in table.iter().enumerate() {
            let before = params;
            let wanted = another(choice.kind, before.choices(method).get(index).unwrap());
            assert_ne!(
                before.choices(method).get(index),
                Some(wanted),
                "{}",
                choice.field
            );
            assert!(params.choices_mut(method).set(index, wanted), "{}", choice.field);
            let others = (0..table.len()).filter(|&other| other != index);
            for other in others {
                let [was, is] = [&before, &params].map(|params| params.choices(method).get(other));
                assert_eq!(was, is, "{} changes {}", choice.field, table[other].field);
            }
            assert_eq!(
                params.choices(method).get(index),
                Some(wanted),
                "{}",
                choice.field
            );
            assert_eq!(params.check(), Ok(()), "{}", choice.field);
            assert_eq!(params.find(choice.field), Some((method, index)));
            let group = params.choices(method).group();
            assert_eq!(choice.field, format!("{group}.{}", choice.name));
        }
        assert_eq!(params.choices(method).get(table.len()), None);
        assert!(!params.choices_mut(method).set(table.len(), Value::Flag(true)));
    }
}

#[test]
fn a_value_of_another_kind_is_not_taken() {
    let mut params = Params::default();
    for &method in Method::ALL {
        for (index, choice) in params.choices(method).table().iter().enumerate() {
            let odd = match choice.kind {
                Kind::Flag => Value::Number(1.0),
                _ => Value::Flag(true),
            };
            assert!(!params.choices_mut(method).set(index, odd), "{}", choice.field);
            if matches!(choice.kind, Kind::Word(_)) {
                assert!(!params.choices_mut(method).set(index, Value::Word("")));
            }
        }
    }
    assert_eq!(params, Params::default());
}

#[test]
fn a_method_may_leave_nothing_to_choose() {
    assert_eq!((NoChoices.group(), NoChoices.table().len()), ("nothing", 0));
    assert_eq!(
        (NoChoices.get(0), NoChoices.set(0, Value::Flag(true))),
        (None, false)
    );
    assert_eq!(NoChoices.check(), Ok(()));
}

#[test]
fn kinds_say_what_can_be_chosen() {
    assert_eq!(
        Kind::Automatic(8).to_string(),
        "\"auto\" or a whole number from 1 to 8"
    );
    assert_eq!(
        Kind::Number(Numbers::Below(1.0)).to_string(),
        "a number above 0 and below 1"
    );
}

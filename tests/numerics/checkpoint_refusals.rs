//! Saved bytes that are damaged, or of another solve, are refused.

use crate::checkpoint::{METHODS, by, rest_of, save, with_empty};
use crate::fields;
use crate::fields::cases::Scene;
use thurible_core::checkpoint::{HEAD, Refused, Sink, Source};
use thurible_core::{D2, InputError, Method, NsoSolver, Params, SavedError, Serial, Silent};

#[test]
fn every_changed_byte_is_found() {
    let scene = by(Method::Direct, Scene::small(&[6, 5], "wp", 3));
    let bytes = scene.with::<f32, D2, _>(|solver| {
        solver.step(&Serial, &mut Silent);
        save(solver)
    });
    with_empty::<f32, D2, _>(&scene, 0, |solver| {
        let before = save(solver);
        for place in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1 << (place % 8);
            let expected = match place {
                0..8 => SavedError::NotSaved,
                8..16 => SavedError::Format {
                    given: u64::from_le_bytes(damaged[8..16].try_into().unwrap()),
                },
                16..24 => SavedError::Length {
                    expected: bytes.len(),
                    given: bytes.len(),
                },
                24..32 => SavedError::OtherSolve,
                _ => SavedError::Damaged,
            };
            assert_eq!(solver.restore(&damaged), Err(expected), "byte {place}");
        }
        for length in [0, 1, 7, 40, HEAD - 1, HEAD, bytes.len() - 1] {
            assert_eq!(
                solver.restore(&bytes[..length]),
                Err(SavedError::Length {
                    expected: bytes.len(),
                    given: length
                })
            );
        }
        let longer = [&bytes[..], &[0]].concat();
        assert_eq!(
            solver.restore(&longer),
            Err(SavedError::Length {
                expected: bytes.len(),
                given: longer.len()
            })
        );
        assert!(save(solver) == before, "refused bytes changed the solver");
        assert_eq!(solver.prepare(&Serial), Err(InputError::NoEmitter { index: 0 }));
        let mut few = vec![0; bytes.len() - 1];
        assert_eq!(
            solver.save(&mut few),
            Err(SavedError::Length {
                expected: bytes.len(),
                given: few.len()
            })
        );
        solver.restore(&bytes).unwrap();
    });
}

/// Scalars that no solver would write are refused even where the checksum is right, and change nothing.
#[test]
fn scalars_out_of_range_are_refused() {
    for method in METHODS {
        let scene = by(method, Scene::small(&[6, 5], "wp", 3));
        let (bytes, whole) = scene.with::<f32, D2, _>(|solver| {
            solver.step(&Serial, &mut Silent);
            (save(solver), rest_of(&scene, solver))
        });
        let mut refused = 0;
        for word in 5..HEAD / 8 {
            for value in [9u64, 1 << 40, u64::MAX] {
                let mut forged = bytes.clone();
                forged[word * 8..word * 8 + 8].copy_from_slice(&value.to_le_bytes());
                fields::seal(&mut forged);
                with_empty::<f32, D2, _>(&scene, 0, |solver| {
                    let before = save(solver);
                    match solver.restore(&forged) {
                        Ok(()) => {
                            // A number or count like any other: it may end anywhere, but in order.
                            let _ = solver.step(&Serial, &mut Silent);
                            let _ = solver.finish(&Serial);
                        }
                        Err(error) => {
                            refused += 1;
                            assert_eq!(error, SavedError::Damaged);
                            assert!(
                                save(solver) == before,
                                "{method:?}: word {word} was refused and yet changed the solver"
                            );
                        }
                    }
                });
            }
        }
        assert!(refused >= 6, "{method:?}: {refused} refusals");
        with_empty::<f32, D2, _>(&scene, 0, |solver| {
            let mut sealed = bytes.clone();
            fields::seal(&mut sealed);
            assert!(sealed == bytes, "the test's own seal is wrong");
            solver.restore(&sealed).unwrap();
            assert!(rest_of(&scene, solver) == whole);
        });
    }
}

#[test]
fn bytes_of_another_solve_are_refused() {
    let scene = by(Method::Direct, Scene::small(&[8, 8], "wp", 4));
    let bytes = scene.with::<f32, D2, _>(save);
    let refuses = |what: &str, change: &dyn Fn(&mut Scene)| {
        let mut other = scene.clone();
        change(&mut other);
        let found = with_empty::<f32, D2, _>(&other, 0, |solver| solver.restore(&bytes));
        assert_eq!(found, Err(SavedError::OtherSolve), "{what}");
    };
    refuses("cells", &|scene| scene.cells = vec![8, 9]);
    refuses("boundary", &|scene| scene.boundary = fields::boundaries("pw"));
    refuses("length", &|scene| scene.length = 2.0);
    refuses("dt", &|scene| scene.dt = 0.5);
    refuses("steps", &|scene| scene.steps = 5);
    refuses("keyframes", &|scene| scene.keyframes = vec![3]);
    refuses("force_weight", &|scene| scene.force_weight = 99.0);
    refuses("viscosity", &|scene| scene.viscosity = 1e-3);
    refuses("scheme", &|scene| scene.scheme = thurible_core::Scheme::Central);
    refuses("method", &|scene| scene.params.method = Method::Lbfgs);
    refuses("history", &|scene| scene.params.direct.history = Some(4));
    refuses("history_precision", &|scene| {
        scene.params.direct.history_precision = thurible_core::HistoryPrecision::Half;
    });
    refuses("tolerance", &|scene| scene.params.direct.tolerance = 1e-3);
    refuses("nested", &|scene| scene.params.direct.nested = false);
    assert_eq!(
        with_empty::<f64, D2, _>(&scene, 0, |solver| solver.restore(&bytes)),
        Err(SavedError::OtherSolve)
    );
    let admm = by(Method::Admm, scene.clone());
    let bytes = admm.with::<f32, D2, _>(save);
    let changes: [fn(&mut Params); 11] = [
        |params| params.admm.penalty = 2e3,
        |params| params.admm.relaxation = 1.5,
        |params| params.admm.ao_iterations = 3,
        |params| params.admm.ao_momentum = 0.5,
        |params| params.admm.density_tolerance = 0.1,
        |params| params.admm.nested = false,
        |params| params.admm.nso.solver = NsoSolver::NewtonCg,
        |params| params.admm.nso.tolerance = 1e-4,
        |params| params.admm.nso.cycles = 20,
        |params| params.admm.nso.colours = thurible_core::Colours::PowerOfTwo,
        |params| params.admm.nso.norm = thurible_core::Norm::Plain,
    ];
    for change in changes {
        let mut other = admm.clone();
        change(&mut other.params);
        assert_eq!(
            with_empty::<f32, D2, _>(&other, 0, |solver| solver.restore(&bytes)),
            Err(SavedError::OtherSolve),
            "{:?}",
            other.params.admm
        );
    }
    // What changes no bit is no other solve.
    let mut more = admm.clone();
    (
        more.params.iterations,
        more.params.threads,
        more.params.ceiling,
        more.params.direct.tolerance,
    ) = (99, 4, Some(1), 0.5);
    assert_eq!(
        with_empty::<f32, D2, _>(&more, 0, |solver| solver.restore(&bytes)),
        Ok(())
    );
}

/// Passes so many pieces on and then refuses.
pub struct Short<'a> {
    pub bytes: Vec<u8>,
    from: &'a [u8],
    left: usize,
}

impl Short<'_> {
    fn may(&mut self) -> Result<(), Refused> {
        self.left = self.left.checked_sub(1).ok_or(Refused)?;
        Ok(())
    }
}

impl Sink for Short<'_> {
    fn put(&mut self, bytes: &[u8]) -> Result<(), Refused> {
        assert!(bytes.len() <= HEAD, "more than a head at once");
        self.may()?;
        self.bytes.extend_from_slice(bytes);
        Ok(())
    }
}

impl Source for Short<'_> {
    fn take(&mut self, bytes: &mut [u8]) -> Result<(), Refused> {
        assert!(bytes.len() <= HEAD, "more than a head at once");
        self.may()?;
        self.from.take(bytes)
    }
}

pub fn pieces(from: &[u8], left: usize) -> Short<'_> {
    Short {
        bytes: Vec::new(),
        from,
        left,
    }
}

/// Piece by piece the same bytes go out and come in, and every call that is refused is told.
#[test]
fn pieces_are_the_same_bytes_and_any_may_be_refused() {
    for method in METHODS {
        let scene = by(method, Scene::small(&[14, 9], "wp", 3));
        scene.with::<f64, D2, _>(|solver| {
            solver.step(&Serial, &mut Silent);
            let whole = save(solver);
            let mut calls = 0;
            loop {
                let mut sink = pieces(&[], calls);
                match solver.save_to(&mut sink) {
                    Ok(()) => break assert!(sink.bytes == whole, "{method:?}"),
                    Err(error) => assert_eq!(error, SavedError::Refused),
                }
                calls += 1;
            }
            assert!(calls > 10, "{method:?}: {calls}");
            let rest = rest_of(&scene, solver);
            // Half of a state is none: there is no going on from it.
            assert!(solver.restore_from(&mut pieces(&whole, calls - 1)).is_err());
            assert!(
                solver.prepare(&Serial).is_err() && !solver.is_finished(),
                "{method:?}"
            );
            for left in 0..calls {
                with_empty::<f64, D2, _>(&scene, 0, |solver| {
                    let refused = solver.restore_from(&mut pieces(&whole, left));
                    assert_eq!(
                        refused,
                        Err(SavedError::Refused),
                        "{method:?}: after {left} pieces"
                    );
                });
            }
            with_empty::<f64, D2, _>(&scene, 0, |solver| {
                solver.restore_from(&mut pieces(&whole, calls)).unwrap();
                assert!(rest_of(&scene, solver) == rest, "{method:?}");
            });
        });
    }
}

//! Searches that find what they should.

use super::case::{Scene, replay};
use core::ops::ControlFlow;
use thurible_core::stable_fluids::{Control, Slots};
use thurible_core::{D2, Event, Observer, Serial, Silent, Status, Template, TemplateKind};

/// A blob that a known wind has carried: the search finds a wind of that direction and strength.
#[test]
fn a_wind_is_found_again() {
    let mut scene = Scene::new(&[24, 24], "ww", &[Control::Templates]);
    let wind = |amplitude| Template {
        amplitude,
        ..Template::new(TemplateKind::Wind, [1.0, 1.0, 0.0], 0.5, 5)
    };
    scene.params.initial_velocity = false;
    scene.force_weight = 1e-6;
    scene.templates = vec![wind([0.25, 0.1, 0.0])];
    let mut densities = Vec::new();
    scene.with::<f64, D2, _>(|fluids| replay(fluids, |mut moment| densities.push(moment.density().to_vec())));
    scene.keyframes = vec![densities[3].clone(), densities[5].clone()];
    scene.templates = vec![wind([0.0; 3])];
    scene.params.tolerance = 1e-9;
    scene.params.slots = Slots::States(2);
    scene.with::<f64, D2, _>(|fluids| {
        let mut totals = Vec::new();
        let status = fluids.solve(&Serial, &mut Silent, &mut |progress| {
            totals.push(progress.objective.data)
        });
        assert!(
            status == Status::Converged || status == Status::Stalled,
            "{status:?}"
        );
        assert!(totals.last().unwrap() < &(1e-2 * totals[0]), "{totals:?}");
        let [along, up, _] = fluids.template_amplitude(0, 0).unwrap();
        assert!(
            (along - 0.25).abs() < 0.02 && (up - 0.1).abs() < 0.02,
            "{along} {up}"
        );
        let found = fluids.template(0).unwrap();
        assert_eq!((found.intervals, found.numbers), (1, 2));
        assert!((found.template.radius - 0.5).abs() < 1e-12);
    });
}

#[test]
fn j_falls_by_every_control() {
    let all = [Control::InitialVelocity, Control::Forces, Control::Templates];
    for controls in [&all[..1], &all[1..2], &all[2..], &all[..]] {
        let mut scene = Scene::new(&[16, 16], "ww", controls);
        scene.params.iterations = 12;
        scene.force_weight = 0.01;
        scene.with::<f32, D2, _>(|fluids| {
            let first = fluids.value(&Serial, &mut Silent).unwrap().total();
            let mut last = first;
            fluids.solve(&Serial, &mut Silent, &mut |progress| {
                let total = progress.objective.total();
                assert!(total <= last * (1.0 + 1e-6), "{last} {total}");
                last = total;
                assert!(progress.report.get("evaluations").is_some());
                assert_eq!(progress.report.get("recomputed_steps"), Some(0.0));
            });
            assert!(last < 0.9 * first, "{controls:?}: {first} {last}");
            // What is replayed is what was found.
            assert!((fluids.value(&Serial, &mut Silent).unwrap().total() - last).abs() < 1e-5 * last);
        });
    }
}

#[test]
fn a_search_needs_a_way_back() {
    let scene = Scene::new(&[9, 8], "ww", &[Control::InitialVelocity]).kept(Slots::None);
    scene.with::<f64, D2, _>(|fluids| {
        let progress = fluids.step(&Serial, &mut Silent);
        assert_eq!(progress.status, Some(Status::NotReady));
    });
}

/// Says stop at one piece of work.
struct StopsAt(usize);

impl Observer for StopsAt {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        if event == Event::Work {
            self.0 = self.0.saturating_sub(1);
        }
        if self.0 == 0 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

#[test]
fn an_interrupt_leaves_the_point_that_was_accepted_last() {
    let mut scene = Scene::new(&[16, 16], "ww", &[Control::InitialVelocity]);
    scene.params.iterations = 4;
    let mut within = 0;
    for stop in (20..120).step_by(3) {
        scene.with::<f64, D2, _>(|fluids| {
            let mut last = fluids.value(&Serial, &mut Silent).unwrap().total();
            let status = fluids.solve(&Serial, &mut StopsAt(stop), &mut |progress| {
                if progress.status.is_none() {
                    last = progress.objective.total();
                }
            });
            if status == Status::Cancelled {
                within += 1;
                let left = fluids.value(&Serial, &mut Silent).unwrap().total();
                assert!((left - last).abs() < 1e-9 * last, "{stop}: {last} {left}");
            }
        });
    }
    assert!(within > 5, "{within}");
}

//! Windows: the parts of a long animation that are searched one after the other, each in the memory of one.
//!
//! A window of n steps begins with the density and the velocity where the last one was left, and sees the keyframes that fall in it. Its first
//! m steps are kept, m being the stride, and the next window begins there. The last one ends where the scene does, or its release.
//!
//! A keyframe beyond the window is looked at first: from the window's begin to there the scene is solved in steps so long that the window's memory
//! is enough ([`Ahead`]), and where that way leads within the window is a target of its own. What no keyframe asks for any more is simulated,
//! as is what comes after the release.

use crate::owned::OwnedProblem;
use core::ops::RangeInclusive;
use thurible_core::{Emitter, Supply, Template};

/// `[method] window` and `stride`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Windows {
    /// Steps of a window.
    pub length: usize,
    /// How many steps after a window the next one begins.
    pub stride: usize,
}

/// One window, or a piece that is simulated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Window {
    /// The step of the scene that it begins at.
    pub start: usize,
    /// Its steps.
    pub steps: usize,
    /// How many steps later the next one begins; all of its steps where it is the last.
    pub keeps: usize,
    /// Whether it is the last.
    pub is_last: bool,
    /// The keyframes that it sees, by their number among all steps of keyframes.
    pub keyframes: Vec<usize>,
    /// The emitters that add smoke in it, by their number.
    pub emitters: Vec<usize>,
    /// The way to the next keyframe beyond it.
    pub ahead: Option<Ahead>,
}

/// The way to the next keyframe beyond a window, looked at in steps so long that the window has room for all of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ahead {
    /// Steps of the scene that are one here.
    pub stride: usize,
    /// The numbers of the keyframes on it, each with its long step; that beyond the window comes last.
    pub keyframes: Vec<(usize, usize)>,
    /// Long steps within the window: at the last of them it is to be where the way leads.
    pub within: usize,
}

impl Ahead {
    /// Long steps in all.
    pub fn steps(&self) -> usize {
        self.keyframes.last().map_or(0, |(_, step)| *step)
    }

    /// The step of the window at which it is to be where the way leads.
    pub fn aim(&self) -> usize {
        self.within * self.stride
    }
}

impl Windows {
    /// Those of a problem of more steps than one has.
    pub fn of(self, problem: &OwnedProblem) -> Vec<Window> {
        let end = problem.release.unwrap_or(problem.steps);
        let mut starts = Vec::new();
        if !problem.keyframes.is_empty() {
            let length = self.length.min(end);
            let last = end - length;
            starts.extend((0..last).step_by(self.stride).map(|start| (start, length)));
            starts.push((last, length));
        }
        // The first velocity that no force turned is that of the release.
        let mut at = match (starts.is_empty(), problem.release) {
            (true, _) => Some(0),
            (false, Some(release)) => Some(release - 1),
            (false, None) => None,
        };
        while let Some(start) = at {
            let left = problem.steps - start;
            starts.push((start, self.length.min(left)));
            // What is left has two steps at least.
            at = (left > self.length).then(|| start + (self.length - 1).min(left - 2));
        }
        let nexts = starts.iter().skip(1).map(|&(start, _)| Some(start)).chain([None]);
        let windows = starts.iter().zip(nexts);
        let window = |(&(start, steps), next): (&(usize, usize), Option<usize>)| Window {
            ahead: ahead(problem, start, steps),
            start,
            steps,
            keeps: next.map_or(steps, |next| next - start),
            is_last: next.is_none(),
            keyframes: numbers(&problem.keyframes, |&step| {
                (start + 2..=start + steps).contains(&step)
            }),
            emitters: numbers(&problem.emitters, |emitter| {
                emitter.from < start + steps && emitter.to > start
            }),
        };
        windows.map(window).collect()
    }
}

/// The way to the next keyframe beyond the steps of a window, where it leaves the window after the last keyframe in it.
fn ahead(problem: &OwnedProblem, start: usize, steps: usize) -> Option<Ahead> {
    let from = |step: &usize| step.saturating_sub(start);
    let next = problem.keyframes.iter().position(|step| from(step) > steps)?;
    let far = problem.keyframes.get(next).map(from)?;
    let stride = far.div_ceil(steps);
    let rounded = |step: usize| (step + stride / 2) / stride;
    let within = steps / stride;
    let mut keyframes: Vec<(usize, usize)> = Vec::new();
    for (number, step) in problem.keyframes.iter().enumerate().take(next) {
        let step = rounded(from(step));
        let before = keyframes.last().map_or(1, |(_, before)| *before);
        if step > before && step < rounded(far) {
            keyframes.push((number, step));
        }
    }
    keyframes.push((next, rounded(far)));
    let seen = problem.keyframes.iter().take(next).map(from).max().unwrap_or(0);
    // No force changes where the first long step leads.
    (within > 1 && within * stride > seen).then_some(Ahead {
        stride,
        keyframes,
        within,
    })
}

/// Says of windows that see neither a keyframe nor the way to the next one, since that is too far away for their length.
pub fn blind(windows: &[Window], problem: &OwnedProblem) -> Option<String> {
    let away = |window: &Window| {
        let end = window.start + window.steps;
        let next = problem.keyframes.iter().find(|&&step| step > end)?;
        (!window.is_searched()).then_some((window.start, *next, window.steps))
    };
    let (start, next, steps) = windows.iter().find_map(away)?;
    let far = next - start;
    let least = (2..=far).find(|least| least / far.div_ceil(*least) > 1)?;
    Some(format!(
        "A window of {steps} steps is too short to see from step {start} the way to the keyframe at step {next}: until it is nearer, nothing is searched for. Take `method.window` of {least} or more."
    ))
}

/// The numbers of those that are `there`.
fn numbers<T>(all: &[T], there: impl Fn(&T) -> bool) -> Vec<usize> {
    let found = all.iter().enumerate().filter(|(_, one)| there(one));
    found.map(|(number, _)| number).collect()
}

impl Window {
    /// Whether there is something to search for.
    pub fn is_searched(&self) -> bool {
        !self.keyframes.is_empty() || self.ahead.is_some()
    }

    /// The same, which does without the way ahead unless that leads to a target.
    pub fn with_aim(&self, aimed: bool) -> Self {
        Self {
            ahead: self.ahead.clone().filter(|_| aimed),
            ..self.clone()
        }
    }

    /// The number of the keyframe beyond it to which there is a way.
    pub fn beyond(&self) -> Option<usize> {
        let (number, _) = self.ahead.as_ref()?.keyframes.last()?;
        Some(*number)
    }

    /// The way to the keyframe ahead, as a problem of its own in long steps.
    pub fn way(&self, whole: &OwnedProblem) -> Option<OwnedProblem> {
        let ahead = self.ahead.as_ref()?;
        let (stride, steps) = (ahead.stride, ahead.steps());
        let (start, end) = (self.start, self.start + steps * stride);
        let emitters = whole
            .emitters
            .iter()
            .filter(|emitter| emitter.from < end && emitter.to > start);
        let emitter = |emitter: &Emitter| {
            let from = emitter.from.saturating_sub(start) / stride;
            Emitter {
                from,
                to: (emitter.to.min(end) - start)
                    .div_ceil(stride)
                    .clamp(from + 1, steps),
                supply: match emitter.supply {
                    Supply::Rate(rate) => Supply::Rate(rate * stride as f64),
                    target => target,
                },
                ..*emitter
            }
        };
        let mut schedule = shifted(&whole.schedule, start, end - start);
        schedule.iter_mut().for_each(|(step, _)| *step /= stride);
        schedule.dedup_by_key(|(step, _)| *step);
        let weight = |(number, _): &(usize, usize)| whole.keyframe_weights.get(*number).copied();
        Some(OwnedProblem {
            steps,
            dt: whole.dt * stride as f64,
            keyframes: ahead.keyframes.iter().map(|(_, step)| *step).collect(),
            keyframe_weights: ahead.keyframes.iter().filter_map(weight).collect(),
            emitters: emitters.map(emitter).collect(),
            release: None,
            schedule,
            force_weight: whole.force_weight * stride as f64,
            ..whole.clone()
        })
    }

    /// The emitters that add smoke on that way, by their number.
    pub fn emitters_on_way(&self, whole: &OwnedProblem) -> Vec<usize> {
        let long = self
            .ahead
            .as_ref()
            .map_or(0, |ahead| ahead.steps() * ahead.stride);
        let end = self.start + long;
        numbers(&whole.emitters, |emitter| {
            emitter.from < end && emitter.to > self.start
        })
    }

    /// The steps of the scene whose keyframes are judged by it. That of the first step that is not kept is among them, since what leads there
    /// is; where the way ahead leads is none of them, and all that are seen come before.
    pub fn judges(&self) -> RangeInclusive<usize> {
        let last = if self.is_last { self.steps } else { self.keeps + 1 };
        let aim = self.ahead.as_ref().map(Ahead::aim);
        let last = aim.map_or(last, |aim| last.min(aim - 1));
        self.start + 2..=self.start + last
    }

    /// How many of its forces are kept.
    pub fn forces(&self) -> usize {
        if self.is_last { self.steps - 1 } else { self.keeps }
    }

    /// The part of `whole` that it is.
    pub fn problem(&self, whole: &OwnedProblem) -> OwnedProblem {
        let (start, end) = (self.start, self.start + self.steps);
        let of = |number: &usize| whole.keyframes.get(*number).map(|step| step - start);
        let weight = |number: &usize| whole.keyframe_weights.get(*number).copied();
        let emitter = |number: &usize| {
            let emitter = whole.emitters.get(*number)?;
            Some(Emitter {
                from: emitter.from.saturating_sub(start),
                to: emitter.to.min(end) - start,
                ..*emitter
            })
        };
        // Those that act in one of its forces.
        let template = |template: &Template| {
            let from = template.from.saturating_sub(start);
            (template.to > start && from + 1 < self.steps).then(|| Template {
                from,
                to: template.to.min(end) - start,
                ..*template
            })
        };
        let searched = self.is_searched();
        let aim = self.ahead.as_ref().map(Ahead::aim);
        let weighed: Vec<usize> = self.keyframes.iter().copied().chain(self.beyond()).collect();
        OwnedProblem {
            steps: self.steps,
            keyframes: self.keyframes.iter().filter_map(of).chain(aim).collect(),
            keyframe_weights: weighed.iter().filter_map(weight).collect(),
            keyframe_regions: whole.keyframe_regions && searched,
            emitters: self.emitters.iter().filter_map(emitter).collect(),
            templates: whole.templates.iter().filter_map(template).collect(),
            release: None,
            schedule: if searched {
                shifted(&whole.schedule, start, self.steps)
            } else {
                Vec::new()
            },
            mask: whole.mask && searched,
            ..whole.clone()
        }
    }
}

/// A schedule as a window of so many steps from `start` on sees it: the same factors at the same steps.
fn shifted(schedule: &[(usize, f64)], start: usize, steps: usize) -> Vec<(usize, f64)> {
    if schedule.is_empty() {
        return Vec::new();
    }
    let end = start + steps;
    let within = schedule.iter().filter(|(step, _)| (start..=end).contains(step));
    let ends = [start, end].map(|step| (step, factor(schedule, step)));
    let mut seen: Vec<(usize, f64)> = within.copied().collect();
    for (step, factor) in ends {
        if let Err(place) = seen.binary_search_by_key(&step, |&(step, _)| step) {
            seen.insert(place, (step, factor));
        }
    }
    seen.iter()
        .map(|&(step, factor)| (step - start, factor))
        .collect()
}

/// The factor of a schedule at a step: linear in its logarithm between the pairs, constant beyond them.
fn factor(schedule: &[(usize, f64)], step: usize) -> f64 {
    let next = schedule.partition_point(|&(at, _)| at < step);
    let [before, after] = [next.checked_sub(1), Some(next)].map(|at| at.and_then(|at| schedule.get(at)));
    match (before, after) {
        (Some(&(a, from)), Some(&(b, to))) => {
            let part = (step - a) as f64 / (b - a) as f64;
            (from.ln() + part * (to / from).ln()).exp()
        }
        (Some(&(_, factor)), None) | (None, Some(&(_, factor))) => factor,
        (None, None) => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn starts(problem: &OwnedProblem, length: usize, stride: usize) -> Vec<(usize, usize, usize)> {
        let windows = Windows { length, stride }.of(problem);
        windows
            .iter()
            .map(|window| (window.start, window.steps, window.keeps))
            .collect()
    }

    #[test]
    fn windows_follow_by_the_stride_and_the_last_ends_with_the_scene() {
        let problem = OwnedProblem::new(vec![8, 8], vec![10, 25]);
        assert_eq!(
            starts(&problem, 10, 6),
            [(0, 10, 6), (6, 10, 6), (12, 10, 3), (15, 10, 10)]
        );
        assert_eq!(starts(&problem, 24, 1), [(0, 24, 1), (1, 24, 24)]);
    }

    /// The windows end at the release; from the step before on pieces are simulated, of which none is shorter than two steps.
    #[test]
    fn what_is_released_is_simulated_in_pieces() {
        let problem = OwnedProblem {
            steps: 31,
            release: Some(12),
            ..OwnedProblem::new(vec![8, 8], vec![10])
        };
        let expected = [(0, 10, 2), (2, 10, 9), (11, 10, 9), (20, 10, 9), (29, 2, 2)];
        assert_eq!(starts(&problem, 10, 5), expected);
        for steps in 13..60 {
            let windows = Windows {
                length: 10,
                stride: 5,
            }
            .of(&OwnedProblem {
                steps,
                ..problem.clone()
            });
            assert!(
                windows.iter().all(|window| window.steps >= 2 && window.keeps > 0),
                "{steps}"
            );
            assert_eq!(windows.iter().map(|window| window.keeps).sum::<usize>(), steps);
            assert!(
                windows
                    .iter()
                    .all(|window| window.is_searched() == (window.start < 11))
            );
        }
    }

    /// A way of which no long step but the first is in the window is none.
    #[test]
    fn a_window_that_is_too_short_is_told() {
        let problem = OwnedProblem::new(vec![8, 8], vec![80]);
        let of = |length: usize| {
            let stride = length / 2;
            Windows { length, stride }.of(&problem)
        };
        let short = of(10);
        assert!(!short[0].is_searched() && short[6].ahead.is_some());
        let said = blind(&short, &problem).unwrap_or_default();
        assert!(
            said.contains("of 10 steps") && said.contains("of 14 or more"),
            "{said}"
        );
        assert!(of(14)[0].is_searched() && blind(&of(14), &problem).is_none());
        let seen = OwnedProblem::new(vec![8, 8], vec![8]);
        assert!(blind(&Windows { length: 4, stride: 2 }.of(&seen), &seen).is_none());
    }

    #[test]
    fn a_window_sees_its_part_of_the_scene() {
        let emitter = |from, to| Emitter {
            from,
            to,
            supply: Supply::Rate(0.1),
            velocity: None,
        };
        let whole = OwnedProblem {
            emitters: vec![emitter(0, 5), emitter(3, 14), emitter(20, 40)],
            keyframe_weights: vec![1.0, 2.0, 3.0],
            schedule: vec![(0, 1.0), (20, 1e2), (30, 1.0)],
            ..OwnedProblem::new(vec![8, 8], vec![11, 16, 40])
        };
        let windows = Windows {
            length: 10,
            stride: 5,
        }
        .of(&whole);
        let seen = windows[2].problem(&whole);
        assert_eq!(
            (windows[2].start, &seen.keyframes, &seen.keyframe_weights),
            (10, &vec![6, 9], &vec![2.0, 3.0])
        );
        // The first is judged by the window before, in which what leads to it is kept.
        assert!(windows[1].judges().contains(&11) && !windows[2].judges().contains(&11));
        assert_eq!(seen.emitters, [emitter(0, 4)]);
        let expected = [(0, 10.0), (10, 1e2)];
        for (seen, expected) in seen.schedule.iter().zip(expected) {
            assert!(
                seen.0 == expected.0 && (seen.1 / expected.1 - 1.0).abs() < 1e-12,
                "{seen:?}"
            );
        }
        let judged = windows.iter().flat_map(|window| {
            whole
                .keyframes
                .iter()
                .filter(|step| window.judges().contains(step))
                .copied()
        });
        assert_eq!(judged.collect::<Vec<_>>(), whole.keyframes);
    }
}

//! Chapter 5: the flow behind frames of smoke, and what it is good for.

mod again;
mod changed;
mod slices;
mod smaller;
mod tracks;

use super::figure::{Figure, room};

pub(super) const FIGURES: [Figure; 10] = [
    Figure::new(
        ("fig5.1", "Figure 5.1: the flow in a slice"),
        "Puffs that rise in turbulent air, simulated on 96 x 96 x 192 cells with four steps a frame and restricted to 48 x 48 x 96 cells and 60 frames (at full size; the thesis has 50 x 100 x 50 cells, \
         1.1 times as many, and 118 frames, and looks at slice 25). All rows but the last are the thesis' methods with the weights of its Table 5.1.",
        "Norm error, angle and direction of three methods in slice 25 of 50 x 100 x 50 cells; colours to about 0.6 and 90 degrees.",
        room(570.0, 1700.0),
        slices::figure_1,
    ),
    Figure::new(
        (
            "fig5.2",
            "Figure 5.2 and Table 5.1: errors of the flow by five methods",
        ),
        "The capture of figure 5.1. Means over the last two thirds of the pairs; re-advection is how far the first frame, carried to the end, is from the last one, in parts of it.",
        "Axes to an RMS of 1.0 and 100 degrees: ADMM with all terms is lowest and smooth, its angle near 60 degrees at best; without kinetic energy mostly worse; Horn-Schunck nearly random.",
        room(570.0, 1700.0),
        tracks::figure_2,
    ),
    Figure::new(
        ("fig5.3", "Figure 5.3: a capture at half its size"),
        "Puffs from a vent rise round a solid ball, 48 x 48 x 96 cells and 61 frames at full size (the thesis: 100 x 200 x 100, 9 times as many, and 150 frames). The tracker knows of no ball. Frames are \
         blurred, then made half as large by means over 2 x 2 x 2 cells. alpha 1e-4, beta 1.",
        "Native size, and half size with blurs of 0, 0.5 and 1; RMS to 0.1, angles to 100 degrees over 150 frames: a strong blur drifts faster. No units.",
        room(1500.0, 1700.0),
        smaller::figure_3,
    ),
    Figure::new(
        ("fig5.4", "Figure 5.4: captured smoke, carried again"),
        "The first frame of figure 5.1's capture, carried by the flow that each method finds.",
        "Re-advection through Horn-Schunck, Horn-Schunck with a price of divergence, ADMM; pictures only.",
        room(570.0, 1700.0),
        again::figure_4,
    ),
    Figure::new(
        ("fig5.5", "Figure 5.5: simulated on from captured states"),
        "The capture of figure 5.1, and dye that sinks into still water (48 x 48 x 48 cells, 41 frames at full size; the thesis' bloom has 200 x 200 x 200): tracked by our own method, and simulated on for ten frames from the state of every tenth.",
        "Bloom and smoke, from every tenth frame: the bloom follows for over a second, the smoke parts sooner; no numbers.",
        room(560.0, 1700.0),
        again::figure_5,
    ),
    Figure::new(
        ("fig5.6", "Figure 5.6: smoke on finer cells"),
        "The capture of figure 5.1, tracked with the thesis' weights for real captures (alpha 0.005, beta 2.5), carried again, on cells twice as fine, and on those with the turbulence of `thurible upsample`.",
        "Frames 16, 40, 65 and 97 of smoke; alpha 0.005, beta 2.5; no errors.",
        room(400.0, 1700.0),
        again::figure_6,
    ),
    Figure::new(
        ("fig5.7", "Figure 5.7: a bloom on finer cells"),
        "The same of the bloom of figure 5.5.",
        "Frames 130, 145, 160 and 175 of the bloom; alpha 0.005, beta 2.5; no errors.",
        room(160.0, 700.0),
        again::figure_7,
    ),
    Figure::new(
        ("fig5.8", "Figure 5.8: restarted with a new ball"),
        "The capture of figure 5.1, tracked by our own method, and simulated on from a quarter of its time, as it was and with a ball in its way.",
        "A restart with a sphere that was not there; pictures only.",
        room(400.0, 1700.0),
        changed::figure_8,
    ),
    Figure::new(
        ("fig5.9", "Figure 5.9: put round a new ball"),
        "The same, but the captured flow is put round the ball: by importance, so that it stays where there is smoke, and alike everywhere. Changes are means over steps.",
        "Remapping by importance; needed for extreme changes only; pictures only.",
        room(400.0, 1700.0),
        changed::figure_9,
    ),
    Figure::new(
        ("fig5.10", "Figure 5.10: curl noise with and without guidance"),
        "Simulated on from a quarter of the time of figure 5.1's capture, stirred by curl noise, without and with guidance by the captured flow: radius 2 cells, alpha 0.001, beta 0 (in a box without solid \
         cells guidance is in closed form, so that lambda plays no part). Bands are split by a Gaussian of the radius, in the last flow.",
        "Radius 2, lambda 1000, alpha 0.001, beta 0; pictures only.",
        room(420.0, 1700.0),
        changed::figure_10,
    ),
];

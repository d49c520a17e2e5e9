//! Chapter 3: density from photographs.

mod phantom;
mod seen;
mod shepp_logan;
mod subjects;

use super::figure::{Figure, plane, room};

pub(super) const FIGURES: [Figure; 5] = [
    Figure::new(
        ("fig3.7", "Figure 3.7: a phantom from 16 views"),
        "The modified Shepp-Logan phantom of 256 x 256 cells, photographed by 16 orthographic cameras; the error is over all cells. Weights of priors are in proportion to the side. The thesis does \
         not demand that density is at least 0, so its rows do not either.",
        "256 x 256 cells, 16 orthographic views, 47 to 55 s each; RMS of SART 0.104, the walk 0.090, L2 0.085, TV 0.085, SAD 0.080.",
        plane(20.0, 1.0),
        shepp_logan::figure_7,
    ),
    Figure::new(
        ("fig3.8", "Figures 3.8 and 3.9: a tube of smoke by 16 cameras"),
        "A jet of our own that rises steadily, simulated on twice the cells and restricted to 32 x 32 x 80 (at full size); 20 mutations for each cell and camera. Accepted are samples that were \
         recorded. Where the thesis' figures show how samples gather, the curve of the residual stands here.",
        "16 cameras, SAD, 100 million mutations in 65000 chains, 6 minutes a frame on one core: positive samples first, then a mixture.",
        room(100.0, 650.0),
        subjects::figure_8,
    ),
    Figure::new(
        (
            "fig3.10",
            "Figures 3.10 and 3.11: smoke by 15 cameras, without a prior",
        ),
        "The puffs of figure 5.2 in the middle of their time, 48 x 48 x 96 cells (at full size); 20 mutations for each cell and camera, in 10000 and in 65000 chains.",
        "15 views, no prior, 200 million mutations in 10000 chains (figure 3.11: 65000), 14 minutes a frame; 5 to 10 % accepted.",
        room(390.0, 1700.0),
        subjects::figure_10,
    ),
    Figure::new(
        ("fig3.12", "Figure 3.12: a bloom of dye"),
        "Dye of our own that sinks into still water, 48 x 48 x 48 cells (at full size; the thesis has 200 x 200 x 200, 72 times as many), 15 cameras; 20 mutations for each cell and camera.",
        "SAD, 200 x 200 x 200 cells, 400 million mutations in 10000 chains, 31 minutes a frame; 5 to 10 % accepted.",
        room(130.0, 700.0),
        subjects::figure_12,
    ),
    Figure::new(
        ("fig3.13", "Figure 3.13: dye by five cameras"),
        "The bloom of figure 3.12 late, by five cameras, without a prior and with SAD. The view half way between the first two cameras, which measured nothing, is compared with what a camera there sees.",
        "Dye powder by five cameras: no prior, SAD of the volume, SAD of the images; pictures only.",
        room(120.0, 700.0),
        subjects::figure_13,
    ),
];

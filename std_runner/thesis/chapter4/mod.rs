//! Chapter 4: sharp images from blurred ones.

mod convergence;
mod images;
mod photographs;
mod restored;
mod shots;
mod turned;

use super::figure::{Figure, plane};

pub(super) const FIGURES: [Figure; 7] = [
    Figure::new(
        ("fig4.3", "Figures 4.3 to 4.7: photographs in motion"),
        "The thesis' photographs are not ours, so images are drawn here and below: 192 x 192 pixels at full size, linear light, noise of 0.005. Lines and wheels stand for the train, lamps that burn \
         out for the car (saturated pixels are left out), spray for the fountain; each is moved by 11 pixels. Weights of the priors are the thesis', which were chosen for its images; 100 mutations a pixel.",
        "Photographs; 100 mutations a pixel, sigma 32 pixels; gamma 0.001, 0.0015 and 0.003, sparse 0.00025, 0.0005 and 0.0001, TV 0.00025. No errors.",
        plane(200.0, 1.0),
        photographs::figure_3,
    ),
    Figure::new(
        ("fig4.8", "Figure 4.8: convergence beside the convex optimum"),
        "Flat shapes of 128 x 128 pixels, moved by 11 pixels; anisotropic total variation with gamma 1e-3, in double precision. Objectives are those of our image, so that only which of the two is lower \
         can be held against the thesis.",
        "Objective 26.42 by the walk after 300 mutations a pixel, whose step falls to 4e-9, and 26.69 by the primal-dual method; after 50 mutations a pixel the walk gains 0.08 %.",
        plane(25.0, 1.2),
        convergence::figure_8,
    ),
    Figure::new(
        ("fig4.9", "Figure 4.9: out of focus"),
        "Lines and wheels, blurred by a disc of radius 5.",
        "The sparse prior with gamma 1e-3; pictures only.",
        plane(55.0, 1.0),
        photographs::figure_9,
    ),
    Figure::new(
        ("fig4.10", "Figure 4.10: in colour"),
        "Three channels, moved by 11 pixels: total variation of each colour, and of all together, which charges an edge once.",
        "Colour by mtv; pictures only.",
        plane(30.0, 2.0),
        photographs::figure_10,
    ),
    Figure::new(
        ("fig4.11", "Figure 4.11: a kernel for each place"),
        "The camera was turned, so that corners move by 9 pixels and the middle not at all: 144 kernels.",
        "A kernel that varies by rotation; pictures only.",
        plane(10.0, 1.0),
        photographs::figure_11,
    ),
    Figure::new(
        ("fig4.12", "Figure 4.12: five colours"),
        "An image of five colours, 128 x 128 pixels, blurred by a disc of radius 4. Clusters know that there are five, not which.",
        "TV 32.0 dB (31.91 in the text), clusters 32.7 dB.",
        plane(20.0, 1.0),
        photographs::figure_12,
    ),
    Figure::new(
        ("speed", "Sections 4.2 and 4.4: acceptance and seconds"),
        "0.7 million pixels of flat shapes, a kernel of 21 x 21 numbers, 100 mutations a pixel, one core.",
        "30 to 40 % accepted; 0.7 million pixels and a kernel of 21 x 21 in 126 s.",
        plane(140.0, 10.0),
        photographs::speed,
    ),
];

"""Writes the volumes beside this file by OpenVDB's own Python module (Debian: python3-openvdb, under /usr/bin/python3)."""

import pathlib

import numpy as np
import pyopenvdb as vdb

here = pathlib.Path(__file__).parent
side = 20
x, y, z = np.meshgrid(*[np.arange(side) + 0.5] * 3, indexing="ij")
density = np.clip(6 - np.sqrt((x - 8) ** 2 + (y - 10) ** 2 + (z - 12) ** 2), 0, 1).astype("f4")
for half in (False, True):
    grid = vdb.FloatGrid()
    grid.copyFromArray(density, tolerance=0.0)
    grid.name = "density"
    grid.transform = vdb.createLinearTransform(voxelSize=0.05)
    grid.saveFloatAsHalf = half
    grid.gridClass = vdb.GridClass.FOG_VOLUME
    velocity = vdb.Vec3SGrid()
    velocity.copyFromArray(np.stack([density, 0 * density, 0 * density], -1))
    velocity.name = "velocity"
    velocity.saveFloatAsHalf = half
    vdb.write(str(here / ("blosc_half.vdb" if half else "blosc_float.vdb")), grids=[velocity, grid])
ball = vdb.createLevelSetSphere(radius=6.0, center=(8, 9, 10))
ball.name = "surface"
vdb.write(str(here / "level_set.vdb"), grids=[ball])

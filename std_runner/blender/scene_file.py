# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene of thurible from objects of Blender: meshes beside a file that names them."""

import json
import pathlib

import bpy
from mathutils import Vector

# The key of a shape that is a mesh, and what says that its lengths are those of the scene, z up.
MESH = "mesh"
PLACED = 'fit = "world", up = "z"'
LEAST_CELLS = 4


class Refused(Exception):
    """What the user has to change, in a sentence."""


def meshes(collection):
    """Objects of a collection that have a surface."""
    if collection is None:
        return []
    kinds = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
    return [thing for thing in collection.all_objects if thing.type in kinds]


def domain(settings):
    """The low corner of the box and its sides, in world units."""
    if settings.domain is None:
        raise Refused("Choose a domain: an object whose bounding box is where the smoke may be")
    corners = [settings.domain.matrix_world @ Vector(corner) for corner in settings.domain.bound_box]
    low = [min(corner[axis] for corner in corners) for axis in range(3)]
    high = [max(corner[axis] for corner in corners) for axis in range(3)]
    sides = [high[axis] - low[axis] for axis in range(3)]
    if min(sides) <= 0:
        raise Refused(f"The domain {settings.domain.name} is flat; choose a box")
    return low, sides


def grid(settings):
    """The low corner, the longest side and the cells."""
    low, sides = domain(settings)
    longest = max(sides)
    side = longest / settings.resolution
    cells = [max(LEAST_CELLS, round(length / side)) for length in sides]
    cells[sides.index(longest)] = settings.resolution
    return low, longest, cells


def frame_rate(scene):
    return scene.render.fps / scene.render.fps_base


def write_obj(path, things, low):
    """Writes the surfaces of objects, as modifiers leave them, relative to the corner `low`."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    count, lines = 0, []
    for thing in things:
        shown = thing.evaluated_get(depsgraph)
        mesh = shown.to_mesh()
        mesh.calc_loop_triangles()
        for vertex in mesh.vertices:
            x, y, z = thing.matrix_world @ vertex.co
            lines.append(f"v {x - low[0]:.9g} {y - low[1]:.9g} {z - low[2]:.9g}")
        for triangle in mesh.loop_triangles:
            lines.append("f " + " ".join(str(1 + count + index) for index in triangle.vertices))
        count += len(mesh.vertices)
        shown.to_mesh_clear()
    if not lines:
        raise Refused(f"{', '.join(thing.name for thing in things)} has no faces; choose objects with a surface")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def shape(name):
    return f"{MESH} = {json.dumps(name)}, {PLACED}"


def by_frame(settings, scene):
    """The objects of the keyframes by their frames, ascending."""
    found = {}
    for thing in meshes(settings.keyframes):
        frame = thing.thurible_frame or scene.frame_end
        found.setdefault(frame, []).append(thing)
    if not found:
        raise Refused("Choose a collection of keyframes with at least one object")
    for frame, things in found.items():
        if not scene.frame_start + 2 <= frame <= scene.frame_end:
            raise Refused(
                f"{things[0].name} is a keyframe at frame {frame}; choose one from {scene.frame_start + 2} to {scene.frame_end}"
            )
    return dict(sorted(found.items()))


def weight(settings, length, dt):
    """The weight of force in the scene's units: that of a box and steps of length 1, times dt^4 / length^2, since a force is an acceleration."""
    return settings.force_weight * dt**4 / length**2


def write(context, folder):
    """Writes scene.toml and its meshes into `folder`; the answer is the path of the scene."""
    scene, settings = context.scene, context.scene.thurible
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    low, longest, cells = grid(settings)
    keyframes, sources, solids = by_frame(settings, scene), meshes(settings.source), meshes(settings.solids)
    if not sources:
        raise Refused("Choose a collection for the source with at least one object: the smoke at the first frame")
    steps, dt = scene.frame_end - scene.frame_start, 1 / frame_rate(scene)
    current = scene.frame_current
    try:
        scene.frame_set(scene.frame_start)
        write_obj(folder / "source.obj", sources, low)
        if solids:
            write_obj(folder / "solids.obj", solids, low)
        for frame, things in keyframes.items():
            scene.frame_set(frame)
            write_obj(folder / f"keyframe_{frame:04}.obj", things, low)
    finally:
        scene.frame_set(current)
    lines = [
        "# Written by the Blender extension of thurible.",
        f"[grid]\ncells = {cells}\nlength = {longest!r}",
        f"[time]\nsteps = {steps}\ndt = {dt!r}",
        f"[source]\n{shape_lines('source.obj')}",
    ]
    if solids:
        lines.append(f"[[obstacle]]\n{shape_lines('solids.obj')}")
    for frame in keyframes:
        lines.append(f"[[keyframe]]\nstep = {frame - scene.frame_start}\n{shape_lines(f'keyframe_{frame:04}.obj')}")
    lines.append(f"[control]\nforce_weight = {weight(settings, longest, dt)!r}")
    if settings.buoyancy:
        lines.append(f"[flow]\nbuoyancy = {settings.buoyancy * longest / dt**2!r}")
    lines.append(f"[method]\niterations = {settings.iterations}\n[output]\nframes = false\n")
    path = folder / "scene.toml"
    path.write_text("\n\n".join(lines), encoding="utf-8")
    return path


def shape_lines(name):
    """A shape as lines of a table."""
    return shape(name).replace(", ", "\n")


